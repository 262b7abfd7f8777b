"""What may be asked of a drawing, from Python: several forms for one thing, and one line for what makes no sense."""

import json
from typing import Any

import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.drawing.draw import draw
from ncmodel.drawing.plan import DEFAULT_FAMILIES
from ncmodel.errors import MeshError, NeuralContoursError, UsageError
from ncmodel.mesh.load import make_mesh
from ncmodel.types import LineFamily, Mesh, Thresholds
from tests.helpers import analytic

SMALL = 48


@pytest.fixture(scope="module")
def torus() -> Mesh:
    return make_mesh(*analytic.torus(24, 12), "torus")


@pytest.mark.parametrize(
    "lines",
    ["contours,suggestive", " contours, suggestive ", ["contours", "suggestive"], (LineFamily.CONTOURS, "suggestive")],
)
def test_families_in_any_form(lines: Any, torus: Mesh) -> None:
    assert draw(torus, lines=lines, size=SMALL).plan.families == (LineFamily.CONTOURS, LineFamily.SUGGESTIVE)


def test_thresholds_by_name(torus: Mesh) -> None:
    for values in ({"suggestive": 0.5, LineFamily.RIDGES: None}, "suggestive=0.5,ridges=off"):
        drawing = draw(torus, thresholds=values, size=SMALL)
        assert drawing.plan.thresholds == Thresholds(suggestive=0.5, ridges=None)


@pytest.mark.parametrize("thresholds", [{"ridges": 0.1}, "ridges=0.1"])
def test_a_family_that_is_given_a_threshold_is_drawn(thresholds: Any, torus: Mesh) -> None:
    assert draw(torus, thresholds=thresholds, size=SMALL).plan.drawn == (*DEFAULT_FAMILIES, LineFamily.RIDGES)
    assert draw(torus, lines="contours", thresholds=thresholds, size=SMALL).plan.drawn == (LineFamily.CONTOURS,)
    assert draw(torus, thresholds=Thresholds(), size=SMALL).plan.drawn == DEFAULT_FAMILIES


@pytest.mark.parametrize("size", [SMALL, (SMALL, SMALL), [48.0, 48], np.array([48, 48]), np.int64(48), "48", "48x48"])
def test_sizes(size: Any, torus: Mesh) -> None:
    drawing = draw(torus, lines="contours", size=size)
    assert (drawing.width, drawing.height) == (SMALL, SMALL)
    assert json.loads(drawing.camera.to_json())["width"] == SMALL


def test_a_mesh_of_any_size_is_drawn_alike(torus: Mesh) -> None:
    plain, large = (draw(Mesh(torus.vertices * scale, torus.faces), size=SMALL).ink() for scale in (1.0, 1e6))
    assert plain.sum() > 10
    np.testing.assert_allclose(plain, large, atol=1e-3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"shape": None}, "shape: found NoneType, expected a file's path, a Surface or a Mesh"),
        ({"shape": np.zeros((3, 3))}, r"shape: found ndarray, .* \(vertices, faces\), or a mesh of trimesh"),
        ({"lines": 3}, "lines: found 3, expected some of contours"),
        ({"lines": [None]}, "lines: found None, expected some of contours"),
        ({"thresholds": 0.1}, "thresholds: found float, expected Thresholds or a dictionary"),
        ({"thresholds": {"contours": 0.1}}, "thresholds: found 'contours', expected FAMILY=VALUE with suggestive"),
        ({"thresholds": {"ridges": "much"}}, "thresholds: found ridges='much', expected a number >= 0"),
        ({"camera": "camera.json"}, r"camera: found str, expected a Camera \(Camera.load reads a file\)"),
        ({"model": "model.safetensors"}, "model: found str, expected what load_model returns"),
        ({"size": "512 pixels"}, "size: found '512 pixels', expected pixels, N or WxH"),
        ({"size": (10.5, 10)}, "size: found"),
        ({"size": (1, 2, 3)}, "size: found"),
        ({"azimuth": "30"}, "azimuth: found '30', expected degrees"),
        ({"crease_angle": None}, "crease angle: found None, expected degrees"),
        ({"tolerance": "fine"}, "tolerance: found 'fine', expected pixels >= 0"),
    ],
)
def test_what_makes_no_sense_is_one_clear_line(options: dict[str, Any], message: str, torus: Mesh) -> None:
    with pytest.raises(UsageError, match=message):
        draw(**{"shape": torus, **options})


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"eye": (0, 0)}, "expected three numbers each"),
        ({"eye": (0, 0, "1")}, "all numbers must be finite"),
        ({"eye": (0, 0, 3), "width": 100.5}, "size 100.5 x 768, expected whole pixels"),
    ],
)
def test_cameras_that_make_no_sense(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        Camera(**arguments)


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        ("abc", [[0, 1, 2]], "no arrays of numbers"),
        (None, None, "no arrays of numbers"),
        ([[0, 0], [1, 0, 0]], [[0, 1, 2]], "no arrays of numbers"),
        (np.eye(3), [[0, 1, 1.5]], "faces with fractions; expected whole vertex indices"),
        (np.eye(3), [[0, 1, np.nan]], "faces with fractions"),
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value encountered in cast")
def test_arrays_that_are_no_mesh(vertices: Any, faces: Any, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        make_mesh(vertices, faces)


@pytest.mark.parametrize(
    "mesh", [Mesh(np.full((3, 3), np.nan), np.array([[0, 1, 2]])), Mesh(np.eye(3), np.zeros((0, 3), int))]
)
def test_meshes_that_cant_be_drawn(mesh: Mesh) -> None:
    with pytest.raises(NeuralContoursError, match=r"finite coordinates|no faces"):
        draw(mesh)


def test_a_drawing_says_what_it_is(torus: Mesh) -> None:
    drawing = draw(torus, lines="contours", size=SMALL)
    assert repr(drawing) == f"Drawing('torus', 48 x 48, strokes: {len(drawing.strokes)} contours)"
    assert drawing._repr_svg_().startswith("<?xml")
    assert 'fill="#ffffff"' in drawing._repr_svg_()
