"""The networks: image translation branch, neural ranking module, losses, checkpoints."""
