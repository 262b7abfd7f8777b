"""Disjoint sets in an array of parents."""

from ncmodel.jit import kernel
from ncmodel.types import Ints


@kernel
def root(parent: Ints, i: int) -> int:
    """The representative of i's set; shortens the way to it."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i
