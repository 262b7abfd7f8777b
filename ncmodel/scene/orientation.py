"""Faces wound so that their fronts lie outwards, where a file has them otherwise.

Lines are those of the front of a surface: a shell that is inside out would show noise, and where neighbouring faces
disagree every edge between them would be a border. So the fewest possible faces are turned to agree with their
neighbours, and then shells around a volume are turned outwards, unless they lie within another one (then they are its
cavities) or around the eye. Sheets have no outside and stay.

That takes no rays, so that a drawing of a sound mesh waits for nothing. Cleaning, which sends rays for other reasons
too, decides by the side that is seen more (`show_fronts` in `dataset_tools.cleaning.repair`); how neighbours come to
agree is the same for both, `wound_alike`.
"""

import math
from dataclasses import replace

import numpy as np

from ncmodel.geometry.adjacency import Offsets, Rings, wound_alike
from ncmodel.geometry.normals_areas import Indices, check_columns
from ncmodel.jit import kernel
from ncmodel.scene.surface import Surface
from ncmodel.tracing import timed
from ncmodel.types import Floats, Ints, Mask

OPEN = 0.1
"""A surface whose openings have more than this share of its area is a sheet."""
THIN = 1e-9
"""A volume below this, relative to the area to the power of 1.5, is rounding noise."""
NEAR = 1e-9
"""Object-space distance below which surfaces lie on each other, neither of them within the other."""


def turn_outwards(surface: Surface, eye: tuple[float, float, float] | None = None) -> Surface:
    """The surface with the fronts of its faces outwards; `surface` itself if they are.

    Args:
        surface: Any surface; its seams should be sewn.
        eye: Where it is seen from.
    """
    mesh, faces = surface.mesh, surface.faces
    rings = None if surface.is_closed else surface.rings
    with timed(surface.trace, "winding"):
        if rings is None:
            shell = surface.shells
            turned = np.zeros(len(faces), dtype=np.bool_)
        else:
            shell, turned = _agreeing(len(faces), rings)
        wound = np.where(turned[:, None], faces[:, ::-1], faces) if turned.any() else faces
        turned ^= _inside_out(mesh.vertices, wound, shell, eye)[shell]
        if not turned.any():
            return surface
        note = f"turned {int(turned.sum())} faces of {len(faces)} outwards"
        whole = np.where(turned[:, None], mesh.faces[:, ::-1], mesh.faces)
    return Surface(replace(mesh, faces=whole, notes=(*mesh.notes, note)), surface.trace, surface.sizing)


def _inside_out(vertices: Floats, faces: Indices, shell: Ints, eye: tuple[float, float, float] | None) -> Mask:
    """(n,) True for the shells to be turned."""
    count = int(shell.max()) + 1
    volume, is_shell = _measured(vertices, faces, shell, count)
    sense = np.where(is_shell, np.sign(volume), 0.0).astype(np.int64)
    found = np.flatnonzero(sense < 0)
    wrong = np.zeros(count, dtype=np.bool_)
    if len(found) == 0:
        return wrong
    tips = vertices[_tips(vertices, faces, shell, count)[found]]
    wrong[found] = _crossings(vertices, faces, shell, sense, tips, found, False) <= 0
    if eye is not None and (np.abs(eye) < np.abs(vertices).max()).all():
        found = np.flatnonzero(wrong)
        wrong[found] = _crossings(vertices, faces, shell, sense, np.tile(eye, (len(found), 1)), found, True) == 0
    return wrong


def _agreeing(count: int, rings: Rings) -> tuple[Ints, Mask]:
    """Faces connected through edges of two faces, and how they come to agree.

    Returns:
        (F,) a number for each face, equal for connected ones; (F,) True for those to be turned, the fewer of each.
    """
    shell, odd = wound_alike(count, *_shared_sides(*rings))
    mostly = np.bincount(shell, odd) > np.bincount(shell, ~odd)
    return shell, odd ^ mostly[shell]


@kernel
def _shared_sides(starts: Offsets, around: Indices, face: Indices) -> tuple[Ints, Mask]:
    """(P, 2) the faces at each edge of two; (P,) whether they run along it in the same direction."""
    pairs, disagree, found = np.empty((len(face) // 2, 2), np.int64), np.empty(len(face) // 2, np.bool_), 0
    seen = np.full(len(starts), -1)
    sides, first, leaving = np.zeros(len(starts), np.int64), np.zeros(len(starts), np.int64), np.zeros(len(starts))
    second, also_leaving = first.copy(), leaving.copy()
    for v in range(len(starts) - 1):
        for n in range(starts[v], starts[v + 1]):
            for out in (0, 1):
                w = around[n, out]
                if w <= v:
                    continue
                if seen[w] != v:
                    seen[w], sides[w] = v, 0
                    first[w], leaving[w] = face[n], out
                else:
                    second[w], also_leaving[w] = face[n], out
                sides[w] += 1
        for n in range(starts[v], starts[v + 1]):
            for w in around[n]:
                if w > v and sides[w] == 2:
                    pairs[found, 0], pairs[found, 1] = first[w], second[w]
                    disagree[found] = leaving[w] == also_leaving[w]
                    found += 1
                    sides[w] = 0
    return pairs[:found], disagree[:found]


@kernel
def _measured(vertices: Floats, faces: Indices, shell: Ints, count: int) -> tuple[Floats, Mask]:
    """Of each shell its volume, and whether it has one to speak of."""
    check_columns(faces, 3)
    # Area, vector area, the area's moment, and the volume of the cones from the origin.
    sums = np.zeros((count, 8))
    for f in range(len(faces)):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        x, y, z = vertices[i, 0], vertices[i, 1], vertices[i, 2]
        ux, uy, uz = vertices[j, 0] - x, vertices[j, 1] - y, vertices[j, 2] - z
        vx, vy, vz = vertices[k, 0] - x, vertices[k, 1] - y, vertices[k, 2] - z
        nx, ny, nz = (uy * vz - uz * vy) / 2, (uz * vx - ux * vz) / 2, (ux * vy - uy * vx) / 2
        area = math.sqrt(nx * nx + ny * ny + nz * nz)
        row = sums[shell[f]]
        row[0] += area
        row[1] += nx
        row[2] += ny
        row[3] += nz
        row[4] += area * (x + (ux + vx) / 3)
        row[5] += area * (y + (uy + vy) / 3)
        row[6] += area * (z + (uz + vz) / 3)
        row[7] += (x * nx + y * ny + z * nz) / 3
    volume, is_shell = np.zeros(count), np.zeros(count, np.bool_)
    for s in range(count):
        area, vector, moment = sums[s, 0], sums[s, 1:4], sums[s, 4:7]
        # From its middle, so that a small opening matters little.
        volume[s] = sums[s, 7] - (moment * vector).sum() / (3 * max(area, 1e-300))
        opening = math.sqrt((vector**2).sum())
        is_shell[s] = opening <= OPEN * area and abs(volume[s]) > THIN * area**1.5
    return volume, is_shell


@kernel
def _tips(vertices: Floats, faces: Indices, shell: Ints, count: int) -> Ints:
    """The vertex of largest x of each shell."""
    tip = np.full(count, -1)
    for f in range(len(faces)):
        s = shell[f]
        for c in range(3):
            if tip[s] < 0 or vertices[faces[f, c], 0] > vertices[tip[s], 0]:
                tip[s] = faces[f, c]
    return tip


@kernel
def _crossings(
    vertices: Floats, faces: Indices, shell: Ints, sense: Ints, points: Floats, own: Ints, same: bool
) -> Ints:
    """(n,) how many shells are around each of (n, 3) points, counted along rays towards +x.

    Args:
        vertices: (V, 3).
        faces: (F, 3).
        shell: (F,) the shell of each face.
        sense: 1 for shells with their fronts outwards, -1 for those inside out, 0 for sheets, which don't count.
        points: (n, 3).
        own: (n,) a shell for each point.
        same: Whether that one alone is counted, with its own sign, or all but that one.
    """
    order = np.argsort(points[:, 1])
    heights = points[order, 1]
    count = np.zeros(len(points), np.int64)
    for f in range(len(faces)):
        s, (a, b, c) = shell[f], (vertices[faces[f, 0]], vertices[faces[f, 1]], vertices[faces[f, 2]])
        if sense[s] == 0:
            continue
        low, high = (
            np.searchsorted(heights, min(a[1], b[1], c[1])),
            np.searchsorted(heights, max(a[1], b[1], c[1]), "right"),
        )
        for n in order[low:high]:
            if (own[n] == s) == same:
                count[n] += sense[s] * _crossing(a, b, c, points[n])
    return count


@kernel
def _crossing(a: Floats, b: Floats, c: Floats, point: Floats) -> int:
    """1 if a ray from the point towards +x leaves through the front of triangle abc, -1 if through its back, else 0.

    Of triangles that share a side, at most one is met on it.
    """
    x, y, z = point
    winding = 0
    for p, q in ((a, b), (b, c), (c, a)):
        if (p[2] <= z) != (q[2] <= z):
            left = (q[1] - p[1]) * (z - p[2]) - (y - p[1]) * (q[2] - p[2])
            winding += int(p[2] <= z and left > 0) - int(q[2] <= z and left < 0)
    if winding == 0:
        return 0
    (ux, uy, uz), (vx, vy, vz) = b - a, c - a
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    depth = a[0] - x + ((a[1] - y) * ny + (a[2] - z) * nz) / nx
    return winding if depth > NEAR else 0
