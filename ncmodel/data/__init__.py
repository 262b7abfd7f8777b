"""What stages exchange on disk: items, data folders, ranking pairs."""
