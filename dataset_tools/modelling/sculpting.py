"""Sculptures: parts added, cut and pressed into one another on a grid of distances, then meshed.

Each part is worked out only in the box that it fills, so that dozens of small ones cost little.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dataset_tools.modelling.fields import Distance, Part
from ncmodel.types import Floats, Ints

Surface = tuple[Floats, Ints]
"""Vertices (V, 3) and faces (F, 3)."""

BAND = 4.0
"""Cells from the surface to which distances are meant when it is meshed."""

FINEST = 1.5
"""Cells that the narrowest fillet spans: sharper ones would be meshed as teeth."""

FAR = 1e3
"""Cells to a surface that isn't near."""

COARSE = 36
"""Cells along the longest side of the trial that tells how large the surface is."""

FACES_PER_SQUARE = 2.8
"""Faces of marching cubes to a square cell of surface, about."""

LARGEST = 2_600_000
"""Cells of a grid."""


@dataclass(frozen=True)
class _Step:
    """One working step: `kind` is add, cut or press."""

    kind: str
    part: Part
    blend: float
    height: Distance | None = None


@dataclass
class Sculpture:
    """Working steps, in order; later ones work on what is there by then."""

    steps: list[_Step] = field(default_factory=list)

    def add(self, *parts: Part, blend: float = 0.0) -> None:
        """Join parts on, with a fillet of about `blend`."""
        self.steps += [_Step("add", part, blend) for part in parts]

    def cut(self, *parts: Part, blend: float = 0.0) -> None:
        """Cut parts away, the edge rounded by about `blend`."""
        self.steps += [_Step("cut", part, blend) for part in parts]

    def press(self, region: Part, height: Distance, falloff: float) -> None:
        """Raise (or lower) the surface by a pattern of heights, fading out over `falloff` at a region's border."""
        self.steps.append(_Step("press", region, falloff, height))

    def mesh(self, faces: int, finer: float = 1.0) -> Surface:
        """The sculpture's surface in about so many faces.

        Args:
            faces: How many.
            finer: Over 1, it is meshed in so many times as many faces of even size, which are then merged where they
                are flat: for edges that are crisp.
        """
        if finer > 1.0:
            return decimated(self.mesh(round(finer * faces)), faces)
        added = [step.part for step in self.steps if step.kind == "add"]
        low, high = np.min([part.low for part in added], axis=0), np.max([part.high for part in added], axis=0)
        size = high - low
        cell = float(size.max()) / COARSE
        values, origin = self._fill(low, high, cell)
        area = _area(*_march(values, cell)) or float((size**2).sum())
        cell = max(np.sqrt(FACES_PER_SQUARE * area / faces), (float(size.prod()) / LARGEST) ** (1 / 3))
        values, origin = self._fill(low, high, cell)
        vertices, triangles = _march(values, cell)
        return _evened(values, vertices, triangles, cell) + origin, triangles

    def _fill(self, low: Floats, high: Floats, cell: float) -> tuple[NDArray[np.float32], Floats]:
        """Distances on a grid, in cells, and where its first point lies."""
        origin = low - 3.5 * cell
        counts = np.ceil((high - low) / cell).astype(int) + 8
        values = np.full(counts, FAR, dtype=np.float32)
        for step in self.steps:
            margin = step.blend + BAND * cell
            first = np.maximum(np.floor((step.part.low - margin - origin) / cell).astype(int), 0)
            last = np.minimum(np.ceil((step.part.high + margin - origin) / cell).astype(int) + 1, counts)
            if (last <= first).any():
                continue
            axes = [origin[a] + cell * np.arange(first[a], last[a]) for a in range(3)]
            points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
            box = tuple(slice(a, b) for a, b in zip(first, last, strict=True))
            worked = _worked(step, values[box].ravel(), points, cell)
            values[box] = worked.reshape(values[box].shape)
        return np.clip(values, -BAND, BAND), origin


def decimated(surface: Surface, faces: int) -> Surface:
    """A surface in fewer faces, large where it is flat (quadric edge collapse)."""
    from fast_simplification import simplify

    vertices, triangles = surface
    if len(triangles) <= faces:
        return surface
    kept, corners = simplify(vertices.astype(np.float32), triangles.astype(np.int32), target_count=faces, agg=4.0)
    return kept.astype(np.float64), corners.astype(np.int64)


def _worked(step: _Step, before: NDArray[np.float32], points: Floats, cell: float) -> Floats:
    """Distances in cells after a step."""
    if step.height is not None:
        near = np.flatnonzero(np.abs(before) < BAND)
        inside = np.clip(-step.part.distance(points[near]) / step.blend, 0.0, 1.0)
        after = before.astype(np.float64)
        after[near] -= inside * inside * (3 - 2 * inside) * step.height(points[near]) / cell
        return after
    distance = step.part.distance(points) / cell
    blend = max(step.blend / cell, FINEST)
    if step.kind == "cut":
        return -smooth_union(-before, distance, blend)
    return smooth_union(before, distance, blend)


def smooth_union(a: Floats | NDArray[np.float32], b: Floats, blend: float) -> Floats:
    """The lesser of two distances, with a fillet where they are nearly the same."""
    if blend < 1e-3:
        return np.minimum(a, b)
    h = np.maximum(blend - np.abs(a - b), 0.0) / blend
    return np.asarray(np.minimum(a, b) - blend * h**3 / 6.0)


def _march(values: NDArray[np.float32], cell: float) -> Surface:
    from skimage.measure import marching_cubes

    if not values.min() < 0 < values.max():
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    vertices, faces, _, _ = marching_cubes(values, 0.0, spacing=(cell, cell, cell))
    return vertices.astype(np.float64), faces.astype(np.int64)


def _area(vertices: Floats, faces: Ints) -> float:
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return float(np.linalg.norm(normal, axis=1).sum()) / 2


def _evened(values: NDArray[np.float32], vertices: Floats, faces: Ints, cell: float) -> Floats:
    """Vertices moved along the surface to where triangles are well shaped, and onto it.

    Curvature needs both: marching cubes leaves slivers, and vertices a little off a curved surface.
    """
    from scipy.ndimage import map_coordinates, spline_filter

    coefficients = spline_filter(values, order=3, output=np.float32)

    def sample(points: Floats) -> Floats:
        return np.asarray(map_coordinates(coefficients, points.T, order=3, prefilter=False, mode="nearest"))

    spread = _averaging(faces, len(vertices))
    places = vertices / cell
    for _ in range(3):
        gradient = np.stack([sample(places + step) - sample(places - step) for step in 0.25 * np.eye(3)], axis=1) / 0.5
        square = np.maximum((gradient**2).sum(axis=1, keepdims=True), 0.05)
        shift = spread @ places - places
        places = places + 0.8 * (shift - (shift * gradient).sum(axis=1, keepdims=True) * gradient / square)
        places = places - np.clip(sample(places)[:, None] * gradient / square, -0.5, 0.5)
    return places * cell


def _averaging(faces: Ints, count: int) -> Any:
    """The sparse matrix that gives each vertex the mean of its neighbours."""
    from scipy.sparse import coo_matrix, diags

    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    links = coo_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count)).tocsr()
    links = links + links.T
    return diags(1.0 / np.maximum(np.asarray(links.sum(axis=1)).ravel(), 1.0)) @ links
