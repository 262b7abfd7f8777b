"""The 264 candidates: their order, and that they are what they say."""

import json
from collections import Counter

import numpy as np
import pytest

from dataset_tools.candidates.candidates import (
    Candidates,
    CandidateThresholds,
    draw_candidates,
    draw_layers,
    layers_of,
    specs_of,
    thick,
)
from dataset_tools.candidates.viewpoints import camera_at
from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw_view
from ncmodel.drawing.plan import Plan
from ncmodel.drawing.settings import INK_LEVEL
from ncmodel.mesh.load import make_mesh
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import LineFamily
from tests.helpers import dirty

SIZE = 96


@pytest.fixture(scope="module")
def view() -> View:
    """A bumpy ball on an open tray: something of every family."""
    vertices, faces = dirty.sphere(0.5, (0, 0.5, 0), fineness=4)
    vertices = vertices * (1 + 0.12 * np.sin(9 * vertices[:, :1]) * np.cos(7 * vertices[:, 2:]))
    tray = dirty.strip(-0.8, 0.8, 3)
    tray = (tray[0][:, [0, 2, 1]] * [1, 1, 1.6] - [0, 0.2, 0.8], tray[1])
    mesh = make_mesh(*dirty.joined((vertices, faces), tray, dirty.box((0.4, -0.2, 0.2), (0.7, 0.3, 0.5))))
    return View(Surface(mesh), camera_at(mesh, 20.0, (SIZE, SIZE - 16)))


@pytest.fixture(scope="module")
def candidates(view: View) -> Candidates:
    return draw_candidates(view, CandidateThresholds())


def test_there_are_264_in_the_stated_order() -> None:
    specs = specs_of(CandidateThresholds())
    assert len(specs) == 264
    assert len({spec.layers for spec in specs}) == 264
    first, second, last_lines = specs[0], specs[1], specs[255]
    assert first.settings == {
        "kind": "lines",
        "suggestive": 0.001,
        "apparent": 0.01,
        "ridges_valleys": 0.03,
        "creases": False,
        "borders": False,
    }
    assert second.settings == {**first.settings, "borders": True}
    assert last_lines.layers == ("contours", "creases", "boundaries")
    assert specs[252].layers == ("contours",)
    assert [spec.settings["smoothed"] for spec in specs[256:]] == [False] * 4 + [True] * 4
    assert all("contours" in spec.layers for spec in specs[:256])


def test_every_choice_occurs_equally_often() -> None:
    lines = [spec.settings for spec in specs_of(CandidateThresholds()) if spec.settings["kind"] == "lines"]
    for name, times in (
        ("suggestive", 64),
        ("apparent", 64),
        ("ridges_valleys", 64),
        ("creases", 128),
        ("borders", 128),
    ):
        assert set(Counter(settings[name] for settings in lines).values()) == {times}


def test_twelve_layers_of_lines_and_eight_of_edges_are_enough() -> None:
    layers = layers_of(CandidateThresholds())
    assert len(layers) == 20
    assert len({layer.name for layer in layers}) == 20
    used = {name for spec in specs_of(CandidateThresholds()) for name in spec.layers}
    assert used == {layer.name for layer in layers}


def test_specs_are_json() -> None:
    record = specs_of(CandidateThresholds())[7].to_record(7)
    assert json.loads(json.dumps(record)) == record
    assert record["index"] == 7


def test_a_drawing_is_what_drawing_its_lines_at_once_gives(view: View, candidates: Candidates) -> None:
    index = next(
        i
        for i, spec in enumerate(candidates.specs)
        if spec.layers == ("contours", "suggestive@0.01", "apparent@0.1", "ridges_valleys@0.1", "creases", "boundaries")
    )
    at_once = draw_view(view, Plan(tuple(LineFamily))).ink()
    drawing = candidates.drawing(index)
    # Visibility is decided at other points of a line where weak parts of it are left out first.
    assert np.abs(drawing - at_once).sum() < 0.005 * at_once.sum()
    assert (np.abs(drawing - at_once) > 0.25).sum() < 0.001 * (at_once > 0.25).sum() + 2


def test_every_family_contributes(candidates: Candidates) -> None:
    inked = {
        layer.name for layer, mask in zip(layers_of(CandidateThresholds()), candidates.masks, strict=True) if mask.any()
    }
    lowest = {"suggestive@0.001", "apparent@0.01", "ridges_valleys@0.03", "canny@40", "smoothed_canny@40"}
    assert {"contours", "creases", "boundaries"} | lowest <= inked


def test_packed_bits_are_the_inked_pixels_of_the_drawings(candidates: Candidates) -> None:
    packed = candidates.packed()
    height, width = candidates.ink.shape[1:]
    assert packed.shape == (264, height, -(-width // 8))
    bits = np.unpackbits(packed, axis=-1, count=width).astype(bool)
    for index in (0, 100, 252, 255, 256, 263):
        assert np.array_equal(bits[index], candidates.drawing(index) > INK_LEVEL)


def test_higher_thresholds_leave_less_ink(candidates: Candidates) -> None:
    ink = {
        layer.name: float(image.sum())
        for layer, image in zip(layers_of(CandidateThresholds()), list(candidates.ink), strict=True)
    }
    for name, levels in (
        ("suggestive", (0.001, 0.01, 0.1)),
        ("apparent", (0.01, 0.1, 1)),
        ("canny", (40, 80, 160, 320)),
    ):
        amounts = [ink[f"{name}@{level:g}"] for level in levels]
        assert amounts == sorted(amounts, reverse=True)


def test_thick_lines_have_their_width_and_soft_edges() -> None:
    pixels = np.zeros((21, 30), dtype=bool)
    pixels[10] = True
    profile = thick(pixels, 2.5)[:, 15]
    assert profile.sum() == pytest.approx(2.5)
    assert profile[8:13].tolist() == [0.0, 0.75, 1.0, 0.75, 0.0]
    assert not thick(np.zeros((4, 4), dtype=bool), 3.0).any()


def test_a_view_of_nothing_but_background_gives_empty_layers(view: View) -> None:
    levels, past = CandidateThresholds(), Camera((0.0, 0.0, 50.0), (0.0, 50.0, 50.0), (0.0, 0.0, 1.0), 32, 32, 30.0)
    assert not draw_layers(View(view.surface, past), layers_of(levels), levels).any()
