"""Loaded meshes: scenes, upward axis, normalisation, and arrays that are no mesh."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from ncmodel.errors import MeshError, UsageError
from ncmodel.mesh.load import load_mesh, make_mesh, normalise
from tests.helpers import analytic
from tests.helpers.dirty import signed_volume
from tests.helpers.mesh_files import as_obj, tetrahedron


def test_scenes_are_joined_where_their_transforms_put_them(tmp_path: Path) -> None:
    """Two boxes, one mirrored and moved: both outwards, apart by what the transform says."""
    box = trimesh.creation.box((1, 1, 1))
    mirrored = np.diag([-1.0, 1, 1, 1])
    mirrored[0, 3] = 3
    scene = trimesh.Scene()
    scene.add_geometry(box)
    scene.add_geometry(box, transform=mirrored)
    scene.export(str(tmp_path / "two.glb"))
    mesh = load_mesh(tmp_path / "two.glb")
    assert len(mesh.faces) == 24
    assert signed_volume(mesh.vertices, mesh.faces) == pytest.approx(2 / 4**3, rel=1e-6)
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), [1, 0.25, 0.25], rtol=1e-6)


def test_z_up_stands_upright(tmp_path: Path) -> None:
    """What points up along z in the file points up along y; the turn is a rotation."""
    vertices, faces = tetrahedron()
    vertices[3] = [0, 0, 5]
    (tmp_path / "a.obj").write_bytes(as_obj(vertices, faces))
    mesh = load_mesh(tmp_path / "a.obj", up="z")
    assert mesh.vertices[3, 1] == 0.5
    np.testing.assert_allclose(mesh.vertices[2] - mesh.vertices[0], [0, 0, -0.2], atol=1e-15)
    with pytest.raises(UsageError, match="expected y or z"):
        load_mesh(tmp_path / "a.obj", up="x")


@pytest.mark.parametrize("size", [1e-300, 1e-12, 1.0, 1e12, 1e307])
def test_any_size_is_normalised(size: float) -> None:
    vertices, faces = analytic.torus(12, 8)
    mesh = make_mesh(vertices * size, faces)
    assert np.ptp(mesh.vertices, axis=0).max() == pytest.approx(1, rel=1e-12)
    np.testing.assert_allclose(mesh.vertices, vertices, atol=1e-12)


def test_far_from_the_origin() -> None:
    """At 1e7 from the origin a unit object keeps nine digits."""
    vertices, faces = analytic.torus(12, 8)
    np.testing.assert_allclose(make_mesh(vertices + 1e7, faces).vertices, vertices, atol=2e-9)


def test_normalising_twice_changes_no_bit() -> None:
    rng = np.random.default_rng(1)
    once = normalise(rng.normal(size=(100, 3)))
    assert normalise(once) is once
    in_float32 = once.astype(np.float32).astype(np.float64)
    assert normalise(in_float32) is in_float32


def test_stray_vertices_dont_shrink_the_shape() -> None:
    vertices, faces = tetrahedron()
    mesh = make_mesh(np.concatenate([vertices, [[1e6, 0, 0]]]), faces)
    assert np.ptp(mesh.vertices[:4], axis=0).max() == 1


def test_bad_arrays() -> None:
    vertices, faces = tetrahedron()
    for wrong_vertices, wrong_faces in (
        (vertices[:, :2], faces),
        (vertices, faces[:, :2]),
        (vertices, faces[:0]),
        (vertices, faces + 1),
        (vertices, faces - 1),
        (np.concatenate([vertices * 1e-300, [[1e300, 0, 0]]]), faces),
    ):
        with pytest.raises(MeshError):
            make_mesh(wrong_vertices, wrong_faces)


def test_real_files(bundled: Path) -> None:
    """The sample meshes: textured OBJ with fewer texture than position indices, range scan, binary and text PLY."""
    for name, count in (("bunny.obj", 56172), ("bunny10k_textured.obj", None), ("bone.ply", 3022), ("cow.obj", 5804)):
        mesh = load_mesh(bundled / name)
        assert count is None or len(mesh.faces) == count
        assert np.ptp(mesh.vertices, axis=0).max() == pytest.approx(1, rel=1e-9)
