"""The published Neural Contours code's way: its weights, its folders, and drawings exactly as it makes them."""
