"""The views of a shape, the 264 candidate drawings of a view, the 8 selected, and what they look like."""
