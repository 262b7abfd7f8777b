"""Comparing sets of line segments on a mesh."""

from collections import defaultdict

import numpy as np

from ncmodel.types import Floats, Ints


def matched(face: Ints, points: Floats, other_face: Ints, other_points: Floats, tolerance: float = 1e-5) -> int:
    """How many segments have a partner of their own among the others: on the same face, with the same end points."""
    waiting = defaultdict(list)
    for f, p in zip(other_face.tolist(), other_points, strict=True):
        waiting[f].append(p)
    count = 0
    for f, p in zip(face.tolist(), points, strict=True):
        for n, q in enumerate(waiting[f]):
            if min(np.abs(p - q).max(), np.abs(p - q[::-1]).max()) <= tolerance:
                waiting[f].pop(n)
                count += 1
                break
    return count


def agreement(face: Ints, points: Floats, other_face: Ints, other_points: Floats, tolerance: float = 1e-5) -> float:
    """The smaller of the shares of each set that has partners in the other; 1 for two empty sets."""
    if max(len(face), len(other_face)) == 0:
        return 1.0
    return matched(face, points, other_face, other_points, tolerance) / max(len(face), len(other_face))
