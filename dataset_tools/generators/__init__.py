"""Generators of shapes: functions from a random generator to a surface, a module for things of a kind."""
