"""Faces that lie on each other, corner on corner: files hold parts twice, or thousands of times.

Copies of a face hide, and are cut by, the same as the face itself, but a ray or a plane that meets one meets all.
"""

import numpy as np
from numpy.typing import NDArray

from ncmodel.geometry.normals_areas import Indices, check_columns
from ncmodel.jit import kernel
from ncmodel.types import Floats, Ints, Mask


def distinct_faces(vertices: Floats, faces: Indices) -> Ints | None:
    """Which faces have no copy before them: one with corners at the same three positions, in any order.

    Positions are compared by a hash of 64 bits: two different ones of n faces pass for copies in n^2 of 2^64 cases.

    Args:
        vertices: (V, 3).
        faces: (F, 3).

    Returns:
        (D,) face indices in ascending order; None if all faces are distinct, so that nothing need be copied.
    """
    # Adding 0 makes -0 the same as 0, whose bits differ.
    first = _first_of_kind(np.ascontiguousarray(vertices + 0.0).view(np.uint64), faces)
    return None if first.all() else np.flatnonzero(first)


@kernel
def scrambled(x: np.uint64) -> np.uint64:
    """A 64-bit hash of a number (the finaliser of Steele et al. 2014)."""
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


@kernel
def _first_of_kind(bits: NDArray[np.uint64], faces: Indices) -> Mask:
    check_columns(bits, 3)
    check_columns(faces, 3)
    key = np.empty(len(bits), np.uint64)
    for v in range(len(bits)):
        key[v] = scrambled(scrambled(scrambled(bits[v, 0]) + bits[v, 1]) + bits[v, 2])
    places = 2
    while places < 2 * len(faces):
        places *= 2
    # Open addressing; 0 is an empty place, and no face's key.
    table, last = np.zeros(places, np.uint64), np.uint64(places - 1)
    first = np.zeros(len(faces), np.bool_)
    for f in range(len(faces)):
        kind = scrambled(key[faces[f, 0]] + key[faces[f, 1]] + key[faces[f, 2]]) | np.uint64(1 << 63)
        place = kind & last
        while table[place] != np.uint64(0) and table[place] != kind:
            place = (place + np.uint64(1)) & last
        first[f] = table[place] == np.uint64(0)
        table[place] = kind
    return first
