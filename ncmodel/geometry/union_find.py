"""Disjoint sets in an array of parents."""

from numba import njit

from ncmodel.types import Ints


@njit(cache=True, nogil=True)
def root(parent: Ints, i: int) -> int:
    """The representative of i's set; shortens the way to it."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i
