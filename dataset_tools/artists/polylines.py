"""Lines on the picture plane as evenly spaced points: resampled, joined over gaps, parted where something is drawn."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ncmodel.types import Floats, Ints, Mask

STEP = 2.0
"""Pixels between the points of a line, about."""
END = 12.0
"""Pixels of a line's end that say where it is heading."""
STRAIGHT_ON = 0.8
"""Least cosine between the heading of a line's end and the gap, and between the two headings."""


@dataclass(frozen=True, eq=False)
class Polyline:
    """A line that may be drawn.

    Attributes:
        points: (n, 2) pixels, `STEP` apart, n >= 2.
        kind: Its family's name.
        salience: (n,) how strong it is there, in [0, 1): 1/2 at the family's default threshold.
    """

    points: Floats
    kind: str
    salience: Floats

    @property
    def length(self) -> float:
        """Pixels."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())

    def part(self, begin: int, end: int) -> "Polyline":
        """The points [begin, end)."""
        return Polyline(self.points[begin:end], self.kind, self.salience[begin:end])

    def reversed(self) -> "Polyline":
        """The same line from its other end."""
        return Polyline(self.points[::-1], self.kind, self.salience[::-1])


def resampled(points: Floats, kind: str, salience: Floats) -> Polyline:
    """Any polyline (two points or more) with evenly spaced points."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = np.linspace(0.0, along[-1], max(2, round(along[-1] / STEP) + 1))
    columns = [np.interp(at, along, column) for column in (*points.T, salience)]
    return Polyline(np.stack(columns[:2], axis=1), kind, columns[2])


def runs(mask: Mask) -> list[tuple[int, int]]:
    """The stretches [begin, end) of True in a row."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return [(begin, end) for begin, end in edges.reshape(-1, 2).tolist()]


def without(line: Polyline, taken: Mask, crossing: float, shortest: float) -> list[Polyline]:
    """The parts of a line that aren't taken.

    Args:
        line: The line.
        taken: (n,) of its points.
        crossing: Pixels; a shorter stretch that is taken is crossed.
        shortest: Pixels; what is left is at least this long.
    """
    free = ~taken
    for begin, end in runs(taken):
        if begin > 0 and end < len(free) and (end - begin) * STEP < crossing:
            free[begin:end] = True
    return [line.part(begin, end) for begin, end in runs(free) if (end - begin - 1) * STEP >= shortest]


def joined(lines: Sequence[Polyline], gap: float) -> list[Polyline]:
    """Lines that go on as one another across a gap, made one; nearest and straightest ends first.

    Args:
        lines: Lines of one kind.
        gap: Pixels between ends that are joined, at most.
    """
    if len(lines) < 2:
        return list(lines)
    tips = np.stack([point for line in lines for point in (line.points[0], line.points[-1])])
    reach = round(END / STEP)
    inner = [point for line in lines for point in (line.points[:reach][-1], line.points[-reach:][0])]
    heading = _unit(tips - np.stack(inner))
    pairs = cKDTree(tips).query_pairs(gap, output_type="ndarray").astype(np.int64)
    pairs = pairs[pairs[:, 0] // 2 != pairs[:, 1] // 2]
    partner = _partners(_straight_on(tips, heading, pairs), len(tips))
    return [_concatenated(lines, path) for path in _paths(partner)]


def _straight_on(tips: Floats, heading: Floats, pairs: Ints) -> Ints:
    """The pairs of ends that head for each other, the best first."""
    first, second = pairs.T
    across = tips[second] - tips[first]
    distance = np.linalg.norm(across, axis=1)
    direction = np.where(distance[:, None] > STEP, _unit(across), heading[first])
    towards = (heading[first] * direction).sum(axis=1)
    back = -(heading[second] * direction).sum(axis=1)
    alike = -(heading[first] * heading[second]).sum(axis=1)
    straight = np.minimum(np.minimum(towards, back), alike)
    cost = distance * (2.0 - straight)
    order = np.argsort(cost, kind="stable")
    return np.asarray(pairs[order[straight[order] > STRAIGHT_ON]])


def _partners(pairs: Ints, ends: int) -> list[int]:
    """For each end the one that it is joined to, or -1; no line is closed to a ring."""
    partner, line = [-1] * ends, list(range(ends // 2))

    def root(index: int) -> int:
        while line[index] != index:
            index = line[index]
        return index

    for one, other in pairs.tolist():
        if partner[one] < 0 and partner[other] < 0 and (a := root(one // 2)) != (b := root(other // 2)):
            partner[one], partner[other], line[a] = other, one, b
    return partner


def _paths(partner: Sequence[int]) -> list[list[int]]:
    """Lines in the order in which they are joined, each as the end at which it is entered."""
    found = []
    for start in range(len(partner)):
        if partner[start] >= 0 or (start % 2 and partner[start - 1] < 0):
            continue  # not a free end, or the second one of a line that stays alone
        path, entry = [], start
        while entry >= 0:
            path.append(entry)
            entry = partner[entry ^ 1]
        if path[0] <= path[-1] ^ 1:  # not the same path from its other end
            found.append(path)
    return found


def _concatenated(lines: Sequence[Polyline], path: Sequence[int]) -> Polyline:
    parts = [lines[entry // 2].reversed() if entry % 2 else lines[entry // 2] for entry in path]
    if len(parts) == 1:
        return parts[0]
    points, salience = (np.concatenate(values) for values in ([p.points for p in parts], [p.salience for p in parts]))
    return resampled(points, parts[0].kind, salience)


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-9))


def segments(lines: Sequence[Polyline]) -> Floats:
    """(S, 2, 2) the lines' straight pieces."""
    pieces = [np.stack([line.points[:-1], line.points[1:]], axis=1) for line in lines]
    return np.concatenate(pieces) if pieces else np.empty((0, 2, 2))
