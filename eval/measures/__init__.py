"""Drawings against drawings: measures, references, tables with intervals."""
