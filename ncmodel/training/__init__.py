"""From a data folder and ranking pairs to trained networks."""
