"""Meshes of other libraries -> `Mesh`, told by their attributes: no library is imported, or needed.

| what | told by |
|---|---|
| scene of trimesh | `graph` and `geometry`: all that has faces, in its places |
| mesh of trimesh, and whatever else has them | `vertices` and `faces` |
| mesh of Open3D | `vertices` and `triangles`; the tensor kind `vertex.positions` and `triangle.indices` |
| PolyData of PyVista | `points` and `faces`, one array with the size before the corners of each polygon |
| mesh of meshio | `points` and `cells`, blocks with `type` and `data` |
| two arrays, or tensors | a pair (vertices, faces) |
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncmodel.errors import ArgumentError, MeshError
from ncmodel.mesh.load import settled
from ncmodel.readers.content import Content, NotAMeshError, joined, placed
from ncmodel.readers.triangulate import triangulate
from ncmodel.types import Floats, Ints, Mesh

_TAKEN = "a file's path, a Surface or a Mesh, (vertices, faces), or a mesh of trimesh, PyVista, Open3D or meshio"
"""By what draws."""

_CORNERS = {"triangle": 3, "quad": 4}
"""Of meshio's cells; those of higher order (triangle6, quad8, quad9) have the points inside their edges behind them."""


def as_mesh(shape: Any, up: str = "y") -> Mesh:
    """A normalised mesh of another library's, or of arrays, as `load_mesh` makes one of a file.

    Polygons become triangles, the parts of a scene one mesh, loose triangles are welded.

    Args:
        shape: A mesh or scene of trimesh, PolyData of PyVista, a mesh of Open3D or meshio, or a pair of (V, 3) vertices
            and (F, n) faces or polygons of any size, in arrays, lists or tensors on any device. A `Mesh` is normalised.
        up: Its upward axis, "y" or "z".

    Raises:
        MeshError: It has no faces, or numbers that make no mesh.
        ArgumentError: It is something else, or `up` is.
    """
    name = _name(shape)
    try:
        content = _content(shape)
    except NotAMeshError as error:
        raise MeshError(name, str(error), "a mesh with faces") from error
    except (ValueError, TypeError, OverflowError) as error:
        raise MeshError(name, f"no arrays of numbers ({error})", "shapes (V, 3) and (F, n)") from error
    if content is None:
        raise ArgumentError("shape", type(shape).__name__, _TAKEN)
    return settled(content, name, up)


def _content(shape: Any) -> Content | None:
    """Vertices and triangles of an object; nothing if it is of no kind that is known."""
    if _has(shape, "graph", "geometry"):
        return _scene(shape)
    if _has(shape, "vertices", "faces"):
        return _polygons(shape.vertices, shape.faces)
    if _has(shape, "vertices", "triangles"):
        return _polygons(shape.vertices, shape.triangles)
    if _has(shape, "vertex", "triangle"):
        return _polygons(shape.vertex.positions, shape.triangle.indices)
    if _has(shape, "points", "faces"):
        return _poly_data(shape)
    if _has(shape, "points", "cells"):
        return _cells(shape)
    if isinstance(shape, (tuple, list)) and len(shape) == 2:
        return _polygons(*shape)
    return None


def _has(shape: Any, *names: str) -> bool:
    return all(hasattr(shape, name) for name in names)


def _scene(scene: Any) -> Content:
    """All geometry of a scene that has faces, where its nodes put it."""
    parts, others = [], 0
    for node in scene.graph.nodes_geometry:
        matrix, name = scene.graph[node]
        part = _content(scene.geometry[name])
        if part is None or len(part.faces) == 0:
            others += 1
        else:
            parts.append(placed((part.vertices, part.faces), np.asarray(matrix)))
    if not parts:
        raise NotAMeshError(f"{others} parts without faces")
    notes = (f"{others} parts without faces are passed over",) if others else ()
    return Content(*joined(parts), notes)


def _poly_data(data: Any) -> Content:
    """The polygons of PolyData; its lines and points are passed over."""
    if len(getattr(data, "strips", ())):
        raise NotAMeshError("triangle strips, which PolyData.triangulate() turns into faces")
    stream = _array(data.faces).astype(np.int64)
    starts, at = [], 0
    while at < len(stream):
        starts.append(at)
        at += 1 + int(stream[at])
    if at != len(stream):
        raise ValueError("faces end inside a polygon")
    sizes = stream[starts]
    return _triangles(_array(data.points), np.delete(stream, starts), sizes)


def _cells(mesh: Any) -> Content:
    """The triangles, quads and polygons of a meshio mesh; lines and what bounds a volume's cells are passed over."""
    points = _array(mesh.points)
    if points.ndim == 2 and points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    corners, sizes = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    for block in mesh.cells:
        kind = str(block.type).rstrip("0123456789")
        if kind in _CORNERS or kind == "polygon":
            rows = _array(block.data)[:, : _CORNERS.get(kind)]
            corners.append(rows.ravel())
            sizes.append(np.full(len(rows), rows.shape[1]))
    if len(sizes) == 1:
        kinds = ", ".join(sorted({str(block.type) for block in mesh.cells})) or "no cells"
        raise NotAMeshError(f"{kinds}, but no triangles, quads or polygons")
    return _triangles(points, np.concatenate(corners), np.concatenate(sizes))


def _polygons(vertices: Any, faces: Any) -> Content:
    """Vertices, and faces that are the rows of an array or lists of corners."""
    points = _array(vertices)
    if isinstance(faces, Sequence) and len({len(corners) for corners in faces}) > 1:
        rings = [_array(corners) for corners in faces]
        return _triangles(points, np.concatenate(rings), np.array([len(ring) for ring in rings]))
    corners = _array(faces)
    if len(corners) == 0:
        raise NotAMeshError(f"{len(points)} vertices and no faces")
    if corners.ndim != 2 or corners.shape[1] < 3:
        raise ValueError(f"faces of shape {corners.shape}")
    return _triangles(points, corners.ravel(), np.full(len(corners), corners.shape[1]))


def _triangles(vertices: NDArray[Any], corners: NDArray[Any], sizes: Ints) -> Content:
    points: Floats = np.asarray(vertices, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"vertices of shape {points.shape}")
    whole = corners.astype(np.int64)
    if (whole != corners).any():
        raise ValueError("faces with fractions")
    return Content(points, triangulate(points, whole, sizes.astype(np.int64)))


def _array(values: Any) -> NDArray[Any]:
    """An array of what may be a tensor, with a gradient or on a device."""
    for step in ("detach", "cpu"):
        values = getattr(values, step)() if hasattr(values, step) else values
    return np.asarray(values.numpy() if hasattr(values, "numpy") else values)


def _name(shape: Any) -> str:
    """What its library calls it: by name, or after its file."""
    known = getattr(shape, "metadata", None)
    known = known if isinstance(known, dict) else {}
    name = getattr(shape, "name", None) or known.get("name") or Path(str(known.get("file_name") or "mesh")).stem
    return str(name)
