"""The commands `ncontours evaluate`, `bench` and `demo`."""
