"""Everything made up: shapes, artists, participants, and trials of the rules on them."""
