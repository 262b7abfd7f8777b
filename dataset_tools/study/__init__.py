"""The perceptual study: two methods' drawings side by side."""
