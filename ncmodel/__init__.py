"""Neural Contours: learned line drawings of 3D shapes."""
