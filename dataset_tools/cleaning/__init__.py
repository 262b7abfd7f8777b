"""Dirty meshes to clean ones, and which of them are the same shape."""
