"""A shape and a view of it: what a scene requires is computed when it is asked for, and once."""
