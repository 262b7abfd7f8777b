"""The networks, their losses, presets and checkpoints."""
