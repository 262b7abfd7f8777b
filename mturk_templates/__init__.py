"""Jinja2 templates of the questionnaires (package data only)."""
