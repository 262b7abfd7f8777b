"""Readers given damaged files: each must read them or refuse them in one line."""
