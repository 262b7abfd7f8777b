"""Height maps whose heights are rounded to few levels, as pictures of 8 bits are, drawn without the terraces.

Each terrace would have an edge that looks like a form's. A mesh is a rounded height map if it has many vertices whose
heights along one direction (an axis, or that in which a grid bends) are evenly spaced levels, few and narrow; if
nothing overhangs; and if its steps are those of rounding: real ones, of stairs and buildings, are several levels high,
or go straight on and turn at corners, while those of a slope that was rounded turn at every other vertex.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ncmodel.geometry.adjacency import Offsets, Rings
from ncmodel.geometry.dequantisation import dequantised
from ncmodel.geometry.normals_areas import Indices, check_columns
from ncmodel.jit import kernel
from ncmodel.scene.surface import Surface
from ncmodel.tracing import timed
from ncmodel.types import Floats, Ints, Mask, Mesh

SMALLEST = 1000
"""Meshes of fewer vertices are no height maps, or too coarse for levels to be seen."""
SAMPLE = 2000
"""So many faces tell most meshes from rounded height maps."""
SAME = 2e-5
"""Heights closer than this, in object space, are one level, apart by a file's rounding."""
REPEATED = 0.25
"""Of a sample of heights, at most this share is different."""
FEWEST = 12
"""Fewer levels are steps."""
WIDEST = 0.01
"""Levels farther apart than this, in object space, are steps."""
OFF = 0.1
"""Levels that a height may be beside the nearest one."""
EVEN = 0.95
"""Of the levels at least this share is evenly spaced; a base may lie between."""
CROWDED = 32
"""Corners at a vertex beyond which no more are looked at: a grid has 8."""
CLIFF = 40.0
"""Faces over more levels than this are walls."""
OVERHANGING = 0.02
"""Share of a height map's slopes that may face the other way."""
BROKEN, STRAIGHT = 0.25, 0.9
"""Shares of neighbouring faces, one a real step apart, and in one plane, from which on steps are meant."""


@dataclass(frozen=True, eq=False)
class _Heights:
    """The direction of a mesh's heights, as a unit vector, their levels' distance, and the height of one of them."""

    direction: Floats
    level: float
    origin: float


def without_terraces(surface: Surface) -> Surface:
    """The surface of a rounded height map, smoothed within one level; all others as they are."""
    mesh = surface.mesh
    if len(mesh.vertices) < SMALLEST:
        return surface
    rings = surface.rings
    with timed(surface.trace, "terraces"):
        for heights in _level_heights(mesh, rings):
            if _slopes(*_placed(mesh.vertices[_sample(mesh.faces)], heights)) is None:
                continue
            plan, exact = _placed(mesh.vertices, heights)
            levels = np.round(exact)
            sloping = _slopes(plan[mesh.faces], exact[mesh.faces])
            if sloping is not None and not _stepped(plan, levels, *rings, sloping):
                break
        else:
            return surface
        moved = (dequantised(levels, plan, rings, sloping) - levels) * heights.level
        count = len(np.unique(levels[mesh.faces[sloping]]))
        note = f"smoothed heights that were rounded to {count} levels, by at most one level"
        vertices = mesh.vertices + moved[:, None] * heights.direction
    return Surface(replace(mesh, vertices=vertices, notes=(*mesh.notes, note)), surface.trace, surface.sizing)


def _level_heights(mesh: Mesh, rings: Rings) -> Iterator[_Heights]:
    """The directions along which a sample of a mesh's vertices has evenly spaced levels; most faces face the first."""
    vertices = mesh.vertices
    faces = _sample(mesh.faces)
    points = vertices[np.unique(faces)]
    bends = _bends(vertices, rings.starts, rings.around, max(len(vertices) // SAMPLE, 1))
    directions = np.concatenate([np.eye(3), np.linalg.eigh(bends)[1][:, -1:].T])
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for direction in directions[np.argsort(-np.abs(normals @ directions.T).sum(axis=0), kind="stable")]:
        heights = np.sort(points @ direction)
        first = np.flatnonzero(np.diff(heights, prepend=-np.inf) > SAME)
        if not FEWEST <= len(first) <= REPEATED * len(heights):
            continue
        different = np.add.reduceat(heights, first) / np.diff(first, append=len(heights))
        steps = np.diff(different)
        unit = float(np.quantile(steps, 0.1))
        whole = np.round(steps / unit)
        even = (np.abs(steps / unit - whole) <= OFF) & (whole > 0.0)
        if np.count_nonzero(even) < EVEN * len(steps):
            continue
        level = float(steps[even].sum() / whole[even].sum())
        if level <= WIDEST:
            # Levels are whole turns of a circle, so that those beside a base are no matter.
            turn = float(np.angle(np.exp(2j * np.pi * different / level).mean())) / (2.0 * np.pi)
            yield _Heights(direction, level, turn * level)


@kernel
def _bends(vertices: Floats, starts: Offsets, around: Indices, stride: int) -> Floats:
    """(3, 3) sum of b b^T over edges of a sample of vertices, b from the middle of an edge to that of the far corners.

    On a grid seen from above both middles are one point, so that b is along the heights, however the mesh is turned.
    """
    check_columns(vertices, 3)
    check_columns(around, 2)
    total, bend = np.zeros((3, 3)), np.empty(3)
    for v in range(0, len(starts) - 1, stride):
        for n in range(starts[v], starts[v + 1]):
            i, j = around[n, 0], around[n, 1]
            for m in range(starts[v], min(starts[v + 1], starts[v] + CROWDED)):
                if around[m, 1] == i:
                    w = around[m, 0]
                    for axis in range(3):
                        bend[axis] = vertices[v, axis] + vertices[i, axis] - vertices[j, axis] - vertices[w, axis]
                    for row in range(3):
                        for column in range(3):
                            total[row, column] += bend[row] * bend[column]
    return total


def _sample(faces: Ints) -> Ints:
    return faces[:: max(len(faces) // SAMPLE, 1)]


def _placed(points: Floats, heights: _Heights) -> tuple[Floats, Floats]:
    """Where points (.., 3) lie seen from above (.., 2), and how high (..), in levels."""
    up = heights.direction
    first = np.cross(up, np.eye(3)[np.abs(up).argmin()])
    first /= np.linalg.norm(first)
    across = np.stack([first, np.cross(up, first)], axis=1)
    return points @ across, (points @ up - heights.origin) / heights.level


def _slopes(plan: Floats, exact: Floats) -> Mask | None:
    """(F,) the faces of the terrain; None if it overhangs or consists of walls.

    Args:
        plan: (F, 3, 2) where the faces' corners lie, seen from above.
        exact: (F, 3) how high, in levels.
    """
    levels = np.round(exact)
    one, other = plan[:, 1] - plan[:, 0], plan[:, 2] - plan[:, 0]
    area = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
    rise = np.ptp(levels, axis=1)
    upright = np.abs(area) <= SAME * SAME
    inclined = (rise > 0.0) & ~upright
    up, down = np.count_nonzero(inclined & (area > 0.0)), np.count_nonzero(inclined & (area < 0.0))
    if min(up, down) > OVERHANGING * max(up, down):
        return None
    level = (np.abs(exact - levels) <= OFF).all(axis=1)
    sloping = ~upright & (rise <= CLIFF) & level & ((area > 0.0) == (up > down))
    gentle = np.count_nonzero(sloping & inclined)
    walls = np.count_nonzero(rise > 0.0) - gentle
    return None if gentle <= walls else np.asarray(sloping)


def _stepped(plan: Floats, levels: Floats, starts: Offsets, around: Indices, face: Indices, sloping: Mask) -> bool:
    """Whether the steps between levels are meant."""
    inclined, broken, both, straight = _neighbouring(plan, levels, starts, around, face, sloping)
    return bool(broken > BROKEN * inclined or straight > STRAIGHT * both)


@kernel
def _neighbouring(
    plan: Floats, levels: Floats, starts: Offsets, around: Indices, face: Indices, sloping: Mask
) -> tuple[int, int, int, int]:
    """How many pairs of neighbouring faces are inclined, one of them at least; of those, how many a real step apart.

    And how many are inclined both; of those, how many lie in one plane.
    """
    check_columns(plan, 2)
    check_columns(around, 2)
    inclined, broken, both, straight = 0, 0, 0, 0
    for v in range(len(starts) - 1):
        for n in range(starts[v], starts[v + 1]):
            i, j = around[n, 0], around[n, 1]
            if i < v or not sloping[face[n]]:
                continue
            for m in range(starts[v], min(starts[v + 1], starts[v] + CROWDED)):
                if around[m, 1] != i or not sloping[face[m]]:
                    continue
                w = around[m, 0]
                one = levels[i] != levels[v] or levels[j] != levels[v]
                other = levels[i] != levels[v] or levels[w] != levels[v]
                if not (one or other):
                    continue
                # How far the far corner of the second face is above the plane of the first.
                ax, ay = plan[i, 0] - plan[v, 0], plan[i, 1] - plan[v, 1]
                bx, by = plan[j, 0] - plan[v, 0], plan[j, 1] - plan[v, 1]
                cx, cy = plan[w, 0] - plan[v, 0], plan[w, 1] - plan[v, 1]
                area = ax * by - ay * bx
                along, beyond = (cx * by - cy * bx) / area, (ax * cy - ay * cx) / area
                plane = along * (levels[i] - levels[v]) + beyond * (levels[j] - levels[v])
                above = abs(levels[w] - levels[v] - plane)
                inclined += 1
                # Rounding moves each of four corners by half a level.
                broken += above > 2.0 + OFF
                if one and other:
                    both += 1
                    straight += above < OFF
    return inclined, broken, both, straight
