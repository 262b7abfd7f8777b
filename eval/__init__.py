"""Drawings against drawings: metrics, baselines, tables, reports."""
