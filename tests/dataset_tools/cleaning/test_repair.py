"""Repair of meshes, each with a fault made on purpose."""

from pathlib import Path

import numpy as np
import pytest

from dataset_tools.cleaning.repair import CleanReport, CleanSettings, clean, clean_file
from ncmodel.errors import MeshError
from ncmodel.types import Floats, Mesh
from tests.helpers import dirty


def cleaned(part: dirty.Geometry, settings: CleanSettings | None = None) -> tuple[Mesh, CleanReport]:
    mesh, report = clean(*part, "made", settings)
    assert dirty.is_surface(mesh.faces), "every repaired mesh is a surface"
    assert report.left.non_manifold_edges == report.left.non_manifold_vertices == report.left.inconsistent_edges == 0
    assert (report.left.vertices, report.left.faces) == (len(mesh.vertices), len(mesh.faces))
    return mesh, report


def steps(report: CleanReport) -> dict[str, int]:
    return {step.step: step.count for step in report.done}


def face_centres(mesh: Mesh) -> Floats:
    return np.asarray(mesh.vertices[mesh.faces].mean(axis=1))


def faces_out(mesh: Mesh, centre: tuple[float, float, float] = (0, 0, 0)) -> bool:
    normals = dirty.face_normals(mesh.vertices, mesh.faces)
    return bool((np.einsum("nd,nd->n", normals, face_centres(mesh) - np.asarray(centre)) > 0).all())


def test_a_sound_mesh_comes_back_as_it_was() -> None:
    vertices, faces = dirty.sphere(0.5)
    rng = np.random.default_rng(0)
    renumber = rng.permutation(len(vertices))
    shuffled = np.empty_like(vertices)
    shuffled[renumber] = vertices
    faces = rng.permutation(renumber[faces])
    extent = np.ptp(shuffled, axis=0).max()
    mesh, report = cleaned((shuffled / extent, faces))
    assert report.done == ()
    assert mesh.faces.tolist() == faces.tolist()
    assert mesh.vertices == pytest.approx(shuffled / extent, abs=1e-12)


def test_position_and_size_are_normalised_and_order_is_kept() -> None:
    vertices, faces = dirty.sphere()
    mesh, report = cleaned((vertices * 7 + [100, 20, -3], faces))
    assert report.done == ()
    assert mesh.faces.tolist() == faces.tolist()
    assert np.ptp(mesh.vertices, axis=0).max() == pytest.approx(1.0)
    assert mesh.vertices.max(axis=0) + mesh.vertices.min(axis=0) == pytest.approx(np.zeros(3), abs=1e-12)


@pytest.mark.parametrize(
    "part",
    [dirty.inside_out(dirty.sphere()), dirty.flipped_at_random(dirty.sphere()), dirty.inside_out(dirty.box())],
    ids=["inverted shell", "mixed winding", "inverted box"],
)
def test_closed_shells_face_outwards(part: dirty.Geometry) -> None:
    mesh, report = cleaned(part)
    assert dirty.is_closed(mesh.faces)
    assert faces_out(mesh)
    assert steps(report)["faces turned to face outwards"] > 0


def test_only_the_inside_out_part_is_turned() -> None:
    parts = [dirty.sphere(centre=(-1.5, 0, 0)), dirty.inside_out(dirty.sphere(centre=(1.5, 0, 0)))]
    mesh, report = cleaned(dirty.joined(*parts))
    assert steps(report) == {"faces turned to face outwards": len(parts[1][1])}
    for side in (-1, 1):
        part = Mesh(mesh.vertices, mesh.faces[np.sign(face_centres(mesh)[:, 0]) == side])
        assert dirty.signed_volume(part.vertices, part.faces) > 0


@pytest.mark.parametrize("break_it", [dirty.inside_out, dirty.flipped_at_random])
def test_an_open_bowl_faces_outwards(break_it: object) -> None:
    assert callable(break_it)
    mesh, report = cleaned(break_it(dirty.hemisphere()))
    # Normalised, the centre of the sphere lies at the middle of the open rim.
    assert faces_out(mesh, (0.0, float(mesh.vertices[:, 1].min()) - 0.01, 0.0))
    assert report.left.border_edges > 0


@pytest.mark.parametrize("noise", [0.0, 2e-6])
def test_loose_triangles_are_welded(noise: float) -> None:
    vertices, faces = dirty.sphere(0.5)
    mesh, report = cleaned(dirty.loose((vertices, faces), noise))
    assert dirty.is_closed(mesh.faces)
    assert len(mesh.vertices) == len(vertices)
    assert report.found.coincident_vertices == 3 * len(faces) - len(vertices)


def test_vertices_farther_apart_than_the_tolerance_stay_apart() -> None:
    gap = CleanSettings(weld=1e-5, snap=1e-5)
    parts = dirty.joined(dirty.strip(-1, 0, 4), dirty.strip(1e-4, 1, 4))
    assert len(cleaned(parts, gap)[0].vertices) == 20
    assert len(cleaned(parts, CleanSettings(weld=1e-5, snap=2e-4))[0].vertices) == 15


@pytest.mark.parametrize("gap", [0.0, 5e-5])
def test_t_junctions_are_connected(gap: float) -> None:
    mesh, report = cleaned(dirty.with_seam(gap=gap))
    assert report.found.touching_vertices == 11
    assert report.left.touching_vertices == 0
    assert report.left.components == 1
    # The rim of the square is all that is left of the borders: 2 x 2 sides, 8 and 5 cells high.
    assert report.left.border_edges == 8 + 5 + 4
    upright = dirty.face_normals(mesh.vertices, mesh.faces)[:, 2]
    assert (upright > 0).all() or (upright < 0).all()


def test_a_gap_wider_than_the_tolerance_stays_open() -> None:
    _, report = cleaned(dirty.with_seam(gap=1e-2))
    assert report.left.components == 2


@pytest.mark.parametrize("turned", [False, True])
def test_repeated_faces_are_dropped(turned: bool) -> None:
    vertices, faces = dirty.sphere()
    again = np.roll(faces[:, ::-1] if turned else faces, 1, axis=1)
    mesh, report = cleaned((vertices, np.concatenate([faces, again])))
    assert report.found.repeated_faces == steps(report)["repeated faces dropped"] == len(faces)
    assert dirty.is_closed(mesh.faces)
    assert faces_out(mesh)


def test_degenerate_faces_and_unused_vertices_go() -> None:
    vertices, faces = dirty.sphere()
    vertices = np.concatenate([vertices, [[0.3, 0.2, 0.1]]])
    mesh, report = cleaned((vertices, np.concatenate([faces, [[0, 1, 1], [5, 5, 5]]])))
    assert report.found.degenerate_faces == 2
    assert report.found.unused_vertices == 1
    assert len(mesh.vertices) == len(vertices) - 1
    assert mesh.faces.tolist() == faces.tolist()


def test_a_flat_face_between_two_others_leaves_no_crack() -> None:
    # A cap: its apex lies on its longest edge, so dropping it leaves a vertex on the neighbour's border.
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0.5, 0, 0], [0.5, 1, 0], [0.5, -1, 0.0]])
    faces = np.array([[0, 1, 3], [0, 2, 1], [0, 4, 2], [2, 4, 1]])
    _, report = cleaned((vertices, faces))
    assert report.found.degenerate_faces == 1
    assert report.left.border_edges == 4
    assert report.left.components == 1


def test_faces_without_coordinates_are_dropped() -> None:
    vertices, faces = dirty.sphere()
    vertices = vertices.copy()
    vertices[7] = np.nan
    mesh, report = cleaned((vertices, faces))
    gone = (faces == 7).any(axis=1).sum()
    assert report.found.unusable_vertices == 1
    assert len(mesh.faces) == len(faces) - gone
    assert np.isfinite(mesh.vertices).all()


@pytest.mark.parametrize("place", [1e30, -1e300])
def test_a_vertex_absurdly_far_away_takes_only_its_own_faces_along(place: float) -> None:
    vertices, faces = dirty.sphere()
    vertices = vertices.copy()
    vertices[7, 1] = place
    mesh, report = cleaned((vertices, faces))
    assert report.found.unusable_vertices == 1
    assert steps(report)["faces with unusable coordinates dropped"] == len(faces) - len(mesh.faces) == 5


def test_unused_vertices_at_one_point_do_not_make_the_others_far() -> None:
    vertices, faces = dirty.sphere()
    mesh, _ = cleaned((np.concatenate([vertices, np.zeros((5 * len(vertices), 3))]), faces))
    assert len(mesh.faces) == len(faces)


def test_a_hidden_shell_is_removed_unless_it_is_wanted() -> None:
    part = dirty.joined(dirty.sphere(), dirty.sphere(0.5))
    mesh, report = cleaned(part)
    assert steps(report)["faces hidden from outside removed"] == len(part[1]) // 2
    assert dirty.is_closed(mesh.faces)
    kept, _ = cleaned(part, CleanSettings(remove_hidden=False))
    assert len(kept.faces) == len(part[1])


def test_two_solids_that_touch_along_an_edge_become_surfaces() -> None:
    vertices, faces = dirty.joined(dirty.box((0, 0, 0), (1, 1, 1)), dirty.box((1, 1, 0), (2, 2, 1)))
    mesh, report = cleaned((vertices, faces))
    assert report.found.non_manifold_edges == 1
    assert dirty.is_closed(mesh.faces)
    assert dirty.signed_volume(mesh.vertices, mesh.faces) == pytest.approx(2 / 8)


def test_an_inner_wall_is_cut_off_and_removed() -> None:
    # Two boxes side by side share a wall that nobody sees.
    vertices, faces = dirty.joined(dirty.box((0, 0, 0), (1, 1, 1)), dirty.box((1, 0, 0), (2, 1, 1)))
    mesh, report = cleaned((vertices, faces))
    assert report.found.non_manifold_edges == 5  # the four sides of the wall and its diagonal
    assert dirty.is_closed(mesh.faces)
    assert faces_out(mesh)
    assert dirty.signed_volume(mesh.vertices, mesh.faces) == pytest.approx(2 / 8)


def test_a_vertex_shared_by_two_fans_is_split() -> None:
    vertices, faces = dirty.joined(dirty.box((0, 0, 0), (1, 1, 1)), dirty.box((1, 1, 1), (2, 2, 2)))
    mesh, report = cleaned((vertices, faces), CleanSettings(support=0))
    assert report.found.non_manifold_vertices == 1
    assert len(mesh.vertices) == 16
    assert dirty.is_closed(mesh.faces)


def test_flat_sides_get_support_and_the_resolution_is_that_of_before() -> None:
    mesh, report = cleaned(dirty.box())
    assert report.resolution == 12
    assert steps(report) == {"vertices put beside hard edges": len(mesh.vertices) - 8}
    assert dirty.is_closed(mesh.faces)
    assert cleaned(dirty.box(), CleanSettings(support=0))[1].done == ()


def test_a_one_sided_band_is_cut_open() -> None:
    mesh, report = cleaned(dirty.moebius())
    assert 4 <= steps(report)["edges cut to make a one-sided patch orientable"] < 20
    assert len(mesh.faces) == len(dirty.moebius()[1])


def test_a_stray_triangle_is_removed() -> None:
    stray = (np.array([[0, 2, 0], [0.1, 2, 0], [0, 2.1, 0.0]]), np.array([[0, 1, 2]]))
    mesh, report = cleaned(dirty.joined(dirty.sphere(), stray))
    assert steps(report)["stray triangles removed"] == 1
    assert dirty.is_closed(mesh.faces)


@pytest.mark.parametrize(
    ("part", "complaint"),
    [
        ((np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)), "no usable face"),
        ((np.full((3, 3), np.nan), np.array([[0, 1, 2]])), "no usable face"),
        ((np.ones((3, 3)), np.array([[0, 1, 2]])), "all faces lie at one point"),
        ((np.array([[0, 0, 0], [1, 1, 1], [2, 2, 2.0]]), np.array([[0, 1, 2]])), "degenerate"),
        ((np.random.default_rng(0).random((90, 3)), np.arange(90).reshape(-1, 3)), "loose triangles"),
    ],
    ids=["empty", "all NaN", "one point", "one line", "soup"],
)
def test_a_mesh_without_a_surface_is_refused_with_the_reason(part: dirty.Geometry, complaint: str) -> None:
    with pytest.raises(MeshError, match=complaint):
        clean(*part, "made", source="some.obj")


def test_files_are_turned_upright(tmp_path: Path) -> None:
    path = tmp_path / "tall.obj"
    vertices, faces = dirty.box((0, 0, 0), (1, 1, 4))
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
    path.write_text("\n".join(lines))
    assert np.ptp(clean_file(path, "z")[0].vertices, axis=0) == pytest.approx([0.25, 1.0, 0.25])
    assert np.ptp(clean_file(path, "y")[0].vertices, axis=0) == pytest.approx([0.25, 0.25, 1.0])


def test_settings_that_make_no_sense_are_refused() -> None:
    with pytest.raises(ValueError, match=r"weld is 0\.01 and snap is 0\.001"):
        CleanSettings(weld=0.01, snap=0.001)


@pytest.mark.slow
def test_every_real_mesh_becomes_a_surface_or_is_refused_with_a_reason(shared: Path) -> None:
    paths = sorted((shared / "meshes").glob("*/*"))
    assert len(paths) > 10
    for path in paths:
        if path.name == "soup.stl":
            with pytest.raises(MeshError, match="100 loose triangles"):
                clean_file(path)
            continue
        mesh, _ = clean_file(path)
        assert dirty.is_surface(mesh.faces), path
