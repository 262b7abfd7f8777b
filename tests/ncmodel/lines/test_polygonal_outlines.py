"""The outline of coarse shapes is complete and has no line beside it, and that of fine ones is left to contours."""

from collections.abc import Callable

import cv2
import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw
from ncmodel.drawing.drawing import Drawing
from ncmodel.lines.polygonal_outlines import Polygons, along, folds, missing_outlines
from ncmodel.mesh.load import make_mesh
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Floats, Ints, LineFamily, LineSet, Mesh
from tests.helpers import analytic
from tests.helpers.dirty import box, joined

LINES = ("contours", "boundaries", "creases")


def house() -> Mesh:
    """A long house whose ridge bends by 33 degrees: no crease, and from the side the whole outline on top."""
    gable = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.2], [0.0, 0.35], [-0.5, 0.2]])
    vertices = np.concatenate([np.column_stack([gable, np.full(5, z)]) for z in (-1.0, 1.0)])
    sides = [[[k, (k + 1) % 5, 5 + (k + 1) % 5], [k, 5 + (k + 1) % 5, 5 + k]] for k in range(5)]
    ends = [[[5, 5 + k, 6 + k], [0, k + 1, k]] for k in range(1, 4)]
    return make_mesh(vertices, np.array(sides + ends).reshape(-1, 3), "house")


def polygons(surface: Surface) -> Polygons:
    return Polygons(surface.mesh.vertices, surface.faces, surface.rings, surface.scene, surface.shells)


def missing(mesh: Mesh, camera: Camera, *drawn: LineFamily) -> LineSet:
    """The outlines that a mesh's visible lines of some families miss."""
    surface = Surface(mesh)
    view = View(surface, camera)
    lines = [view.unhidden(view.candidates(family)) for family in drawn]
    found = missing_outlines(folds(polygons(surface), camera), lines, polygons(surface), camera)
    return view.unhidden(found)


def completeness(mesh: Mesh, drawing: Drawing, camera: Camera) -> float:
    """The share of the shape's outline on the picture with ink within two pixels."""
    hit = Surface(mesh).scene.render(camera).hit.astype(np.uint8)
    outline = (hit - cv2.erode(hit, np.ones((3, 3), np.uint8))).astype(np.bool_)
    distance = cv2.distanceTransform((drawing.ink(1.5) <= 0.25).astype(np.uint8), cv2.DIST_L2, 5)
    return float((distance[outline] <= 2.0).mean())


@pytest.mark.parametrize(("azimuth", "elevation"), [(90, 5), (80, 12), (270, 0), (0, 0), (0, 90), (35, 25)])
def test_a_coarse_shape_has_its_whole_outline(azimuth: float, elevation: float) -> None:
    mesh = house()
    camera = Camera.orbit(mesh.vertices, azimuth, elevation, size=(400, 400))
    assert completeness(mesh, draw(mesh, camera, LINES), camera) > 0.99


def test_where_contours_miss_it_the_faces_edge_is_drawn() -> None:
    """The ridge from the side: one straight stroke over the length of the roof, and nothing else."""
    mesh = house()
    camera = Camera.orbit(mesh.vertices, 90.0, 5.0, size=(400, 400))
    segments = missing(mesh, camera, LineFamily.CREASES)
    assert segments.family is LineFamily.CONTOURS
    assert (segments.points[..., 1] == mesh.vertices[:, 1].max()).all()
    np.testing.assert_allclose(np.ptp(segments.points[..., 2]), 1.0, atol=0.05)


@pytest.mark.parametrize(
    "builder", [lambda: analytic.torus(128, 64), lambda: analytic.icosphere(4), lambda: analytic.cylinder(8, 64)]
)
def test_a_fine_shape_needs_none(builder: Callable[[], tuple[Floats, Ints]]) -> None:
    mesh = make_mesh(*builder())
    camera = Camera.orbit(mesh.vertices, 30.0, 25.0, size=(400, 400))
    view = View(Surface(mesh), camera)
    contours = view.unhidden(view.candidates(LineFamily.CONTOURS))
    ends, boundaries = folds(polygons(view.surface), camera), view.visible(LineFamily.BOUNDARIES)
    kept, doubtful = along(contours, ends, boundaries, view.surface.scene, camera)
    assert len(kept) == len(contours) > 20
    assert len(doubtful) == 0
    assert len(missing(mesh, camera, LineFamily.CONTOURS, LineFamily.BOUNDARIES)) == 0
    np.testing.assert_array_equal(view.visible(LineFamily.CONTOURS).points, contours.points)


def test_nothing_in_sight_has_no_outline() -> None:
    mesh = house()
    away = Camera((0.0, 0.0, 5.0), target=(0.0, 0.0, 9.0))
    inside = Camera((0.0, 0.0, 0.0), target=(0.0, 0.0, 1.0))
    for camera in (away, inside):
        assert len(missing(mesh, camera)) == 0
        assert len(View(Surface(mesh), camera).visible(LineFamily.CONTOURS)) == 0


@pytest.mark.parametrize("size", [(1, 1), (4000, 2)])
def test_tiny_pictures_are_not_cut_into_tinier_pieces(size: tuple[int, int]) -> None:
    mesh = house()
    square = Camera.orbit(mesh.vertices, 90.0, 5.0, size=(max(size), max(size)))
    camera = Camera(square.eye, width=size[0], height=size[1], focal_pixels=square.focal_pixels)
    assert len(missing(mesh, camera)) < 20 + 10 * max(size)


def test_it_costs_nothing_unless_contours_are_drawn() -> None:
    mesh = house()
    assert "polygonal_outlines" not in draw(mesh, lines=["creases", "suggestive"]).trace.seconds()
    assert "polygonal_outlines" in draw(mesh, lines=["contours"]).trace.seconds()


def test_a_limb_before_another_part_has_its_outline() -> None:
    """Two houses, one before the other: the front one's ridge, seen before the back one's roof."""
    front = house()
    vertices = np.concatenate([front.vertices, front.vertices + [-0.8, 0.15, 0.0]])
    both = Mesh(vertices, np.concatenate([front.faces, front.faces + len(front.vertices)]))
    camera = Camera.orbit(both.vertices, 90.0, 10.0, size=(400, 400))
    outlines = missing(both, camera, LineFamily.CREASES)
    ridge = np.isclose(outlines.points[..., 1], front.vertices[:, 1].max()).all(axis=1)
    np.testing.assert_allclose(np.ptp(outlines.points[ridge][..., 2]), 1.0, atol=0.05)


@pytest.mark.parametrize("turned", [slice(None), slice(None, None, 2)])
def test_outlines_do_not_depend_on_how_faces_are_wound(turned: slice) -> None:
    mesh = house()
    faces = mesh.faces.copy()
    faces[turned] = faces[turned, ::-1]
    camera = Camera.orbit(mesh.vertices, 90.0, 5.0, size=(400, 400))
    one, other = (missing(each, camera) for each in (mesh, Mesh(mesh.vertices, faces)))
    assert len(one) > 300
    np.testing.assert_allclose(np.sort(one.points.mean(axis=1), axis=0), np.sort(other.points.mean(axis=1), axis=0))


@pytest.mark.parametrize(("height", "bodies", "shown"), [(0.004, 1, 0.0), (0.04, 1, 0.4), (0.004, 2, 0.4)])
def test_a_step_too_low_to_matter_is_no_outline_but_of_another_body(height: float, bodies: int, shown: float) -> None:
    """A plate on a block: its far upper edge, behind which the block's top is seen."""
    vertices, faces = joined(box((-0.5, -0.2, -0.5), (0.5, 0.0, 0.5)), box((-0.2, 0.0, -0.2), (0.2, height, 0.2)))
    if bodies == 1:
        faces = np.concatenate([faces, [[0, 8, 8]]])  # without area, from one to the other
    camera = Camera.orbit(vertices, 0.0, 45.0, size=(400, 400))
    outlines = missing(Mesh(vertices, faces), camera)
    far = np.isclose(outlines.points[..., 1], height) & np.isclose(outlines.points[..., 2], -0.2)
    drawn = outlines.points[far.all(axis=1)]
    assert float(np.abs(drawn[:, 1] - drawn[:, 0]).sum()) == pytest.approx(shown, abs=0.01)


def test_contours_that_end_in_cusps_are_not_dashed_from_view_to_view() -> None:
    """From low on, a torus has its outline and a piece of its hole's; from higher up, the whole hole, in parts."""
    surface = Surface(make_mesh(*analytic.torus(64, 32)))
    vertices = surface.mesh.vertices
    cameras = [Camera.orbit(vertices, 30.0 + 0.5 * k, 8.0 + 0.5 * k) for k in range(60)]
    counts = [sum(s.family == "contours" for s in draw(surface, camera, LINES).strokes) for camera in cameras]
    assert set(counts[:30]) == {2}
    assert set(counts[35:]) <= {3, 4}
    assert np.abs(np.diff(counts)).max() <= 1


@pytest.mark.parametrize("azimuth", [90.0, 270.0])
def test_a_degenerate_face_does_not_interrupt_the_outline(azimuth: float) -> None:
    """The ridge, of which one side has a vertex in the middle; a face without area fills what is between."""
    mesh = house()
    front, back = (int(end) for end in np.flatnonzero(mesh.vertices[:, 1] == mesh.vertices[:, 1].max()))
    middle = len(mesh.vertices)
    vertices = np.concatenate([mesh.vertices, mesh.vertices[[front, back]].mean(axis=0, keepdims=True)])
    split = int(np.flatnonzero(np.isin(mesh.faces, [front, back]).sum(axis=1) == 2)[0])
    halves = [np.where(mesh.faces[split] == end, middle, mesh.faces[split]) for end in (front, back)]
    filler = [front, middle, back] if list(mesh.faces[split]).index(front) == 0 else [front, back, middle]
    whole = Mesh(vertices, np.concatenate([np.delete(mesh.faces, split, axis=0), halves, [filler]]))
    camera = Camera.orbit(vertices, azimuth, 5.0, size=(400, 400))
    assert completeness(whole, draw(Surface(whole), camera, ["contours"]), camera) > 0.99


def test_a_rail_on_a_wall_has_its_outline_however_near_the_wall_is() -> None:
    """The wall is farther than the rail's outline by less than `STEP`; it is another body."""
    radius, (rail, faces) = 0.01, analytic.cylinder(2, 24, 0.01, 0.9)
    rail = rail[:, [1, 0, 2]] * (1.0, -1.0, 1.0) + (0.0, 0.0, radius + 1e-4)
    wall = analytic.plane(8)
    mesh = Mesh(np.concatenate([wall[0], rail]), np.concatenate([wall[1], faces + len(wall[0])]))
    camera = Camera.orbit(mesh.vertices, 0.0, 30.0)
    axis = np.stack([np.linspace(-0.4, 0.4, 200), np.zeros(200), np.full(200, radius + 1e-4)], axis=1)
    up = np.cross(np.asarray(camera.eye) - axis, (1.0, 0.0, 0.0))
    up *= -np.sign(up[:, 1:2]) / np.linalg.norm(up, axis=1, keepdims=True)
    for side in (-radius, radius):
        outline = camera.project(axis + side * up)[:, :2]
        ink = draw(mesh, camera, "contours").ink()
        near = [ink[int(v) - 2 : int(v) + 3, int(u)].max() for u, v in outline]
        assert np.mean(np.array(near) > 0.5) > 0.95
