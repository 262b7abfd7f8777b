"""Reports: HTML pages, plots, contact sheets, tables."""
