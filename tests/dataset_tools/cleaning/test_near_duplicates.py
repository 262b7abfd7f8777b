"""Duplicates: the same shape however it is turned, scaled, ordered and meshed; and nothing else."""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from dataset_tools.build.build import build_dataset
from dataset_tools.build.config import BuildConfig
from dataset_tools.build.mesh_files import find_sources
from dataset_tools.build.runners import HereRunner
from dataset_tools.cleaning.near_duplicates import NEAR, candidate_pairs, compared_before, decide, to_json
from dataset_tools.cleaning.repair import clean_file
from dataset_tools.cleaning.shape_distance import invariants, surface_distance
from dataset_tools.simulation.shapes import make_shapes
from ncmodel.readers.ply import ply_bytes
from ncmodel.types import Floats, Mesh
from tests.helpers import dirty

TOLERANCE = BuildConfig().duplicate_distance


def lumpy(fineness: int = 4) -> Mesh:
    """A shape without any symmetry."""
    vertices, faces = dirty.sphere(fineness=fineness)
    x, y, z = vertices.T
    bumps = 1 + 0.25 * np.sin(2 * x + 1) + 0.2 * np.cos(3 * z - y) + 0.2 * x * z + 0.15 * np.sin(4 * y + 2 * x)
    return Mesh(vertices * bumps[:, None] * [1.0, 0.8, 0.6], faces)


def turned(points: Floats, degrees: float) -> Floats:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.asarray(points @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]))


def disguised(mesh: Mesh, seed: int = 0) -> Mesh:
    """Turned about the vertical axis, scaled, moved, in single precision, vertices and faces in another order."""
    rng = np.random.default_rng(seed)
    points = turned(mesh.vertices, float(rng.uniform(0, 360))) * 3.7 + [5, -2, 1]
    order = rng.permutation(len(points))
    moved = np.empty_like(points)
    moved[order] = points.astype(np.float32)
    return Mesh(moved, rng.permutation(order[mesh.faces]))


def test_invariants_see_through_a_disguise() -> None:
    assert invariants(disguised(lumpy())) == pytest.approx(invariants(lumpy()), abs=1e-4)


def test_invariants_do_not_depend_on_the_triangles_of_a_flat_side() -> None:
    vertices, faces = dirty.box(high=(1, 2, 0.5))
    other = faces.copy()
    a, b, c, d = faces[0, 0], faces[0, 1], faces[0, 2], faces[1, 2]
    other[0], other[1] = (a, b, d), (b, c, d)  # the other diagonal
    assert invariants(Mesh(vertices, other)) == pytest.approx(invariants(Mesh(vertices, faces)), abs=1e-9)


def test_the_distance_between_a_shape_and_itself_in_disguise_is_nearly_nothing() -> None:
    assert surface_distance(lumpy(), disguised(lumpy())) < TOLERANCE / 4


def test_a_coarser_mesh_of_the_same_shape_is_a_duplicate() -> None:
    assert surface_distance(lumpy(5), disguised(lumpy(4))) < TOLERANCE


def test_a_mirrored_shape_is_another_one() -> None:
    mesh = lumpy()
    mirrored = Mesh(mesh.vertices * [-1, 1, 1], mesh.faces[:, ::-1].copy())
    assert invariants(mirrored) == pytest.approx(invariants(mesh), abs=1e-6)
    assert surface_distance(mesh, mirrored) > 3 * TOLERANCE


@pytest.mark.parametrize("change", [[1, 1.1, 1], [1, 1, 1.15]])
def test_a_stretched_shape_is_another_one(change: list[float]) -> None:
    assert surface_distance(lumpy(), Mesh(lumpy().vertices * change, lumpy().faces)) > TOLERANCE


def test_pairs_are_those_with_near_invariants_in_the_order_of_names() -> None:
    moments = {"b": np.zeros(3), "a": np.full(3, 0.005), "c": np.array([0, 0, 0.02])}
    assert candidate_pairs(moments) == [("a", "b")]
    assert candidate_pairs({"a": np.zeros(3)}) == []


def test_the_first_name_is_kept_and_chains_do_not_spread() -> None:
    distances = {("a", "b"): 0.001, ("b", "c"): 0.001, ("a", "c"): 0.009, ("c", "d"): 0.002}
    found = {one.shape: one.of for one in decide(distances, TOLERANCE)}
    assert found == {"b": "a", "d": "c"}


def test_comparisons_read_back(tmp_path: Path) -> None:
    path, distances = tmp_path / "duplicates.json", {("a", "b"): 0.25, ("a", "c"): 0.001}
    meshes = {"a": "1", "b": "2", "c": "3"}
    assert compared_before(path, meshes) == {}
    path.write_text(to_json(distances, decide(distances, TOLERANCE), meshes))
    assert compared_before(path, meshes) == distances
    assert compared_before(path, {**meshes, "c": "4"}) == {("a", "b"): 0.25}, "another mesh under the name"
    path.write_text("{")
    assert compared_before(path, meshes) == {}


def test_a_build_leaves_duplicates_out_and_says_of_what(tmp_path: Path) -> None:
    folder = tmp_path / "meshes"
    folder.mkdir()
    for name, mesh in {"one": lumpy(3), "two": disguised(lumpy(3)), "other": Mesh(*dirty.sphere(fineness=3))}.items():
        (folder / f"{name}.ply").write_bytes(ply_bytes(mesh))
    config = BuildConfig(views=1, width=32, height=32, render_size=16, min_faces=100)
    summary = build_dataset(find_sources(folder), tmp_path / "data", config, HereRunner())
    assert {row.shape: (row.status, row.reason) for row in summary.rows} == {
        "one": ("done", ""),
        "other": ("done", ""),
        "two": ("skipped", "duplicate of one"),
    }


def decimated(mesh: Mesh, share: float) -> Mesh:
    """The same surface with this share of the faces."""
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(mesh.vertices, mesh.faces))
    meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=int(share * len(mesh.faces)), preservenormal=True)
    small = meshes.current_mesh()
    return Mesh(small.vertex_matrix(), small.face_matrix().astype(np.int64), mesh.name)


def stretched(mesh: Mesh, share: float) -> Mesh:
    """The shape, longer along x by a share."""
    return Mesh(mesh.vertices * [1.0 + share, 1.0, 1.0], mesh.faces)


CHANGES: dict[str, Callable[[Mesh], Mesh]] = {
    "turned, scaled, reordered": disguised,
    "1/2 of the faces": lambda mesh: disguised(decimated(mesh, 0.5)),
    "1/4 of the faces": lambda mesh: disguised(decimated(mesh, 0.25)),
    "1/10 of the faces": lambda mesh: disguised(decimated(mesh, 0.1)),
    "2 % longer": lambda mesh: disguised(stretched(mesh, 0.02)),
    "5 % longer": lambda mesh: disguised(stretched(mesh, 0.05)),
    "10 % longer": lambda mesh: disguised(stretched(mesh, 0.1)),
}


def found_alike(one: Mesh, other: Mesh) -> bool:
    """What a build decides: near invariants, then the distance between the surfaces."""
    near = np.abs(invariants(one) - invariants(other)).max() <= NEAR
    return bool(near) and surface_distance(one, other) <= TOLERANCE


@pytest.mark.slow
def test_what_is_taken_for_a_duplicate_among_real_shapes(shared: Path, capsys: pytest.CaptureFixture[str]) -> None:
    meshes = [clean_file(path)[0] for path in sorted((shared / "meshes" / "clean").iterdir())[::2]]
    shapes = [*meshes, *make_shapes(60)]
    taken = {name: sum(found_alike(mesh, change(mesh)) for mesh in meshes) for name, change in CHANGES.items()}
    by_name = {shape.name: shape for shape in shapes}
    near = candidate_pairs({name: invariants(shape) for name, shape in by_name.items()})
    wrong = [pair for pair in near if surface_distance(by_name[pair[0]], by_name[pair[1]]) <= TOLERANCE]
    with capsys.disabled():
        for name, count in taken.items():
            sys.stdout.write(f"\n{name}: taken for the same {count} of {len(meshes)}")
        pairs = len(shapes) * (len(shapes) - 1) // 2
        sys.stdout.write(
            f"\ndifferent shapes: {len(near)} of {pairs} pairs compared, {len(wrong)} taken for the same {wrong}\n"
        )
    assert taken["turned, scaled, reordered"] == taken["1/2 of the faces"] == len(meshes)
    assert wrong == []
    assert taken["10 % longer"] == 0
