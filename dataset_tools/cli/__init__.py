"""The commands `ncontours dataset` and `ncontours crowd`."""
