"""Mesh files to meshes: readers, triangulation, welding."""
