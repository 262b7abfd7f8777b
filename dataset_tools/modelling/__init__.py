"""Tools that shapes are modelled with: signed distances that are sculpted, surfaces of patches, and worn finishes."""
