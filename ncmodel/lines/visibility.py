"""Hidden-line removal: the parts of lines that the eye sees.

Every segment is sampled about once a pixel along the picture, each sample is looked at (see `occlusion`), and a change
between two samples is located to a quarter of a pixel. What is left of the faces' roughness is smoothed along the
chained lines: a gap of few pixels that something near makes is closed, and a speck in the middle of a hidden part is
dropped.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ncmodel.camera import Camera
from ncmodel.geometry.raycast import RayScene
from ncmodel.jit import kernel
from ncmodel.lines.chaining import Chains, chain
from ncmodel.lines.occlusion import HIDDEN, SEEN, Occlusion, Smooth
from ncmodel.types import Floats, Ints, LineFamily, LineSet, Mask

MESH_EDGES = (LineFamily.BOUNDARIES, LineFamily.CREASES)
"""Families that lie on the flat faces' own edges."""
FLAT = (*MESH_EDGES, LineFamily.INTERSECTIONS)
"""Families that lie on the flat faces, and not on the smooth surface."""

SAMPLE_PIXELS = 1.0
"""Distance of samples along the picture, unless told otherwise."""
HALVINGS = 2
"""Halvings of the interval between two samples in which visibility changes."""
FRAME_MARGIN = 8.0
"""Lines are kept this many pixels beyond the frame, so that wide strokes reach its edge."""
NEAR_PLANE = 1e-6
"""Lines nearer to the camera plane than this, in radii of the mesh, are cut off."""
GAP_PIXELS = 3.0
"""Shorter gaps in a line are closed if what makes them is near."""
SPECK_PIXELS = 1.5
"""Shorter parts of a line between hidden ones are dropped."""


def visible_pieces(
    lines: LineSet,
    camera: Camera,
    scene: RayScene,
    smooth: Smooth | None = None,
    sample_pixels: float = SAMPLE_PIXELS,
) -> LineSet:
    """The parts of lines that the camera sees: in front of it, in the frame, and before all faces.

    Args:
        lines: Lines on the scene's mesh.
        camera: Where they are seen from.
        scene: The mesh.
        smooth: The surface whose lines they are, for lines on it; those on the flat faces have none.
        sample_pixels: Distance along the picture of the points at which visibility is decided.

    Returns:
        Pieces of the lines, in their order.
    """
    return _pieces(lines, camera, scene, smooth, sample_pixels, seen=True)


def hidden_pieces(
    lines: LineSet,
    camera: Camera,
    scene: RayScene,
    smooth: Smooth | None = None,
    sample_pixels: float = SAMPLE_PIXELS,
) -> LineSet:
    """What `visible_pieces` takes away of the lines in front of the camera and in the frame.

    Both together are all of these, and have no part in common.
    """
    return _pieces(lines, camera, scene, smooth, sample_pixels, seen=False)


def _pieces(
    lines: LineSet, camera: Camera, scene: RayScene, smooth: Smooth | None, sample_pixels: float, seen: bool
) -> LineSet:
    """The parts of lines in the frame that are seen, or those that aren't."""
    lines = in_frame(lines, camera, scene)
    if len(lines) == 0:
        return lines
    samples = _sample(lines.points, camera, sample_pixels)
    occlusion = Occlusion(lines, camera, scene, smooth)
    state = occlusion.state(samples.segment, samples.at)
    shown = _smooth(state, samples, chain(lines.points)) == seen
    return lines.between(*_intervals(shown, samples, occlusion, seen))


def in_frame(lines: LineSet, camera: Camera, scene: RayScene) -> LineSet:
    """The parts of lines in front of the camera and in the frame, hidden or not."""
    start, end = _in_frame(lines.points, camera, NEAR_PLANE * scene.radius)
    framed = np.flatnonzero(start < end)
    return lines.between(framed, start[framed], end[framed])


@dataclass(frozen=True, eq=False)
class _Samples:
    """Points on S segments, those of a segment in order; the first and last are its ends, unless it has only one.

    Attributes:
        segment: (N,) the segment of each sample.
        at: (N,) where along it, in 0..1.
        pixels: (N,) how much of the picture each sample stands for.
        first: (S + 1,) where the samples of each segment start.
    """

    segment: Ints
    at: Floats
    pixels: Floats
    first: Ints


def _in_frame(points: Floats, camera: Camera, near: float) -> tuple[Floats, Floats]:
    """(S,) start and end in 0..1 of the part of each segment in front of the camera and in the frame; else start > end.

    A point is inside if it is on the inner side of five planes through or before the eye (Liang and Barsky's clipping).
    """
    x, y, depth = camera.local(points)
    x, y, scale = camera.focal_pixels * x, camera.focal_pixels * y, camera.scale_distance(depth)
    right = (camera.width / 2 + FRAME_MARGIN) * scale
    top = (camera.height / 2 + FRAME_MARGIN) * scale
    start, end = np.zeros(len(points)), np.ones(len(points))
    for inside in (depth - near, right - x, right + x, top - y, top + y):
        first, last = inside[:, 0], inside[:, 1]
        crossing = first / np.where(first == last, 1.0, first - last)
        start = np.where(first < 0, np.where(last < 0, 2.0, np.maximum(start, crossing)), start)
        end = np.where((last < 0) & (first >= 0), np.minimum(end, crossing), end)
    return start, end


def _sample(points: Floats, camera: Camera, spacing: float) -> _Samples:
    """Samples at even steps on the picture."""
    projected = camera.project(points)
    length = np.linalg.norm(projected[:, 1, :2] - projected[:, 0, :2], axis=1)
    steps = np.ceil(length / spacing).astype(np.int64)
    # What is far below the spacing is decided as a whole, in its middle.
    count = np.where(length <= spacing / 2, 1, steps + 1)
    first = np.concatenate([[0], np.cumsum(count)])
    segment = np.repeat(np.arange(len(points)), count)
    share = (np.arange(first[-1]) - first[segment]) / np.maximum(count - 1, 1)[segment]
    share[count[segment] == 1] = 0.5
    # Even steps on the picture are uneven ones on the line, in perspective.
    near, far = (camera.scale_distance(projected[segment, end, 2]) for end in (0, 1))
    at = share * near / (share * near + (1 - share) * far)
    return _Samples(segment, at, (length / count)[segment], first)


def _smooth(state: NDArray[np.int8], samples: _Samples, chains: Chains) -> Mask:
    """(N,) which samples count as seen, with short gaps closed and specks dropped along chains."""
    seen = np.asarray(state == SEEN)
    order, bounds = _along_chains(chains.segment, chains.flipped, chains.first, samples.first)
    seen[order] = _without_flicker(state[order], samples.pixels[order], bounds)
    return seen


@kernel
def _along_chains(segment: Ints, flipped: Mask, first: Ints, first_sample: Ints) -> tuple[Ints, Ints]:
    """The samples of chained segments in the order in which chains pass them, and where each chain starts."""
    order = np.empty(first_sample[-1], np.int64)
    bounds = np.zeros(len(first), np.int64)
    filled = 0
    for c in range(len(first) - 1):
        for k in range(first[c], first[c + 1]):
            begin, end = first_sample[segment[k]], first_sample[segment[k] + 1]
            for i in range(end - begin):
                order[filled] = end - 1 - i if flipped[k] else begin + i
                filled += 1
        bounds[c + 1] = filled
    return order[:filled], bounds


@kernel
def _without_flicker(state: NDArray[np.int8], pixels: Floats, bounds: Ints) -> Mask:
    """Which samples count as seen: gaps are closed first, then specks dropped."""
    seen = state >= SEEN
    for closing in (True, False):
        for c in range(len(bounds) - 1):
            start = bounds[c]
            while start < bounds[c + 1]:
                stop, length, faint = start, 0.0, True
                while stop < bounds[c + 1] and seen[stop] == seen[start]:
                    length += pixels[stop]
                    faint = faint and state[stop] != HIDDEN
                    stop += 1
                inner = start > bounds[c] and stop < bounds[c + 1]
                if inner and closing and not seen[start] and faint and length < GAP_PIXELS:
                    seen[start:stop] = True
                if inner and not closing and seen[start] and length < SPECK_PIXELS:
                    seen[start:stop] = False
                start = stop
    return seen


def _intervals(shown: Mask, samples: _Samples, occlusion: Occlusion, seen: bool) -> tuple[Ints, Floats, Floats]:
    """The parts of segments around the samples `shown`, which are those seen or the others.

    Returns:
        Segment, start and end in 0..1 of each.
    """
    first, last = np.zeros(len(shown), dtype=np.bool_), np.zeros(len(shown), dtype=np.bool_)
    first[samples.first[:-1]] = last[samples.first[1:] - 1] = True
    before = np.flatnonzero(~last[:-1] & (shown[:-1] != shown[1:]))
    # Where visibility changes between a sample and the next one of the same segment.
    change = np.full(len(shown), np.nan)
    change[before] = _locate(
        occlusion, samples.segment[before], samples.at[before], samples.at[before + 1], shown[before] == seen
    )
    begins = np.flatnonzero(shown & (first | ~np.roll(shown, 1)))
    ends = np.flatnonzero(shown & (last | ~np.roll(shown, -1)))
    start = np.where(first[begins], 0.0, change[begins - 1])
    end = np.where(last[ends], 1.0, change[ends])
    return samples.segment[begins], start, end


def _locate(occlusion: Occlusion, segment: Ints, low: Floats, high: Floats, seen: Mask) -> Floats:
    """Where between `low`, at which a segment is `seen` or not, and `high`, at which it is the other, that changes."""
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        same = (occlusion.state(segment, middle) == SEEN) == seen
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return np.asarray((low + high) / 2)
