"""Large faces cut into pieces where their boxes lie in each other, before a tree of boxes is built for rays.

A ray is held against every face in whose box it is before its first hit. The boxes of 10,000 pages that meet at one
edge all contain that edge's surroundings; those of smaller pieces don't (early split clipping, Ernst and Greiner 2007).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ncmodel.jit import kernel
from ncmodel.types import Ints

CROWDED = 100.0
"""Faces whose boxes contain a point of the scene, on average, from which on large ones are cut."""
ROOMY = 16.0
"""Pieces in whose boxes a point may be when the cutting ends."""
MOST_PIECES = 1 << 18
"""More than there are faces, at most."""

_Singles = NDArray[np.float32]
_Indices = NDArray[np.uint32]


@dataclass(frozen=True, eq=False)
class Pieces:
    """Triangles that cover faces.

    Attributes:
        corners: (P, 3, 3) their corners' positions.
        face: (P,) the face that each is part of.
        weights: (P, 3, 3) the barycentric weights of its corners there.
    """

    corners: _Singles
    face: Ints
    weights: _Singles

    def in_face(self, piece: Ints, u: _Singles, v: _Singles) -> tuple[_Singles, _Singles]:
        """The second and third weights in the face of points with weights u and v in (N,) pieces."""
        weights = self.weights[piece]
        inside = (
            weights[:, 0] + u[:, None] * (weights[:, 1] - weights[:, 0]) + v[:, None] * (weights[:, 2] - weights[:, 0])
        )
        return inside[:, 1], inside[:, 2]


def early_split(vertices: _Singles, faces: _Indices) -> Pieces | None:
    """Cut the largest faces at the middle of their longest sides, again and again.

    Args:
        vertices: (V, 3).
        faces: (F, 3), at least one.

    Returns:
        The pieces; None where boxes are no more in each other than is common, so that faces stay as they are.
    """
    crowd, room = _volumes_around(vertices, faces)
    if crowd <= CROWDED * room:
        return None
    pieces = Pieces(
        vertices[faces], np.arange(len(faces)), np.broadcast_to(np.eye(3, dtype=np.float32), (len(faces), 3, 3))
    )
    volume = _volumes(pieces.corners)
    while volume.sum() > ROOMY * room:
        large = np.flatnonzero(volume >= volume.max() / 2.0)
        if len(volume) + len(large) > len(faces) + MOST_PIECES:
            break
        halves = _halved(pieces, large)
        kept = np.delete(np.arange(len(volume)), large)
        volume = np.concatenate([volume[kept], _volumes(halves.corners)])
        pieces = Pieces(
            np.concatenate([pieces.corners[kept], halves.corners]),
            np.concatenate([pieces.face[kept], halves.face]),
            np.concatenate([pieces.weights[kept], halves.weights]),
        )
    return pieces


def _halved(pieces: Pieces, some: Ints) -> Pieces:
    """Both halves of some pieces, cut at the middle of the longest side."""
    corners, weights = pieces.corners[some], pieces.weights[some]
    side = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).argmax(axis=1)
    turned = (side[:, None] + np.arange(3)) % 3
    halves = []
    for values in (corners, weights):
        a, b, c = np.take_along_axis(values, turned[:, :, None], axis=1).swapaxes(0, 1)
        # The sum is the same from both ends, so that neighbours are cut at the same point.
        middle = (a + b) / np.float32(2)
        halves.append(np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)]))
    return Pieces(halves[0], np.tile(pieces.face[some], 2), halves[1])


def _volumes(corners: _Singles) -> NDArray[np.float64]:
    """(n,) volume of the box around each row of points (n, m, 3)."""
    return np.asarray(np.ptp(corners, axis=1).astype(np.float64).prod(axis=1))


@kernel
def _volumes_around(vertices: _Singles, faces: _Indices) -> tuple[float, float]:
    """The sum of the volumes of the faces' boxes, and the volume of the box around them all."""
    total, sides = 0.0, np.zeros(3)
    lowest, highest = np.full(3, np.inf), np.full(3, -np.inf)
    for f in range(len(faces)):
        for axis in range(3):
            a, b, c = vertices[faces[f, 0], axis], vertices[faces[f, 1], axis], vertices[faces[f, 2], axis]
            low, high = min(a, b, c), max(a, b, c)
            sides[axis] = high - low
            lowest[axis], highest[axis] = min(lowest[axis], low), max(highest[axis], high)
        total += sides[0] * sides[1] * sides[2]
    return total, (highest[0] - lowest[0]) * (highest[1] - lowest[1]) * (highest[2] - lowest[2])
