"""Hidden lines: scenes whose visible parts are known, and a brute-force check."""

import cv2
import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw
from ncmodel.drawing.strokes import strokes
from ncmodel.drawing.thresholding import fade
from ncmodel.lines.occlusion import HIDDEN, HIDDEN_NEARBY, SEEN
from ncmodel.lines.visibility import FRAME_MARGIN, _without_flicker
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Floats, Ints, LineFamily, LineSet, Mesh, Threshold
from tests.helpers import analytic
from tests.helpers.dirty import box, joined, moved
from tests.helpers.oracles import traced
from tests.helpers.segments import length

Geometry = tuple[Floats, Ints]


def view_of(geometry: Geometry, camera: Camera) -> View:
    return View(Surface(Mesh(*geometry)), camera)


def visible(geometry: Geometry, camera: Camera, family: LineFamily) -> LineSet:
    return view_of(geometry, camera).visible(family)


def edges_of(view: View) -> LineSet:
    """All edges of all faces, as creases."""
    sides = view.mesh.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    ends = np.unique(np.sort(sides, axis=1), axis=0)
    face = np.array([np.flatnonzero(np.isin(view.mesh.faces, pair).sum(axis=1) == 2)[0] for pair in ends])
    return LineSet(LineFamily.CREASES, view.mesh.vertices[ends], face, np.ones((len(ends), 2)), np.ones((len(ends), 2)))


@pytest.mark.parametrize("fineness", [3, 5])
def test_contour_of_a_sphere_is_its_circle(fineness: int) -> None:
    camera = Camera((1.2, 0.9, 2.6))
    lines = visible(analytic.icosphere(fineness, 0.5), camera, LineFamily.CONTOURS)
    distance = np.linalg.norm(camera.eye)
    radius = camera.focal_pixels * 0.5 / np.sqrt(distance**2 - 0.25)
    pixels = camera.project(lines.points)[..., :2]
    off = np.abs(np.linalg.norm(pixels - 384.0, axis=2) - radius)
    assert off.max() < (0.1 if fineness == 5 else 2.0)
    around = np.linalg.norm(pixels[:, 1] - pixels[:, 0], axis=1).sum()
    assert around == pytest.approx(2 * np.pi * radius, rel=0.005 if fineness == 5 else 0.02)


def test_sphere_behind_another_is_hidden_where_they_overlap() -> None:
    front, back = analytic.icosphere(4, 0.5), analytic.icosphere(4, 0.5)
    camera = Camera((0.0, 0.0, 30.0), width=1200, height=1200, focal_pixels=15000.0)
    lines = visible(joined(front, moved(back, (0.6, 0.0, -2.0))), camera, LineFamily.CONTOURS)
    pixels = camera.project(lines.points)[..., :2] - 600.0
    inner, outer = 15000 * 0.5 / np.sqrt(30**2 - 0.25), 15000 * 0.5 / np.sqrt(32**2 + 0.36 - 0.25)
    middle = np.array([15000 * 0.6 / 32, 0.0])
    of_front = np.abs(np.linalg.norm(pixels, axis=2) - inner).max(axis=1) < 1.0
    drawn = np.linalg.norm(pixels[:, 1] - pixels[:, 0], axis=1)
    assert drawn[of_front].sum() == pytest.approx(2 * np.pi * inner, rel=0.01)
    # Of the one behind, the arc outside the front one's disc.
    gap = np.linalg.norm(middle)
    half = np.arccos((gap**2 + outer**2 - inner**2) / (2 * gap * outer))
    assert drawn[~of_front].sum() == pytest.approx((2 * np.pi - 2 * half) * outer, rel=0.01)
    assert np.linalg.norm(pixels[~of_front], axis=2).min() > inner - 1.0


def test_cube_shows_nine_edges() -> None:
    camera = Camera((2.0, 1.5, 2.5))
    lines = visible(analytic.cube(), camera, LineFamily.CREASES)
    assert length(lines.points) == pytest.approx(9.0, abs=0.01)
    hidden_corner = np.array([-0.5, -0.5, -0.5])
    assert np.linalg.norm(lines.points - hidden_corner, axis=2).min() > 0.99


def test_touching_cubes_hide_each_other() -> None:
    stacked = joined(box((0, 0, 0), (1, 1, 1)), box((0.25, 1, 0.25), (0.75, 1.5, 0.75)))
    camera = Camera((3.0, 3.0, 4.0), (0.5, 0.5, 0.5))
    lines = visible(stacked, camera, LineFamily.CREASES)
    middle = lines.points.mean(axis=1)
    lower = middle[:, 1] < 1 - 1e-6
    assert length(lines.take(lower).points) == pytest.approx(5.0, abs=0.02)  # three upright, two below
    # The upper cube stands on the lower one's top: two of its bottom edges are seen, on the touching plane.
    bottom = np.isclose(middle[:, 1], 1.0) & (np.abs(middle[:, [0, 2]] - 0.5).max(axis=1) < 0.26)
    assert length(lines.take(bottom).points) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("ground", [0.0, 1.0, 1e4])
def test_a_thin_fin_close_before_a_wall(ground: float) -> None:
    """A plate of 0.001 floats 0.001 before a thin wall, alone or above a vast ground that reaches past the eye."""
    parts = [box((-0.5, -0.5, -0.1), (0.5, 0.5, 0)), box((-0.25, -0.25, 0.001), (0.25, 0.25, 0.002))]
    if ground:
        parts.append(box((-ground, -3.0, -ground), (ground, -2.0, 5.0)))
    lines = visible(joined(*parts), Camera((0.3, 0.2, 3.0)), LineFamily.CREASES)
    lines = lines.take(lines.points[..., 1].min(axis=1) > -1.0)
    of_fin = lines.points[..., 2].min(axis=1) > 0.0005
    # All front edges, and the short ones to the back that are seen.
    assert length(lines.take(of_fin).points) == pytest.approx(4.0, abs=0.02)
    assert length(lines.take(~of_fin).points) == pytest.approx(4.0, abs=0.1)


def test_shells_that_coincide_are_seen_as_one() -> None:
    torus = analytic.torus(48, 24)
    camera = Camera.orbit(torus[0], elevation=40.0)
    once, twice = (visible(g, camera, LineFamily.CONTOURS) for g in (torus, joined(torus, torus)))
    assert length(twice.points) == pytest.approx(2 * length(once.points), rel=0.01)
    crossed = joined(analytic.cube(), analytic.cube())
    seen = visible(crossed, Camera((2.0, 1.5, 2.5)), LineFamily.CREASES)
    assert length(seen.points) == pytest.approx(2 * 9.0, rel=0.01)


@pytest.mark.parametrize("azimuth", [0.0, 35.0, 70.0])
def test_faces_for_both_sides_are_seen_as_one(azimuth: float) -> None:
    """A torus that has every face twice, once for each side, on the same vertices."""
    vertices, faces = analytic.torus(48, 24)
    camera = Camera.orbit(vertices, azimuth, 25.0)
    both = np.concatenate([faces, faces[:, ::-1]])
    once, twice = (
        draw(Mesh(vertices, each), camera, ["contours", "boundaries", "creases"]).strokes for each in (faces, both)
    )
    assert len(twice) <= len(once) + 3
    lengths = [sum(np.linalg.norm(np.diff(s.points, axis=0), axis=1).sum() for s in each) for each in (once, twice)]
    assert lengths[1] == pytest.approx(lengths[0], rel=0.05)


def bowl() -> Geometry:
    """The lower half of a sphere of radius 0.5, open at y = 0."""
    vertices, faces = analytic.sphere(64, 96, 0.5)
    return vertices, faces[(vertices[faces][:, :, 1] < 1e-9).all(axis=1)]


def test_open_bowl_from_above_shows_all_of_its_rim() -> None:
    camera = Camera((0.0, 2.0, 2.5))
    assert length(visible(bowl(), camera, LineFamily.BOUNDARIES).points) == pytest.approx(np.pi, rel=0.01)


def test_open_bowl_from_below_hides_the_far_rim() -> None:
    camera = Camera((0.0, -1.5, 2.5))
    lines = visible(bowl(), camera, LineFamily.BOUNDARIES)
    # Seen where the sphere's outside faces the eye, p.eye > r^2, and on along the outline for a fraction of a pixel.
    assert (lines.points @ np.array(camera.eye) > 0.25 - 0.12).all()
    assert 1.0 < length(lines.points) / (2 * 0.5 * np.arccos(0.25 / (0.5 * 2.5))) < 1.08


def test_edges_just_inside_an_outline_belong_to_it() -> None:
    """A wedge whose lower edge lies half a pixel, or two, behind its upper one."""
    camera = Camera((0.0, 0.0, 3.0))
    pixel = 3.0 / camera.focal_pixels
    for behind, seen in ((0.5, 2.0), (2.0, 1.0)):
        low = -behind * pixel
        vertices = np.array(
            [[-0.5, 0, 0.1], [0.5, 0, 0.1], [0.5, low, 0], [-0.5, low, 0], [0.5, -1, 0.1], [-0.5, -1, 0.1]]
        )
        faces = np.array([[5, 4, 1], [5, 1, 0], [0, 1, 2], [0, 2, 3]])
        view = view_of((vertices, faces), camera)
        lines = edges_of(view)
        across = np.ptp(lines.points[..., 0], axis=1) > 0.99
        level = np.ptp(lines.points[..., 1], axis=1) < 1e-9
        upper = lines.take(across & level & (lines.points[:, 0, 1] > -0.5))
        assert length(view.unhidden(upper).points) == pytest.approx(seen, abs=0.02)


@pytest.mark.parametrize(("height", "shown"), [(2.0, True), (-2.0, False)])
def test_open_surfaces_occlude_from_both_sides(height: float, shown: bool) -> None:
    ball = moved(analytic.icosphere(3, 0.1), (0.0, -0.2, 0.0))
    lines = visible(joined(bowl(), ball), Camera((0.0, height, 0.3)), LineFamily.CONTOURS)
    of_ball = np.linalg.norm(lines.points.mean(axis=1) - [0.0, -0.2, 0.0], axis=1) < 0.15
    assert of_ball.any() == shown


def test_back_of_a_sheet_shows_its_creases() -> None:
    """A folded sheet without thickness, its normals turned away from the eye."""
    vertices = np.array([[-0.5, 0, 0], [0, 0, 0.4], [0.5, 0, 0], [-0.5, 1, 0], [0, 1, 0.4], [0.5, 1, 0]], dtype=float)
    faces = np.array([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])
    for turned in (faces, faces[:, ::-1].copy()):
        lines = visible((vertices, turned), Camera((0.3, 0.5, 4.0), (0, 0.5, 0)), LineFamily.CREASES)
        assert length(lines.points) == pytest.approx(1.0, abs=0.01)


def test_lines_of_boxes_agree_with_brute_force() -> None:
    rng = np.random.default_rng(3)
    corners = rng.uniform(-0.5, 0.3, (9, 3))
    geometry = joined(*[box(tuple(low), tuple(low + rng.uniform(0.1, 0.4, 3))) for low in corners])
    camera = Camera((1.7, 1.1, 2.1), focal_pixels=900.0)
    view, eye = view_of(geometry, camera), np.array(camera.eye)
    lines = edges_of(view)
    seen = view.unhidden(lines)
    at, wrong, checked = np.linspace(0.031, 0.967, 25), 0, 0
    for index in range(len(lines)):
        start, end = lines.points[index]
        way = end - start
        on_line = np.linalg.norm(np.cross(seen.points - start, way), axis=2).max(axis=1) < 1e-9
        pieces = np.sort(((seen.points[on_line] - start) @ way) / (way @ way), axis=1)
        for t in at:
            away = np.linalg.norm(start + t * way - eye)
            hit, _ = traced(*geometry, eye, (start + t * way - eye) / away)
            found = ((pieces[:, 0] <= t) & (t <= pieces[:, 1])).any()
            near = (np.abs(pieces - t) * np.linalg.norm(way) < 1.5e-3).any()  # half a pixel from a change
            checked += not near
            wrong += bool(found != (hit > away - 1e-6)) and not near
    assert checked > 2500
    assert wrong <= 0.002 * checked


@pytest.mark.parametrize("azimuth", range(0, 360, 60))
@pytest.mark.parametrize("elevation", [8.0, 17.0, 31.0])
def test_torus_contours_end_in_cusps_without_dashes(azimuth: float, elevation: float) -> None:
    """From low on, the inner contour ends in two cusps; whatever the tessellation, what is seen is a few long lines."""
    geometry = analytic.torus(60, 28, twist=28 / 60)
    camera = Camera.orbit(geometry[0], azimuth, elevation)
    lines = fade(visible(geometry, camera, LineFamily.CONTOURS), Threshold(0.0))
    drawn = [np.linalg.norm(np.diff(s.points, axis=0), axis=1).sum() for s in strokes(lines, camera)]
    long = [pixels for pixels in drawn if pixels > 5.0]
    assert len(long) == (2 if elevation < 24 else 3)
    assert min(long) > 200.0
    assert sum(drawn) - sum(long) < 10.0


@pytest.mark.parametrize("azimuth", [0.0, 30.0, 60.0, 90.0])
def test_contours_at_a_sharp_rim_are_not_hidden_by_the_faces_they_meet(azimuth: float) -> None:
    """A leaf of 24 folds, whose rim has faces turned to both sides."""
    angle = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    rim = np.stack([np.cos(angle), 0.15 * np.sin(2 * angle), 0.6 * np.sin(angle)], axis=1)
    vertices = np.concatenate([[[0.0, 0.15, 0.0], [0.0, -0.15, 0.0]], rim]) / 2
    here, there = 2 + np.arange(24), 2 + (np.arange(24) + 1) % 24
    zero = np.zeros_like(here)
    faces = np.concatenate([np.stack([zero, there, here], axis=1), np.stack([zero + 1, here, there], axis=1)])
    view = view_of((vertices, faces), Camera.orbit(vertices, azimuth, 30.0))
    points = view.camera.project(view.visible(LineFamily.CONTOURS).points)[..., :2]
    outline, _ = cv2.findContours(view.buffers.hit.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    drawn = float(np.linalg.norm(points[:, 1] - points[:, 0], axis=1).sum())
    assert drawn > 0.7 * cv2.arcLength(outline[0], True)


def test_what_is_behind_or_beside_the_camera_is_clipped() -> None:
    camera = Camera((0.1, 0.05, 0.2), (1.0, 0.3, -0.4), width=200, height=100, focal_pixels=90.0)
    lines = visible(analytic.cube(), camera, LineFamily.CREASES)
    assert len(lines)
    pixels = camera.project(lines.points)
    assert (pixels[..., 2] > 0).all()
    assert (np.abs(pixels[..., 0] - 100) <= 100 + FRAME_MARGIN + 1e-6).all()
    assert (np.abs(pixels[..., 1] - 50) <= 50 + FRAME_MARGIN + 1e-6).all()
    away = Camera((0.0, 0.0, 3.0), (0.0, 0.0, 6.0))
    assert len(visible(analytic.cube(), away, LineFamily.CREASES)) == 0


@pytest.mark.parametrize("eye", [(0.5, 0.5, 0.5), (0.5, 0.0, 0.0), (0.5, 0.2, 2.0), (0.0, 0.0, 0.0)])
@pytest.mark.parametrize("family", list(LineFamily))
def test_eye_on_a_corner_a_face_an_edge_plane_or_inside(eye: tuple[float, float, float], family: LineFamily) -> None:
    lines = visible(analytic.cube(), Camera(eye, (-0.3, -0.2, -0.1)), family)
    assert np.isfinite(lines.points).all()


@pytest.mark.parametrize("size", [(1, 1), (2000, 3)])
def test_extreme_pictures(size: tuple[int, int]) -> None:
    torus = analytic.torus(24, 12)
    lines = visible(torus, Camera.orbit(torus[0], size=size), LineFamily.CONTOURS)
    assert len(lines)
    assert np.isfinite(lines.points).all()


def test_pieces_keep_what_lines_carry() -> None:
    torus = analytic.torus(48, 24)
    view = view_of(torus, Camera.orbit(torus[0]))
    whole, seen = view.lines(LineFamily.APPARENT), view.visible(LineFamily.APPARENT)
    assert 0 < length(seen.points) < length(whole.points)
    assert seen.scale == whole.scale
    for piece in range(0, len(seen), 7):
        source = np.flatnonzero(whole.face == seen.face[piece])
        low, high = whole.feature[source].min(), whole.feature[source].max()
        assert (seen.feature[piece] >= low * (1 - 1e-9)).all()
        assert (seen.feature[piece] <= high * (1 + 1e-9)).all()


def flickered(states: list[int], pixels: float = 1.0) -> list[bool]:
    array = np.array(states, dtype=np.int8)
    seen: list[bool] = _without_flicker(array, np.full(len(states), pixels), np.array([0, len(states)])).tolist()
    return seen


def test_short_gaps_near_by_are_closed_and_specks_dropped() -> None:
    h, n, s = HIDDEN, HIDDEN_NEARBY, SEEN
    assert flickered([s, n, n, s, s]) == [True] * 5
    assert flickered([s, n, n, n, s]) == [True, False, False, False, True]  # three pixels are a gap
    assert flickered([s, h, s, s]) == [True, False, True, True]  # something far in front is no flicker
    assert flickered([s, n, h, s, s]) == [True, False, False, True, True]
    assert flickered([n, s, s]) == [False, True, True]  # an end is no gap
    assert flickered([h, s, h, h]) == [False] * 4
    assert flickered([h, s, s, h]) == [False, True, True, False]
    assert flickered([s, h, h]) == [True, False, False]
    assert flickered([h, s, n, s, h]) == [False, True, True, True, False]  # gaps first
    assert flickered([s, n, n, n, s], 0.5) == [True] * 5


def test_flicker_does_not_cross_chains() -> None:
    state = np.array([SEEN, HIDDEN_NEARBY, SEEN], dtype=np.int8)
    assert _without_flicker(state, np.ones(3), np.array([0, 2, 3])).tolist() == [True, False, True]
