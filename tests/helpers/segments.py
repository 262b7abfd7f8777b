"""Comparing sets of line segments on a mesh."""

from collections import defaultdict

import numpy as np

from ncmodel.scene.view import View
from ncmodel.types import Floats, Ints, LineFamily, LineSet
from tests.helpers import spec_oracle
from tests.helpers.spec_oracle import Segment


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


def expected_segments(view: View, family: LineFamily, threshold: float = 0.0) -> list[Segment]:
    """The oracle's segments from the view's own vertex quantities, at a raw threshold (suggestive contours alone)."""
    vertices, faces, surface = view.mesh.vertices, view.mesh.faces, view.surface
    nv = view.n_dot_v
    if family is LineFamily.CONTOURS:
        return spec_oracle.zero_set(vertices, faces, nv, view.kr, None, None)
    if family is LineFamily.SUGGESTIVE:
        return spec_oracle.zero_set(vertices, faces, view.kr, view.sc_num - threshold * nv, nv, nv)
    if family is LineFamily.APPARENT:
        t1 = view.t1[:, :1] * surface.dir1 + view.t1[:, 1:] * surface.dir2
        return spec_oracle.extrema(vertices, faces, view.dt1q1, t1, view.q1, None, 1.0)
    g = 1.0 if family is LineFamily.RIDGES else -1.0
    return spec_oracle.extrema(vertices, faces, surface.dcurv[:, 0], surface.dir1, surface.k1, nv, g)


def same(lines: LineSet, expected: list[Segment]) -> None:
    """Assert that lines are the oracle's segments, in any order and direction."""
    face, points = np.array([s[0] for s in expected]), np.array([s[1] for s in expected]).reshape(-1, 2, 3)
    assert len(lines) == len(expected)
    assert matched(lines.face, lines.points, face, points, 1e-9) == len(expected)


def length(points: Floats) -> float:
    """The sum of the lengths of (n, 2, 3) or (n, 2, 2) segments."""
    return float(np.linalg.norm(points[:, 1] - points[:, 0], axis=1).sum())
