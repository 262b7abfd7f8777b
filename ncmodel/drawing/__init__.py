"""From a shape and a plan to strokes: thresholds, visibility, chains, and the drawing they make."""
