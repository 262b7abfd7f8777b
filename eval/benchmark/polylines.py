"""Polylines of a picture as points: how far apart, which way they run, and whether their ends meet anything."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ncmodel.types import Floats, Ints, Mask

ARRIVAL = 3.0
"""Pixels over which an end's direction is taken."""


@dataclass(frozen=True, eq=False)
class Samples:
    """Points evenly spaced along polylines, one polyline after the other.

    Attributes:
        points: (N, 2) pixels.
        along: (N, 2) directions of length 1.
        at: (N,) pixels from the start of the polyline.
        weight: (N,) pixels of length that each point stands for.
        owner: (N,) which polyline.
    """

    points: Floats
    along: Floats
    at: Floats
    weight: Floats
    owner: Ints


def length_of(line: Floats) -> float:
    """Pixels, of a polyline of (n, 2) points."""
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def sampled(lines: Sequence[Floats], spacing: float = 0.5) -> Samples:
    """Points along polylines, at most `spacing` pixels apart, both ends among them."""
    parts = [(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0), np.zeros(0), np.zeros(0, dtype=np.int64))]
    for number, line in enumerate(lines):
        travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        at = np.linspace(0.0, travelled[-1], int(travelled[-1] / spacing) + 2)
        points = np.stack([np.interp(at, travelled, column) for column in line.T], axis=1)
        along = np.gradient(points, axis=0)
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
        parts.append((points, along, at, np.gradient(at), np.full(len(at), number)))
    return Samples(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def distance(places: Floats, points: Floats) -> Floats:
    """(N,) distance of (N, 2) places to the nearest of some points, infinite without any."""
    from scipy.spatial import cKDTree

    if len(points) == 0 or len(places) == 0:
        return np.full(len(places), math.inf)
    return np.asarray(cKDTree(points).query(places)[0])


def ends(lines: Sequence[Floats]) -> tuple[Floats, Floats]:
    """(2L, 2) first and last points of L polylines, and the directions in which they arrive there."""
    found = [(line[0], _outwards(line)) for each in lines for line in (each, each[::-1])]
    return np.array([place for place, _ in found]).reshape(-1, 2), np.array([way for _, way in found]).reshape(-1, 2)


def _outwards(line: Floats) -> Floats:
    """The direction in which a polyline arrives at its first point, over some `ARRIVAL` pixels."""
    length = np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))
    way = line[0] - line[min(int(np.searchsorted(length, ARRIVAL)), len(line) - 2) + 1]
    return np.asarray(way / max(float(np.linalg.norm(way)), 1e-12))


def meeting(lines: Sequence[Floats], near: float) -> Mask:
    """(2L,) True for first and last points of polylines where there is more of the drawing.

    Args:
        lines: L polylines of two points or more.
        near: Pixels within which another polyline, or a part of the same one that lies farther along, counts.
    """
    from scipy.spatial import cKDTree

    if not lines:
        return np.zeros(0, dtype=np.bool_)
    samples = sampled(lines)
    places, _ = ends(lines)
    lengths = [length_of(line) for line in lines]
    found = np.zeros(len(places), dtype=np.bool_)
    for end, beside in enumerate(cKDTree(samples.points).query_ball_point(places, near)):
        number, last = divmod(end, 2)
        at = np.abs(samples.at[beside] - (lengths[number] if last else 0.0))
        found[end] = bool(((samples.owner[beside] != number) | (at > _FARTHER * near)).any())
    return found


_FARTHER = 3.0
"""How many times the distance across the picture a line must have gone to come back to its own end."""
