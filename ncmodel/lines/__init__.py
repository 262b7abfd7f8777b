"""Where lines run on a surface, which of them are seen, and how their segments hang together."""
