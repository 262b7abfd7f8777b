"""Meshes to votes: cleaning, views, candidates, selection, questionnaires, aggregation."""
