"""The learned model at work: maps, equations 1-5, scores, the search for thresholds."""
