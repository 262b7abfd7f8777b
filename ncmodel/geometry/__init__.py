"""Differential quantities of triangle meshes, rays and pixels: arrays in, arrays out."""
