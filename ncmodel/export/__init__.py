"""Strokes on a page, as files and as ink: SVG, PDF, PNG, the order of a pen."""
