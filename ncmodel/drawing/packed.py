"""Many strokes in a few arrays: what is asked of each of thousands is asked of all at once."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from ncmodel.jit import kernel
from ncmodel.lines.line_ends import boxes
from ncmodel.types import Floats, Ints, Mask, Stroke


@dataclass(frozen=True, eq=False)
class Packed:
    """The points of C strokes, one stroke after the other.

    Attributes:
        points: (N, 2) pixels.
        alpha: (N,) opacity.
        depth: (N,) distance in front of the camera plane, 0 for strokes that don't come from the mesh.
        first: (C + 1,) where each stroke starts.
    """

    points: Floats
    alpha: Floats
    depth: Floats
    first: Ints

    @classmethod
    def of(cls, strokes: Sequence[Stroke]) -> Self:
        """Pack one stroke or more."""
        depths = [np.zeros(len(stroke.points)) if stroke.depth is None else stroke.depth for stroke in strokes]
        return cls(
            np.concatenate([stroke.points for stroke in strokes]),
            np.concatenate([stroke.alpha for stroke in strokes]),
            np.concatenate(depths),
            np.cumsum([0, *(len(stroke.points) for stroke in strokes)]),
        )

    @cached_property
    def steps(self) -> Floats:
        """(N,) the way from the point before, 0 for the first one of a stroke."""
        steps = np.zeros(len(self.points))
        steps[1:] = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        steps[self.first[:-1]] = 0.0
        return steps

    @property
    def length(self) -> Floats:
        """(C,) pixels."""
        return np.add.reduceat(self.steps, self.first[:-1])

    @property
    def ink(self) -> Floats:
        """(C,) pixels, weighted with opacity."""
        mean = self.alpha.copy()
        mean[1:] += self.alpha[:-1]
        return np.add.reduceat(self.steps * mean / 2.0, self.first[:-1])

    @property
    def ends(self) -> Floats:
        """(C, 2, 2) the first and the last point of each."""
        return np.stack([self.points[self.first[:-1]], self.points[self.first[1:] - 1]], axis=1)

    def meet_another(self, ends: Ints, pixels: float, after: float = math.inf) -> Mask:
        """Which ends lie on another stroke, or on their own one where it comes back.

        Args:
            ends: (n,) 2c for the first point of stroke c and 2c + 1 for its last one.
            pixels: How near that is.
            after: Pixels from the end on along its own stroke at which this one counts as another.
        """
        return np.asarray(_met(self.ends.reshape(-1, 2), ends, self.points, self.steps, self.first, pixels, after))


@kernel
def _met(ends: Floats, chosen: Ints, points: Floats, steps: Floats, first: Ints, pixels: float, after: float) -> Mask:
    """(n,) which of the chosen ones of the (2C, 2) ends of strokes are within some pixels of another stroke."""
    found = np.zeros(len(chosen), np.bool_)
    travelled, box = np.cumsum(steps), boxes(points, first, pixels)
    for k in range(len(chosen)):
        own = chosen[k] // 2
        u, v = ends[chosen[k], 0], ends[chosen[k], 1]
        low, high = travelled[first[own]] + after, travelled[first[own + 1] - 1] - after
        for c in range(len(box)):
            if u < box[c, 0] or v < box[c, 1] or u > box[c, 2] or v > box[c, 3]:
                continue
            for n in range(first[c] + 1, first[c + 1]):
                # The nearer end of a segment of its own stroke is so far from this end.
                back = travelled[n - 1] >= low if chosen[k] % 2 == 0 else travelled[n] <= high
                if steps[n] > 0.0 and (c != own or back):
                    dx, dy = points[n, 0] - points[n - 1, 0], points[n, 1] - points[n - 1, 1]
                    x, y = u - points[n - 1, 0], v - points[n - 1, 1]
                    share = min(max((x * dx + y * dy) / (steps[n] * steps[n]), 0.0), 1.0)
                    if math.hypot(x - share * dx, y - share * dy) <= pixels:
                        found[k] = True
                        break
            if found[k]:
                break
    return found


@dataclass(frozen=True, eq=False)
class Samples:
    """Points close to each other along strokes.

    Attributes:
        points: (N, 2) pixels, stroke after stroke.
        along: (N, 2) directions of length 1.
        alpha: (N,) opacity.
        depth: (N,) as strokes have it, 0 where they have none.
        own: (N,) True for the strokes' own points.
        first: (C + 1,) where each stroke starts.
    """

    points: Floats
    along: Floats
    alpha: Floats
    depth: Floats
    own: Mask
    first: Ints


def sampled(strokes: Sequence[Stroke], spacing: float) -> Samples:
    """Points at most some pixels apart along one stroke or more, their own points among them."""
    packed = Packed.of(strokes)
    start = packed.first
    steps = np.maximum(np.ceil(packed.steps[1:] / spacing), 1.0).astype(np.int64)  # 1 from one stroke to the next
    place = np.concatenate([[0], np.cumsum(steps)])
    at = np.arange(place[-1] + 1)
    first = np.append(place[start[:-1]], len(at))
    fine = np.stack([np.interp(at, place, column) for column in packed.points.T], axis=1)
    along = np.diff(fine, axis=0, append=0.0)
    along[first[1:] - 1] = along[first[1:] - 2]
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    alpha, depth = np.interp(at, place, packed.alpha), np.interp(at, place, packed.depth)
    own = np.zeros(len(at), dtype=np.bool_)
    own[place] = True
    return Samples(fine, along, alpha, depth, own, first)
