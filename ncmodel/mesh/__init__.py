"""Vertices and triangles to meshes in object space: welding, stitching, surfaces through points."""
