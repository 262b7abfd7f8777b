"""The command line: the top layer, which imports everything and which nothing imports."""
