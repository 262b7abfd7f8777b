"""Cameras of drawings whose camera is known, found again by their outlines."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from dataset_tools.simulation.shapes import make_shape
from eval.people.camera_fit import NoPoseError, fit_camera
from eval.people.camera_study import unsteady
from eval.people.outline import DrawnOutline, OpenOutlineError, drawn_outline, filled, seen_outline
from eval.people.poses import Pose
from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw
from ncmodel.geometry.raycast import RayScene
from ncmodel.images import from_ink, write_png
from ncmodel.mesh.load import load_mesh
from ncmodel.readers.ply import ply_bytes
from ncmodel.types import Floats, Image
from tests.helpers.commands import complaint, printed

MOST_DEGREES, MOST_SIZE = 2.0, 0.02


def errors(hidden: Camera, found: Camera) -> tuple[float, float]:
    """Degrees between the rotations, and the relative error of the size that the shape is seen in."""
    true, other = Pose.of(hidden), Pose.of(found)
    return math.degrees(true.angle_to(other)), abs(other.size / true.size - 1)


@pytest.mark.parametrize(
    ("kind", "azimuth", "elevation", "size", "wobble"),
    [("creature", 50.0, 20.0, (320, 320), 0.0), ("figure", 110.0, 10.0, (400, 300), 0.7)],
)
def test_a_hidden_camera_is_found(
    kind: str, azimuth: float, elevation: float, size: tuple[int, int], wobble: float
) -> None:
    mesh = make_shape(kind, 3)
    hidden = Camera.orbit(mesh.used_vertices, azimuth, elevation, size=size, target=(0.03, 0.02, 0.0))
    ink = unsteady(draw(mesh, camera=hidden).ink(), wobble, np.random.default_rng(0))
    found = fit_camera(mesh, ink, drawn_outline(ink), starts=10)
    degrees, share = errors(hidden, found.camera)
    assert degrees < MOST_DEGREES
    assert share < MOST_SIZE
    assert found.outline_distance < 1.0
    assert found.overlap > 0.92  # figures are thin
    assert (found.camera.width, found.camera.height) == size


def test_a_known_focal_length_is_kept() -> None:
    mesh = make_shape("creature", 3)
    hidden = Camera.orbit(mesh.used_vertices, -40.0, 25.0, distance=2.0, size=(240, 240))
    ink = draw(mesh, camera=hidden).ink()
    found = fit_camera(mesh, ink, drawn_outline(ink), hidden.focal_pixels, starts=8)
    assert found.camera.focal_pixels == pytest.approx(hidden.focal_pixels, rel=1e-6)
    assert errors(hidden, found.camera)[0] < MOST_DEGREES


def test_slopes_of_a_pose_are_those_of_differences() -> None:
    points = np.random.default_rng(0).uniform(-0.5, 0.5, (7, 3))
    camera = Camera((1.0, 1.2, 2.0), (0.1, 0.05, 0.0), (0.1, 1.0, 0.0))
    pose = Pose.of(camera)
    middle = np.array([camera.width, camera.height]) / 2
    np.testing.assert_allclose(pose.project(points) + middle, camera.project(points)[:, :2], atol=1e-9)
    again = pose.camera(camera.width, camera.height)
    np.testing.assert_allclose(again.project(points), camera.project(points), atol=1e-9)
    slopes = pose.slopes(points)
    for number, by in enumerate(1e-6 * np.eye(7)):
        difference = (pose.moved(by).project(points) - pose.moved(-by).project(points)) / 2e-6
        np.testing.assert_allclose(slopes[:, :, number], difference, rtol=1e-6, atol=1e-5)


def test_the_seen_outline_lies_where_rays_stop_to_meet_the_mesh() -> None:
    mesh = make_shape("creature", 3)
    camera = Camera.orbit(mesh.used_vertices, 20.0, 10.0, size=(200, 160))
    scene = RayScene(mesh)
    seen = seen_outline(scene, camera)
    np.testing.assert_array_equal(seen.region, filled(scene.render(camera).hit))
    assert seen.whole
    pixels = camera.project(seen.points)[:, :2]
    distance = DrawnOutline.of(seen.region).distance
    rows, columns = np.clip(pixels.astype(int).T[::-1], 0, np.array([[159], [199]]))
    # Half a pixel outside the centres of the outermost pixels, on the average.
    assert 0.0 < distance[rows, columns].mean() < 1.0
    assert np.abs(distance[rows, columns]).max() <= 1.5


def ring(gap: float = 0.0) -> Image:
    """A drawn circle with a gap of so many radians, a line sticking out and one inside."""
    ink = np.zeros((200, 240))
    turn: Floats = np.linspace(gap / 2, 2 * np.pi - gap / 2, 4000)
    for radius in (69.0, 70.0, 71.0):
        ink[np.rint(100 + radius * np.sin(turn)).astype(int), np.rint(120 + radius * np.cos(turn)).astype(int)] = 1.0
    ink[100, 150:230] = 1.0
    return ink.astype(np.float32)


def test_an_outline_is_what_encloses_without_what_sticks_out() -> None:
    outline = drawn_outline(ring())
    assert outline.region.sum() == pytest.approx(math.pi * 70**2, rel=0.02)
    radius = np.linalg.norm(outline.points - [120.5, 100.5], axis=1)
    assert np.abs(radius - 70.0).max() < 2.5
    assert radius.mean() == pytest.approx(70.0, abs=0.3)
    outwards = (outline.points - [120.5, 100.5]) / radius[:, None]
    assert np.median(np.sum(outwards * outline.normals, axis=1)) > 0.99
    assert outline.closed == 0.0


def test_small_gaps_are_closed_and_wide_ones_refused() -> None:
    closed = drawn_outline(ring(gap=0.06))
    assert closed.closed > 2.0
    assert closed.region.sum() == pytest.approx(math.pi * 70**2, rel=0.03)
    with pytest.raises(OpenOutlineError, match="isn't closed"):
        drawn_outline(ring(gap=1.0))
    with pytest.raises(OpenOutlineError, match="nothing"):
        drawn_outline(np.zeros((50, 60), dtype=np.float32))


def test_another_shapes_outline_fits_no_pose() -> None:
    ink = np.zeros((120, 120), dtype=np.float32)
    for row in (20, 100):
        ink[row, 20:101] = 1.0
    for column in (20, 100):
        ink[20:101, column] = 1.0
    with pytest.raises(NoPoseError, match="no pose"):
        fit_camera(make_shape("creature", 3), ink, drawn_outline(ink), starts=3)


def test_an_unsteady_hand_wanders_by_what_was_asked() -> None:
    ink = ring()
    np.testing.assert_array_equal(unsteady(ink, 0.0, np.random.default_rng(0)), ink)
    wandering = unsteady(ink, 2.0, np.random.default_rng(0))
    rows, columns = np.nonzero(wandering > 0.5)
    off = np.abs(np.hypot(columns - 120.0, rows - 100.0) - 70.0)[np.abs(rows - 100) > 3]
    assert 0.5 < off.mean() < 3.0


def test_the_command_writes_a_camera_a_picture_and_what_it_found(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "creature.ply").write_bytes(ply_bytes(make_shape("creature", 3)))
    mesh = load_mesh(tmp_path / "creature.ply")
    hidden = Camera.orbit(mesh.used_vertices, 60.0, 15.0, size=(256, 256))
    draw(mesh, camera=hidden).save(tmp_path / "drawing.png")
    out = tmp_path / "camera.json"
    record = printed(capsys, "fit-camera", tmp_path / "creature.ply", tmp_path / "drawing.png", "-o", out)
    found = Camera.load(out)
    degrees, share = errors(hidden, found)
    assert (degrees < MOST_DEGREES, share < MOST_SIZE) == (True, True)
    assert record["camera"] == json.loads(out.read_text())
    assert record["outline_distance"] < 1.0
    assert record["overlap"] > 0.95
    assert (tmp_path / "camera.png").read_bytes().startswith(b"\x89PNG")
    write_png(tmp_path / "blank.png", from_ink(np.zeros((64, 64))))
    left = {path.name for path in tmp_path.iterdir()}
    said = complaint(capsys, "fit-camera", tmp_path / "creature.ply", tmp_path / "blank.png", "-o", tmp_path / "c.json")
    assert "blank.png: nothing is drawn in it; expected lines with a closed outline" in said
    assert {path.name for path in tmp_path.iterdir()} == left
