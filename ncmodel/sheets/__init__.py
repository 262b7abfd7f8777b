"""Sheets: views side by side, at a size on paper."""
