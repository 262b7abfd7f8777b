"""Simulated artists: what there is to draw of a view, what each of them takes of it, and how their hands draw it."""
