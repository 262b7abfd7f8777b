"""Mesh files to vertices and triangles, as they are in the file."""
