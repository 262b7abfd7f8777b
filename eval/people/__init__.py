"""Drawings by people: where they were seen from, how scans become references, how published collections are read."""
