"""The self-hosted site on which participants answer."""
