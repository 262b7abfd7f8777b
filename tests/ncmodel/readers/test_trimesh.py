"""Why the project reads mesh files itself: what trimesh loses, by format.

A test that fails because trimesh has caught up says that one reason fewer is left for the reader.
"""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from ncmodel.errors import MeshError
from ncmodel.mesh.load import read_geometry
from ncmodel.types import Floats, Ints

ARROW = "0 0 0\n4 0 0\n4 4 0\n2 1 0\n0 4 0\n"
PLY = (
    "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n"
    "element {kind} {count}\nproperty list int int vertex_indices\nend_header\n"
)
FACET = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1{end}\nendloop\nendfacet\n"


def read_by_trimesh(path: Path) -> tuple[Floats, Ints]:
    """Vertices and faces, in the file's order as far as trimesh keeps it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of its own on textures
        mesh: Any = trimesh.load(path, process=False, maintain_order=True)
    mesh = mesh.to_mesh() if isinstance(mesh, trimesh.Scene) else mesh
    return np.asarray(mesh.vertices), np.asarray(getattr(mesh, "faces", np.zeros((0, 3)))).reshape(-1, 3)


def written(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def area(vertices: Floats, faces: Ints) -> float:
    """The sum of the areas of all triangles: larger than the polygon's where they overlap."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.off", "OFF\n5 1 0\n" + ARROW + "5 0 1 2 3 4\n"),
        ("a.ply", PLY.format(vertices=5, kind="face", count=1) + ARROW + "5 0 1 2 3 4\n"),
        ("a.obj", "".join(f"v {line}\n" for line in ARROW.splitlines()) + "f 1 2 3 4 5\n"),
    ],
)
def test_trimesh_loses_the_shape_of_polygons_that_are_not_convex(name: str, text: str, tmp_path: Path) -> None:
    path = written(tmp_path / name, text)
    assert area(*read_geometry(path)) == 10
    assert area(*read_by_trimesh(path)) > 10


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.off", "OFF\n5 2 0\n" + ARROW + "4 0 1 2 4\n3 2 3 4\n"),
        ("a.ply", PLY.format(vertices=5, kind="face", count=2) + ARROW + "4 0 1 2 4\n3 2 3 4\n"),
    ],
)
def test_trimesh_loses_the_order_of_faces(name: str, text: str, tmp_path: Path) -> None:
    path = written(tmp_path / name, text)
    assert read_geometry(path)[1][-1].tolist() == [2, 3, 4]
    assert read_by_trimesh(path)[1][-1].tolist() != [2, 3, 4]


def test_trimesh_loses_that_parts_of_an_obj_share_vertices(tmp_path: Path) -> None:
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nvt 0 0\nvt 1 1\nusemtl a\nf 1/1 2/1 3/1\nusemtl b\nf 1/2 2/2 4/2\n"
    path = written(tmp_path / "a.obj", text)
    assert len(read_geometry(path)[0]) == 4
    assert len(read_by_trimesh(path)[0]) > 4


def test_trimesh_loses_triangle_strips_of_a_ply(tmp_path: Path) -> None:
    strip = PLY.format(vertices=5, kind="tristrips", count=1) + ARROW + "5 0 1 2 3 -1\n"
    path = written(tmp_path / "a.ply", strip)
    assert len(read_geometry(path)[1]) == 2
    assert len(read_by_trimesh(path)[1]) == 0


def test_trimesh_loses_points_with_a_comment_behind_them(tmp_path: Path) -> None:
    path = written(tmp_path / "a.xyz", "# points\n0 0 0 # the first\n1 0 0\n")
    assert len(read_geometry(path)[0]) == 2
    with pytest.raises(ValueError, match="columns"):
        read_by_trimesh(path)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.stl", "solid a\n" + FACET.format(end="")),
        ("a.off", "OFF\n5 2 0\n" + ARROW),
        ("a.ply", PLY.format(vertices=5, kind="face", count=1) + ARROW),
    ],
)
def test_trimesh_loses_that_a_file_breaks_off(name: str, text: str, tmp_path: Path) -> None:
    path = written(tmp_path / name, text)
    with pytest.raises(MeshError, match=name):
        read_geometry(path)
    assert len(read_by_trimesh(path)[1]) == 0
