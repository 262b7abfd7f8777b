"""Fewer lines: the outline, and of the lines inside it the strongest and longest.

A line's importance is its ink: opacity, which says how far it is above its family's threshold, summed along its
length. All lengths are relative to the picture, so that the same lines are chosen at any size.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ncmodel.types import FILTERED_FAMILIES, Floats, Mask, Stroke

_BESIDE_OUTLINES = frozenset((*FILTERED_FAMILIES, "image"))
"""Families whose lines are no outlines, however near they run."""

Beyond = Callable[[Floats], Mask]
"""(N, 2) pixels -> (N,) True for those beyond the shape, where the background is seen."""

SPECK = 16.0
"""Pixels, at 768; shorter pieces of outline that meet no long one are small holes: lines inside."""
SPACING = 2.0
"""Pixels, at 768, between the places at which a stroke is looked at, at most."""
SPARSE = 8.0
"""The same where only the greater part of the stroke counts."""
BESIDE = 2.5
"""Pixels, at 768, from an outline to the background, at most."""
SHORTEST_INSIDE = 8.0
"""Pixels, at 768; where a stroke leaves the outline for a shorter stretch, it is outline all the same."""
SHORTEST_OUTLINE = 5.0
"""Pixels, at 768; a stroke that is at the outline for a shorter stretch ends there."""


def most_important(strokes: Sequence[Stroke], share: float, beyond: Beyond, scale: float) -> tuple[Stroke, ...]:
    """The outline, and a share of the length of all lines inside it, the most important first.

    What a threshold or a model put along the outline is left out beside contours, boundaries and creases: it repeats
    them.

    Args:
        strokes: In the order in which they are drawn, which stays.
        share: 0 leaves the outline alone, 1 everything.
        beyond: Where the background is.
        scale: Pixels per pixel at 768.
    """
    if share >= 1.0 or not strokes:
        return tuple(strokes)
    places = _places(strokes, beyond, scale)
    parts = [part for stroke, at in zip(strokes, places, strict=True) for part in _parts(stroke, at, scale)]
    parts = _without_specks(parts, scale)
    if any(part.outline and part.stroke.family not in _BESIDE_OUTLINES for part in parts):
        parts = [part for part in parts if not (part.outline and part.stroke.family in _BESIDE_OUTLINES)]
    inside = [part.stroke for part in parts if not part.outline]
    length = np.array([_length(stroke) for stroke in inside])
    order = np.argsort([-_ink(stroke) for stroke in inside], kind="stable")
    # A stroke is in if its middle is within the share: shares are met as nearly as whole strokes allow.
    middle = np.cumsum(length[order]) - length[order] / 2
    chosen = np.zeros(len(inside), dtype=np.bool_)
    chosen[order[middle <= share * length.sum()]] = True
    keep = iter(chosen.tolist())
    return tuple(part.stroke for part in parts if part.outline or next(keep))


def without_short(strokes: Sequence[Stroke], shortest: float, beyond: Beyond, scale: float) -> tuple[Stroke, ...]:
    """The strokes of at least a length, and the shorter ones of the outline.

    Args:
        strokes: In the order in which they are drawn, which stays.
        shortest: Pixels, at 768.
        beyond: Where the background is.
        scale: Pixels per pixel at 768.
    """
    doubtful = [number for number, stroke in enumerate(strokes) if _length(stroke) < shortest * scale]
    outline = on_outline([strokes[number] for number in doubtful], beyond, scale)
    dropped = {number for number, is_outline in zip(doubtful, outline.tolist(), strict=True) if not is_outline}
    return tuple(stroke for number, stroke in enumerate(strokes) if number not in dropped)


def on_outline(strokes: Sequence[Stroke], beyond: Beyond, scale: float) -> Mask:
    """(C,) which strokes are outline for the greater part.

    Args:
        strokes: Of any families.
        beyond: Where the background is.
        scale: Pixels per pixel at 768.
    """
    places = _places(strokes, beyond, scale, SPARSE)
    outline = [float(at.outline.mean()) > 0.5 for at in places]
    families = [stroke.family not in _BESIDE_OUTLINES for stroke in strokes]
    return np.array(outline, dtype=np.bool_) & np.array(families, dtype=np.bool_)


@dataclass(frozen=True, eq=False)
class _Places:
    """Places along a stroke, both ends among them.

    Attributes:
        point: (N,) which of the stroke's points, with fractions.
        at: (N,) pixels from its start.
        outline: (N,) True where the background begins beside it.
    """

    point: Floats
    at: Floats
    outline: Mask


@dataclass(frozen=True, eq=False)
class _Part:
    """A stroke, or as much of it as is outline or isn't."""

    stroke: Stroke
    outline: bool


def _places(strokes: Sequence[Stroke], beyond: Beyond, scale: float, spacing: float = SPACING) -> list[_Places]:
    """Places along strokes, and whether they are on the outline; the background is asked for once."""
    if not strokes:
        return []
    points = np.concatenate([stroke.points for stroke in strokes])
    first = np.cumsum([0, *(len(stroke.points) for stroke in strokes)])
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    steps[first[1:-1] - 1] = spacing * scale  # from one stroke to the next
    travelled = np.concatenate([[0.0], np.cumsum(steps)])
    start, length = travelled[first[:-1]], travelled[first[1:] - 1] - travelled[first[:-1]]
    count = (length / (spacing * scale)).astype(np.int64) + 2
    cuts = np.cumsum(count)
    at = (np.arange(cuts[-1]) - np.repeat(cuts - count, count)) * np.repeat(length / (count - 1), count)
    reached = np.repeat(start, count) + at
    pixels = np.stack([np.interp(reached, travelled, column) for column in points.T], axis=1)
    along = np.diff(pixels, axis=0, append=0.0)
    along[cuts - 1] = along[cuts - 2]
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    aside = BESIDE * scale * np.stack([-along[:, 1], along[:, 0]], axis=1)
    # Half as far, too: beyond a narrow gap the shape goes on.
    sideways = np.stack([pixels + share * aside for share in (-1.0, -0.5, 0.5, 1.0)], axis=1)
    outline = beyond(sideways.reshape(-1, 2)).reshape(-1, 4).any(axis=1)
    point = np.interp(reached, travelled, np.arange(len(points))) - np.repeat(first[:-1], count)
    split = (np.split(values, cuts[:-1]) for values in (point, at, outline))
    return [_Places(*arrays) for arrays in zip(*split, strict=True)]


def _parts(stroke: Stroke, places: _Places, scale: float) -> list[_Part]:
    """A stroke cut where it leaves the outline or comes to it."""
    if (places.outline == places.outline[0]).all():
        return [_Part(stroke, bool(places.outline[0]))]
    outline = _without_runs(places.outline, places.at, False, SHORTEST_INSIDE * scale)
    outline = _without_runs(outline, places.at, True, SHORTEST_OUTLINE * scale)
    changes = np.flatnonzero(np.diff(outline))
    if len(changes) == 0:
        return [_Part(stroke, bool(outline[0]))]
    own = np.arange(len(stroke.points))
    bounds = np.concatenate([[0.0], (places.point[changes] + places.point[changes + 1]) / 2, [own[-1]]])
    found = []
    for begin, end, state in zip(bounds[:-1], bounds[1:], outline[np.append(changes, -1)].tolist(), strict=True):
        at = np.concatenate([[begin], own[(own > begin) & (own < end)], [end]])
        points = np.stack([np.interp(at, own, column) for column in stroke.points.T], axis=1)
        found.append(_Part(Stroke(stroke.family, points, np.interp(at, own, stroke.alpha)), state))
    return found


def _without_specks(parts: Sequence[_Part], scale: float) -> list[_Part]:
    """The same parts, of which short outlines that no others connect to a long one count as lines inside."""
    from scipy.spatial import cKDTree

    outlines = [number for number, part in enumerate(parts) if part.outline]
    if not outlines:
        return list(parts)
    tree = cKDTree(np.concatenate([parts[number].stroke.points for number in outlines]))
    owner = np.repeat(outlines, [len(parts[number].stroke.points) for number in outlines])
    short = [number for number in outlines if _length(parts[number].stroke) < SPECK * scale]
    near = {number: tree.query_ball_point(parts[number].stroke.points[[0, -1]], BESIDE * scale) for number in short}
    beside = {number: {int(owner[point]) for end in found for point in end} for number, found in near.items()}
    held, specks = set(outlines).difference(short), set(short)
    while joining := {number for number in specks if not beside[number].isdisjoint(held)}:
        held |= joining
        specks -= joining
    return [_Part(part.stroke, part.outline and number not in specks) for number, part in enumerate(parts)]


def _without_runs(state: Mask, at: Floats, value: bool, shortest: float) -> Mask:
    """States along a line whose runs of `value`, unless they are all there is, are at least `shortest` long."""
    edges = np.flatnonzero(np.diff(np.concatenate([[not value], state, [not value]])))
    filled = state.copy()
    for begin, end in edges.reshape(-1, 2).tolist():
        if at[end - 1] - at[begin] < shortest and end - begin < len(state):
            filled[begin:end] = not value
    return filled


def _length(stroke: Stroke) -> float:
    return float(np.linalg.norm(np.diff(stroke.points, axis=0), axis=1).sum())


def _ink(stroke: Stroke) -> float:
    steps = np.linalg.norm(np.diff(stroke.points, axis=0), axis=1)
    return float((steps * (stroke.alpha[:-1] + stroke.alpha[1:]) / 2).sum())
