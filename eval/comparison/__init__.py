"""The test bench: all methods on the same views, beside what could have been chosen."""
