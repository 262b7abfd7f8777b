"""The `ncontours` command, and the commands of this package."""
