"""Mesh files and arrays -> `Mesh` in object space.

Vertex and face order are those of the file; nothing is repaired. Loose triangles, and formats that can't share a vertex
between faces or between attributes (STL, glTF), are welded where positions are equal up to rounding: they would have
no lines.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ncmodel.errors import ArgumentError, MeshError
from ncmodel.mesh.weld import weld, without_cracks
from ncmodel.readers import cad, formats
from ncmodel.readers.content import Content, NotAMeshError
from ncmodel.types import Floats, Ints, Mesh

SUFFIXES = formats.SUFFIXES
"""The file formats read."""

_WELDED_SUFFIXES = (".stl", ".gltf", ".glb", *cad.SUFFIXES)
_LOOSE = 1.5
"""A mesh with more vertices a face than this is in loose triangles, whatever its format; surfaces have about half."""
_ALREADY_NORMALISED = 1e-6
"""Relative: a mesh this close to normalised is left as it is, so that numbers survive a round trip in float32."""


def load_mesh(path: str | Path, up: str = "y") -> Mesh:
    """Read a mesh file and normalise it.

    Scenes become one mesh, with their transforms applied; polygons become triangles; a file with points alone becomes
    the surface through them. `Mesh.notes` says what was done.

    Args:
        path: One of `SUFFIXES`.
        up: The file's upward axis, "y" or "z".

    Raises:
        MeshError: The file is missing, unreadable, not a mesh, empty, or has coordinates that aren't numbers.
        UsageError: `up` is something else.
    """
    return settled(_read(path), Path(path).stem, up, path)


def settled(content: Content, name: str, up: str = "y", source: str | Path | None = None) -> Mesh:
    """What was read, in object space: normalised, with faces, welded where nothing shares its vertices.

    Args:
        content: What was read.
        name: The shape's name.
        up: Its upward axis, "y" or "z".
        source: The file, if it comes from one.

    Raises:
        MeshError: As of `load_mesh`.
        UsageError: `up` is something else.
    """
    vertices, faces, notes = upright(content.vertices, up), content.faces, list(content.notes)
    if len(faces) == 0:
        finite = np.isfinite(vertices).all(axis=1)
        if not finite.all():
            notes.append(f"left out {np.count_nonzero(~finite)} points whose coordinates aren't numbers")
        vertices, faces = _surface_through(vertices[finite], source or name)
        notes.append(f"reconstructed {len(faces)} faces from points (screened Poisson)")
    split = source is not None and Path(source).suffix.lower() in _WELDED_SUFFIXES
    loose = split or len(vertices) > _LOOSE * len(faces)
    stored = len(vertices)
    if loose:
        vertices, faces = weld(vertices, faces)
    mesh = make_mesh(vertices, faces, name, tuple(notes), source=source, millimetres=content.millimetres)
    return without_cracks(mesh, stored) if loose else mesh


def read_geometry(path: str | Path) -> tuple[Floats, Ints]:
    """The (V, 3) vertices and (F, 3) faces of a mesh file as they are: not checked, not welded, not normalised.

    Raises:
        MeshError: The file is missing, unreadable or not a mesh.
    """
    content = _read(path)
    return content.vertices, content.faces


def _read(path: str | Path) -> Content:
    suffix = Path(path).suffix.lower()
    if Path(path).is_dir():
        raise MeshError(path, "a folder", "a mesh file")
    if suffix not in SUFFIXES:
        raise MeshError(path, f"the suffix is {suffix!r}", f"a mesh file ({' '.join(SUFFIXES)})")
    if not Path(path).is_file():
        raise MeshError(path, "no such file", "a mesh file")
    try:
        # Numbers that aren't any are told by who uses the mesh.
        with np.errstate(over="ignore", invalid="ignore"):
            return formats.read_mesh(Path(path))
    except NotAMeshError as error:
        raise MeshError(path, str(error), "a mesh with faces") from error
    except (ValueError, OverflowError) as error:
        raise MeshError(path, f"not readable as {suffix}: {error}", "a mesh file") from error


def _surface_through(points: Floats, path: str | Path) -> tuple[Floats, Ints]:
    """A surface through the points of a file without faces."""
    from ncmodel.mesh.reconstruct import FEWEST, reconstruct

    expected = f"a mesh with faces, or at least {FEWEST} points of a surface"
    if len(points) == 0:
        raise MeshError(path, "no vertices", expected)
    try:
        return reconstruct(points)
    except ValueError as error:
        raise MeshError(path, f"no faces, and {error}", expected) from error
    except ImportError as error:
        raise MeshError(path, f"no faces, and pymeshlab can't be loaded ({error})", expected) from error


def upright(vertices: Floats, up: str) -> Floats:
    """Turn vertices so that the file's upward axis becomes +y.

    Raises:
        UsageError: `up` is neither "y" nor "z".
    """
    turn = _UP.get(up)
    if turn is None:
        raise ArgumentError("up", repr(up), "y or z")
    return turn(vertices)


def make_mesh(
    vertices: ArrayLike,
    faces: ArrayLike,
    name: str = "mesh",
    notes: tuple[str, ...] = (),
    source: str | Path | None = None,
    millimetres: float = 1.0,
) -> Mesh:
    """A normalised mesh from arrays.

    Args:
        vertices: (V, 3).
        faces: (F, 3) vertex indices.
        name: The shape's name.
        notes: What was done to it so far.
        source: The file to name in error messages; the shape's name by default.
        millimetres: In a unit of the coordinates.

    Raises:
        MeshError: They aren't arrays of numbers, there are no faces, an index is out of range, a coordinate isn't
            finite, or the mesh is one point.
    """
    label = source if source is not None else name
    try:
        points = np.ascontiguousarray(vertices, dtype=np.float64)
        corners = np.asarray(faces)
        triangles = np.ascontiguousarray(corners, dtype=np.int64)
        whole = bool((triangles == corners).all())
    except (TypeError, ValueError, OverflowError) as error:
        raise MeshError(label, f"no arrays of numbers ({error})", "shapes (V, 3) and (F, 3)") from error
    if not whole:
        raise MeshError(label, "faces with fractions", "whole vertex indices")
    if points.ndim != 2 or points.shape[1] != 3 or triangles.ndim != 2 or triangles.shape[1] != 3:
        found = f"vertices of shape {points.shape} and faces of shape {triangles.shape}"
        raise MeshError(label, found, "shapes (V, 3) and (F, 3), at least one face")
    if len(triangles) == 0:
        raise MeshError(label, f"{len(points)} vertices and no faces", "a mesh with faces")
    if triangles.min() < 0 or triangles.max() >= len(points):
        found = f"faces use vertices {triangles.min()}..{triangles.max()}"
        raise MeshError(label, found, f"indices in 0..{len(points) - 1}")
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        found = f"vertex {bad[0]} is {points[bad[0]].tolist()} ({len(bad)} such vertices)"
        raise MeshError(label, found, "finite coordinates")
    used = np.zeros(len(points), dtype=bool)
    used[triangles] = True
    if bool((points[used] == points[triangles[0, 0]]).all()):
        raise MeshError(
            label, f"all faces lie at one point, {points[triangles[0, 0]].tolist()}", "a shape of some size"
        )
    extent_of = points if used.all() else points[used]
    placed = normalise(points, extent_of)
    if not np.isfinite(placed).all():
        raise MeshError(label, "unreferenced vertices infinitely far from the faces", "a shape of some size")
    with np.errstate(over="ignore"):
        longest = float((extent_of.max(axis=0) - extent_of.min(axis=0)).max()) * millimetres
    return Mesh(placed, triangles, name, notes, longest if 0.0 < longest < np.inf else None)


def normalise(vertices: Floats, extent_of: Floats | None = None) -> Floats:
    """Move the bounding box's centre to the origin and scale its longest side to 1.

    Args:
        vertices: (V, 3) finite, not all equal.
        extent_of: (n, 3) the points whose box counts; `vertices` by default.

    Returns:
        (V, 3); `vertices` themselves where they are normalised already.
    """
    box = vertices if extent_of is None else extent_of
    low, high = box.min(axis=0), box.max(axis=0)
    # Halves, because the sum and the difference of two huge numbers overflow.
    centre, half = low / 2 + high / 2, float((high / 2 - low / 2).max())
    if np.abs(centre).max() <= _ALREADY_NORMALISED and abs(half - 0.5) <= _ALREADY_NORMALISED:
        return vertices
    # Dividing before doubling keeps denormal sizes from vanishing; what overflows is for the caller to find.
    with np.errstate(over="ignore"):
        return np.asarray((vertices - centre) / half / 2)


def _y_up(vertices: Floats) -> Floats:
    return vertices


def _z_up(vertices: Floats) -> Floats:
    x, y, z = vertices.T
    return np.stack([x, z, -y], axis=1)


_UP: dict[str, Callable[[Floats], Floats]] = {"y": _y_up, "z": _z_up}
