"""The views of a shape, the 264 candidate drawings of a view, and the 8 selected."""
