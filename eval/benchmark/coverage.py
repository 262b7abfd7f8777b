"""Drawings against what rays see, an oracle that knows nothing of lines.

Where depth jumps between two neighbouring rays, and keeps jumping while the place is narrowed down, the shape ends
before the background or one part of it before another: a contour, boundary or crease must run there. Of each drawn
line, every pixel must lie on what rays see, and every pixel of a line that they see must be drawn.
"""

import itertools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from eval.benchmark.each_view import VIEWS, ViewRow, measure_views
from eval.benchmark.polylines import distance, ends, sampled
from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw, visible_segments
from ncmodel.drawing.plan import Plan
from ncmodel.drawing.thresholding import fade, survivors
from ncmodel.geometry.raycast import RayScene
from ncmodel.scene.creases import split_at_creases
from ncmodel.scene.surface import CREASE_ANGLE, Surface
from ncmodel.scene.view import View
from ncmodel.types import EVERYTHING, FILTERED_FAMILIES, Floats, LineFamily, Mask

SIZE = 512
"""Side of the picture, pixels."""
RAYS = 2
"""Rays a pixel, in each direction, between which jumps of depth are looked for."""
HALVINGS = 9
"""How often the way between two rays is halved to find where depth jumps: to 1/1000 of a pixel."""
JUMP = 0.01
"""Depth must jump by this, in object space, to count."""
NEAR = 2.0
"""Pixels within which a line must run."""
BESIDE = 1.5
"""Pixels that a line may lie beside what is seen at its depth."""
BEHIND = 0.005
"""A line farther than what is seen by more than this, in object space, is hidden."""
EXACT = 1e-4
"""A point that a ray meets up to this, in object space, is seen."""
GAP = (1.0, 6.0)
"""Pixels between two ends of contours that point at each other: a dash."""
STRAIGHT = 0.85
"""Cosine up to which an end points at another one."""
BACKGROUND = 1e3
"""Depth where nothing is met."""


@dataclass(frozen=True)
class Coverage(ViewRow):
    """How complete and how right the lines of one view are.

    Attributes:
        outline: Share of the outline before the background that has a contour, boundary or crease within `NEAR`.
        jumps: The same of where one part of the shape ends before another.
        hidden: Share of all families' lines, by length on the picture, drawn behind what is seen.
        lost: Share of what is seen of all families' lines that isn't drawn.
        gaps: Short gaps in contours.
    """

    outline: float
    jumps: float
    hidden: float
    lost: float
    gaps: float


def measure_coverage(
    surfaces: Iterable[Surface],
    advance: Callable[[str], None],
    views: Sequence[tuple[float, float]] = VIEWS,
    size: int = SIZE,
) -> list[Coverage]:
    """Draw every surface from every view and compare with rays.

    Args:
        surfaces: What to draw.
        advance: Called after each surface.
        views: Azimuth and elevation, degrees.
        size: Side of the pictures, pixels.
    """
    return measure_views(Coverage, _measure, surfaces, advance, views, size)


def coverage_rows(found: Sequence[Coverage]) -> list[list[str]]:
    """A table, its head first."""
    head = ["shape", "outline drawn %", "jumps drawn %", "hidden %", "lost %", "gaps"]
    return [
        head,
        *(
            [e.shape, *(f"{100 * share:.2f}" for share in (e.outline, e.jumps, e.hidden, e.lost)), f"{e.gaps:.1f}"]
            for e in found
        ),
    ]


def depth_jumps(scene: RayScene, camera: Camera) -> tuple[Floats, Mask]:
    """Where depth jumps: (N, 2) pixels, and (N,) True before the background."""
    axes = (np.arange(RAYS * side) / RAYS + 0.5 / RAYS for side in (camera.width, camera.height))
    pixels = np.stack(np.meshgrid(*axes), axis=-1)
    depth = _depth(scene, camera, pixels.reshape(-1, 2)).reshape(pixels.shape[:2])
    places, before_background = [], []
    for one, other in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        apart = np.abs(depth[one] - depth[other]) > JUMP
        a, b, near, far = pixels[one][apart], pixels[other][apart], depth[one][apart], depth[other][apart]
        for _ in range(HALVINGS):
            middle = (a + b) / 2
            between = _depth(scene, camera, middle)
            first = np.abs(between - near) >= np.abs(between - far)
            b, far = np.where(first[:, None], middle, b), np.where(first, between, far)
            a, near = np.where(first[:, None], a, middle), np.where(first, near, between)
        jump = np.abs(near - far) > JUMP
        places.append(((a + b) / 2)[jump])
        before_background.append(np.maximum(near, far)[jump] == BACKGROUND)
    return np.concatenate(places), np.concatenate(before_background)


def _measure(surface: Surface, camera: Camera) -> tuple[float, float, float, float, float]:
    """Outline, jumps, hidden, lost and gaps of one view."""
    strokes = draw(surface, camera, list(LineFamily)).strokes
    full = [stroke.points for stroke in strokes if stroke.family not in FILTERED_FAMILIES]
    places, before_background = depth_jumps(surface.scene, camera)
    drawn = distance(places, sampled(full).points) <= NEAR
    contours = [stroke.points for stroke in strokes if stroke.family == LineFamily.CONTOURS]
    return (
        _share(drawn[before_background], np.ones(before_background.sum())),
        _share(drawn[~before_background], np.ones((~before_background).sum())),
        *_hidden_and_lost(surface, camera, places),
        float(_gaps(contours, full)),
    )


def _hidden_and_lost(surface: Surface, camera: Camera, jumps: Floats) -> tuple[float, float]:
    """Shares of what is drawn that is hidden, and of what is seen that isn't drawn, all families together.

    Of contours, what is seen counts where depth jumps: on coarse faces n.v = 0 may cross the middle of a side.
    """
    view, plan, scene = (
        View(split_at_creases(surface, CREASE_ANGLE), camera, CREASE_ANGLE),
        Plan(tuple(LineFamily)),
        surface.scene,
    )
    of_drawn, of_seen = [np.zeros((0, 2))], [np.zeros((0, 2))]
    for family in plan.drawn:
        threshold, lines = plan.thresholds.of(family) or EVERYTHING, view.candidates(family)
        pieces = visible_segments(view, family, threshold)
        pixels, depth, length = _samples(pieces.points, camera)
        beside = [
            _depth(scene, camera, pixels + aside) for aside in itertools.product((-BESIDE, 0.0, BESIDE), repeat=2)
        ]
        of_drawn.append(np.stack([np.max(beside, axis=0) < depth - BEHIND, length], axis=1))
        strong = fade(lines.take(survivors(lines, threshold)), threshold)
        there, depth, length = _samples(strong.points, camera)
        seen = _depth(scene, camera, there) >= depth - EXACT
        if family is LineFamily.CONTOURS:
            seen &= distance(there, jumps) <= NEAR
        missing = distance(there[seen], pixels) > BESIDE
        of_seen.append(np.stack([missing, length[seen]], axis=1))
    hidden, lost = np.concatenate(of_drawn), np.concatenate(of_seen)
    return _share(hidden[:, 0], hidden[:, 1], 0.0), _share(lost[:, 0], lost[:, 1], 0.0)


def _gaps(contours: Sequence[Floats], full: Sequence[Floats]) -> int:
    """How many short gaps are between ends of contours that point at each other, with no stroke in them."""
    from scipy.spatial import cKDTree

    points, outwards = ends(contours)
    if len(points) == 0:
        return 0
    pairs = cKDTree(points).query_pairs(GAP[1], output_type="ndarray")
    one, other = pairs[:, 0], pairs[:, 1]
    way = points[other] - points[one]
    length = np.linalg.norm(way, axis=1)
    way /= np.maximum(length, 1e-12)[:, None]
    facing = np.minimum((outwards[one] * way).sum(axis=1), -(outwards[other] * way).sum(axis=1)) > STRAIGHT
    middle = (points[one] + points[other])[facing & (length >= GAP[0])] / 2
    return int((distance(middle, sampled(full).points) > GAP[0] / 2).sum())


def _samples(points: Floats, camera: Camera) -> tuple[Floats, Floats, Floats]:
    """Points about a pixel apart on (S, 2, 3) segments: pixels (N, 2), depth (N,), length on the picture (N,)."""
    ends = camera.project(points)
    points, ends = points[(ends[..., 2] > 0).all(axis=1)], ends[(ends[..., 2] > 0).all(axis=1)]
    length = np.linalg.norm(ends[:, 1, :2] - ends[:, 0, :2], axis=1)
    count = np.maximum(np.ceil(length), 1).astype(np.int64)
    index = np.repeat(np.arange(len(points)), count)
    at = ((np.arange(len(index)) - (np.cumsum(count) - count)[index] + 0.5) / count[index])[:, None]
    projected = camera.project(points[index, 0] * (1 - at) + points[index, 1] * at)
    return projected[:, :2], projected[:, 2], (length / count)[index]


def _depth(scene: RayScene, camera: Camera, pixels: Floats) -> Floats:
    """(N,) depth along the optical axis of what is seen at (N, 2) pixels."""
    rays = camera.rays(pixels)
    away, face = scene.first_hit(*rays)
    return np.where(face >= 0, away / np.linalg.norm(rays.directions, axis=1), BACKGROUND)


def _share(chosen: Mask | Floats, weight: Floats, empty: float = 1.0) -> float:
    """The share of weight that is chosen; `empty` without any."""
    return float((chosen * weight).sum() / weight.sum()) if weight.sum() > 0 else empty
