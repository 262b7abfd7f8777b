"""Zero sets of scalars on a mesh: occluding and suggestive contours (docs/geometry.md 7)."""

import numpy as np

from ncmodel.geometry.normals_areas import Indices, check_columns
from ncmodel.jit import kernel
from ncmodel.types import Floats, Ints, LineFamily, LineSet

VANISHING = 1e-30
"""Stands for a denominator that reaches 0 from below."""

_NONE = np.zeros(0)


def contours(vertices: Floats, faces: Indices, n_dot_v: Floats, kr: Floats | None) -> LineSet:
    """Where the surface turns away from the eye.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        n_dot_v: (V,).
        kr: (V,) radial curvature or what has its sign; negative parts are left out because a solid hides them. None
            keeps all.
    """
    index, points, _, _ = _zero_set(vertices, faces, n_dot_v, _NONE if kr is None else kr, _NONE, _NONE)
    ones = np.ones((len(index), 2))
    return LineSet(LineFamily.CONTOURS, points, index, ones, ones)


def suggestive_contours(
    vertices: Floats, faces: Indices, n_dot_v: Floats, kr: Floats, numerator: Floats, feature_size: float
) -> LineSet:
    """Where the surface would turn away if the eye moved a little: kr = 0, DwKr > 0.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        n_dot_v: (V,).
        kr: (V,) radial curvature.
        numerator: (V,) sin(theta) DwKr.
        feature_size: Makes the strength dimensionless.
    """
    index, points, feature, denominator = _zero_set(vertices, faces, kr, numerator, n_dot_v, n_dot_v)
    return LineSet(LineFamily.SUGGESTIVE, points, index, feature, denominator, feature_size**2)


@kernel
def _zero_set(
    vertices: Floats, faces: Indices, value: Floats, numerator: Floats, denominator: Floats, culling: Floats
) -> tuple[Ints, Floats, Floats, Floats]:
    """Segments where `value` is 0 and `numerator` and `denominator` agree in sign.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        value: (V,).
        numerator: (V,), or empty for 1.
        denominator: (V,), or empty for 1.
        culling: (V,), or empty: faces where it is nowhere positive are left out.

    Returns:
        Faces (S,), points (S, 2, 3), numerator (S, 2) and denominator (S, 2) at the ends.
    """
    check_columns(vertices, 3)
    check_columns(faces, 3)
    candidates = _crossed_faces(faces, value, culling)
    index = np.empty(2 * len(candidates), dtype=np.int64)
    points = np.empty((2 * len(candidates), 2, 3))
    tops = np.empty((2 * len(candidates), 2))
    bottoms = np.empty((2 * len(candidates), 2))
    size = 0
    for f in candidates:
        # Turn the face so that `i` is the corner alone on its side of zero.
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        if _nowhere(i, j, k, numerator, denominator):
            continue
        for _ in range(2):
            a, b, c = value[i], value[j], value[k]
            if (a < 0.0 and b >= 0.0 and c >= 0.0) or (a > 0.0 and b <= 0.0 and c <= 0.0):
                break
            i, j, k = j, k, i
        s, t = value[i] / (value[i] - value[j]), value[i] / (value[i] - value[k])
        n0, n1 = _at(numerator, i, j, s), _at(numerator, i, k, t)
        d0, d1 = _at(denominator, i, j, s), _at(denominator, i, k, t)
        parts = _agreeing(n0, n1, d0, d1)
        for begin, stop in ((parts[0], parts[1]), (parts[2], parts[3])):
            if stop <= begin:
                continue
            index[size] = f
            for side, at in ((0, begin), (1, stop)):
                tops[size, side], bottoms[size, side] = _same_sign(n0, n1, d0, d1, at)
                for axis in range(3):
                    p = vertices[i, axis] + s * (vertices[j, axis] - vertices[i, axis])
                    q = vertices[i, axis] + t * (vertices[k, axis] - vertices[i, axis])
                    points[size, side, axis] = p + at * (q - p)
            size += 1
    return index[:size], points[:size], tops[:size], bottoms[:size]


@kernel
def _crossed_faces(faces: Indices, value: Floats, culling: Floats) -> Indices:
    """Faces where `value` takes both signs and `culling`, if any, is somewhere positive."""
    check_columns(faces, 3)
    found = np.empty(len(faces), dtype=np.uint32)
    size = 0
    for f in range(len(faces)):
        a, b, c = value[faces[f, 0]], value[faces[f, 1]], value[faces[f, 2]]
        # One branch, hardly ever taken.
        if ((a < 0.0) | (b < 0.0) | (c < 0.0)) & ((a > 0.0) | (b > 0.0) | (c > 0.0)):
            found[size] = f
            size += 1
    if len(culling) == 0:
        return found[:size].copy()
    kept = 0
    for n in range(size):
        f = found[n]
        found[kept] = f
        kept += max(culling[faces[f, 0]], culling[faces[f, 1]], culling[faces[f, 2]]) > 0.0
    return found[:kept].copy()


@kernel
def _at(values: Floats, i: int, j: int, w: float) -> float:
    """Linear interpolation from vertex i (w = 0) to j (w = 1); 1 where there are no values."""
    return values[i] + w * (values[j] - values[i]) if len(values) else 1.0


@kernel
def _agreeing(n0: float, n1: float, d0: float, d1: float) -> tuple[float, float, float, float]:
    """The parts of [0, 1] where n >= 0 exactly when d >= 0, both linear: [a, b] and [c, d], empty where not a < b."""
    cut_n = n0 / (n0 - n1) if (n0 >= 0.0) != (n1 >= 0.0) else 1.0
    cut_d = d0 / (d0 - d1) if (d0 >= 0.0) != (d1 >= 0.0) else 1.0
    first, second = min(cut_n, cut_d), max(cut_n, cut_d)
    if (n0 >= 0.0) == (d0 >= 0.0):
        return 0.0, first, second, 1.0
    return first, second, 1.0, 1.0


@kernel
def _same_sign(n0: float, n1: float, d0: float, d1: float, at: float) -> tuple[float, float]:
    """Both quantities at a cut or an end; where rounding gives them unlike signs, the one that is cut there vanishes.

    A denominator vanishes from its numerator's side, so that their ratio is never negative.
    """
    n, d = n0 + at * (n1 - n0), d0 + at * (d1 - d0)
    if (n >= 0.0) != (d >= 0.0):
        if abs(n) * max(abs(d0), abs(d1)) <= abs(d) * max(abs(n0), abs(n1)):
            n = 0.0
        else:
            d = 0.0 if n >= 0.0 else -VANISHING
    return n, d


@kernel
def _nowhere(i: int, j: int, k: int, numerator: Floats, denominator: Floats) -> bool:
    """Whether numerator and denominator disagree in sign, or vanish, at all three corners in the same way."""
    if len(numerator) == 0:
        return False
    low = min(numerator[i], numerator[j], numerator[k])
    high = max(numerator[i], numerator[j], numerator[k])
    if len(denominator) == 0:
        return bool(high <= 0.0)
    below = min(denominator[i], denominator[j], denominator[k])
    above = max(denominator[i], denominator[j], denominator[k])
    return bool((high <= 0.0 and below >= 0.0) or (low >= 0.0 and above <= 0.0))
