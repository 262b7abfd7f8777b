"""Meshes of other libraries are drawn as the same mesh in a file, in their places and with their names."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import torch
import trimesh

from ncmodel import draw_shape
from ncmodel.errors import ArgumentError, MeshError
from ncmodel.mesh.load import make_mesh
from ncmodel.mesh.objects import as_mesh
from ncmodel.types import Mesh
from tests.helpers.mesh_files import tetrahedron

VERTICES, FACES = tetrahedron()
BOX = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)])
QUADS = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
BLOCK = SimpleNamespace
FLAT = np.column_stack([np.full(len(FACES), 3), FACES]).ravel()
"""Faces as PyVista has them."""

SAME: dict[str, Any] = {
    "trimesh": trimesh.Trimesh(VERTICES, FACES, process=False),
    "scene": trimesh.Scene(trimesh.Trimesh(VERTICES, FACES, process=False)),
    "pyvista": SimpleNamespace(points=VERTICES.astype(np.float32), faces=FLAT, strips=np.zeros(0, int)),
    "open3d": SimpleNamespace(vertices=list(VERTICES), triangles=list(FACES)),
    "open3d tensors": SimpleNamespace(
        vertex=SimpleNamespace(positions=torch.tensor(VERTICES)),
        triangle=SimpleNamespace(indices=torch.tensor(FACES)),
    ),
    "meshio": SimpleNamespace(
        points=VERTICES, cells=[BLOCK(type="line", data=FACES[:, :2]), BLOCK(type="triangle", data=FACES)]
    ),
    "meshio, second order": SimpleNamespace(points=VERTICES, cells=[BLOCK(type="triangle6", data=np.tile(FACES, 2))]),
    "arrays": (VERTICES, FACES.astype(np.uint32)),
    "lists": (VERTICES.tolist(), FACES.tolist()),
    "tensors": (torch.tensor(VERTICES, requires_grad=True), torch.tensor(FACES)),
}


@pytest.mark.parametrize("kind", SAME)
def test_one_mesh_is_the_same_in_all_libraries(kind: str) -> None:
    expected = make_mesh(VERTICES, FACES)
    found = as_mesh(SAME[kind])
    np.testing.assert_allclose(found.vertices, expected.vertices, atol=1e-12)
    np.testing.assert_array_equal(found.faces, expected.faces)
    assert found.name == "mesh"


@pytest.mark.parametrize(
    "shape",
    [
        (BOX, QUADS),
        (BOX, [[0, 1, 3, 2], *QUADS[1:5].tolist(), [1, 5, 7], [1, 7, 3]]),
        SimpleNamespace(points=BOX, faces=np.column_stack([np.full(6, 4), QUADS]).ravel()),
        SimpleNamespace(points=BOX, cells=[BLOCK(type="quad", data=QUADS[:3]), BLOCK(type="polygon", data=QUADS[3:])]),
    ],
)
def test_polygons_become_triangles(shape: Any) -> None:
    mesh = as_mesh(shape)
    assert len(mesh.faces) == 12
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    assert np.einsum("fi,fi->", a, np.cross(b, c)) / 6 == pytest.approx(1.0)


def test_a_polygon_that_is_not_convex_keeps_its_shape() -> None:
    arrow = np.array([[0.0, 0, 0], [4, 0, 0], [4, 4, 0], [2, 1, 0], [0, 4, 0]])
    mesh = as_mesh((arrow, [[0, 1, 2, 3, 4]]))
    a, b, c = (mesh.vertices[mesh.faces[:, k]] * 4 for k in range(3))
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 == pytest.approx(10.0)


def scene_of_two() -> trimesh.Scene:
    """A box twice, 3 apart, one of them mirrored, beside a path."""
    box = trimesh.creation.box((1, 1, 1))
    scene = trimesh.Scene()
    scene.add_geometry(box, geom_name="box", transform=np.diag([-1.0, 1, 1, 1]))
    moved = np.eye(4)
    moved[0, 3] = 3
    scene.add_geometry(box, geom_name="again", transform=moved)
    scene.add_geometry(trimesh.load_path(np.array([[[0.0, 0, 0], [9, 9, 9]]])))
    return scene


def test_a_scene_is_all_of_its_parts_in_their_places() -> None:
    mesh = as_mesh(scene_of_two())
    assert len(mesh.faces) == 24
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), [1, 0.25, 0.25])
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    assert np.einsum("fi,fi->", a, np.cross(b, c)) / 6 == pytest.approx(2 / 64), "a mirrored part stays outside out"
    assert mesh.notes == ("1 parts without faces are passed over",)


def test_loose_triangles_are_welded_as_in_files() -> None:
    loose = VERTICES[FACES.ravel()]
    assert len(as_mesh((loose, np.arange(12).reshape(4, 3))).vertices) == 4


def test_names_and_the_upward_axis() -> None:
    named = trimesh.Trimesh(VERTICES, FACES, metadata={"file_name": "parts/wheel.stl"})
    assert as_mesh(named).name == "wheel"
    assert as_mesh(Mesh(VERTICES, FACES, "wing")).name == "wing"
    x, y, z = as_mesh(named).vertices.T
    turned = as_mesh(named, up="z")
    np.testing.assert_array_equal(turned.vertices, np.stack([x, z, -y], axis=1))


def test_what_another_library_made_is_drawn() -> None:
    torus = trimesh.creation.torus(1.0, 0.4, 24, 12)
    plain = draw_shape(make_mesh(torus.vertices, torus.faces), size=64).ink()
    assert plain.sum() > 10
    for shape in (torus, trimesh.Scene(torus), (torch.tensor(torus.vertices), torch.tensor(torus.faces))):
        np.testing.assert_array_equal(draw_shape(shape, size=64).ink(), plain)
    assert (draw_shape(torus, size=64, up="z").ink() != plain).any()


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        (trimesh.Scene(), "mesh: 0 parts without faces; expected a mesh with faces"),
        ((VERTICES, []), "mesh: 4 vertices and no faces; expected a mesh with faces"),
        ((VERTICES, FACES + 1), "mesh: no arrays of numbers .faces use vertices 1..4, the mesh has 4"),
        ((VERTICES, FACES + 0.5), "faces with fractions"),
        ((VERTICES[:, :2], FACES), r"vertices of shape \(4, 2\)"),
        ((VERTICES, "abc"), "faces of shape|no arrays"),
        ((VERTICES * np.nan, FACES), "vertex 0 is .*; expected finite coordinates"),
        (SimpleNamespace(points=VERTICES, faces=np.array([3, 0, 1])), "faces end inside a polygon"),
        (SimpleNamespace(points=VERTICES, faces=FLAT, strips=np.array([3, 0, 1, 2])), "triangle strips"),
        (SimpleNamespace(points=VERTICES, cells=[BLOCK(type="tetra", data=FACES[:1])]), "tetra, but no triangles"),
    ],
)
def test_what_is_no_mesh_is_told_in_one_line(shape: Any, message: str) -> None:
    with pytest.raises(MeshError, match=message) as caught:
        as_mesh(shape)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("shape", [None, 3, np.zeros((3, 3)), (VERTICES, FACES, 1), object()])
def test_other_objects_are_an_error_that_says_what_is_taken(shape: Any) -> None:
    message = r"shape: found .*a mesh of trimesh, PyVista, Open3D or meshio"
    with pytest.raises(ArgumentError, match=message):
        as_mesh(shape)


def test_poly_data_of_pyvista_itself() -> None:
    pyvista = pytest.importorskip("pyvista")
    mesh = as_mesh(pyvista.Cube())
    assert len(mesh.faces) == 12
    assert len(as_mesh(pyvista.PolyData(VERTICES, FLAT)).faces) == 4


def test_a_mesh_of_meshio_itself() -> None:
    meshio = pytest.importorskip("meshio")
    assert len(as_mesh(meshio.Mesh(VERTICES, [("triangle", FACES)])).faces) == 4


def test_meshes_of_open3d_themselves() -> None:
    open3d = pytest.importorskip("open3d")
    box = open3d.geometry.TriangleMesh.create_box()
    for shape in (box, open3d.t.geometry.TriangleMesh.from_legacy(box)):
        assert len(as_mesh(shape).faces) == 12
