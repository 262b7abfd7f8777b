"""3MF, COLLADA, STEP: parts in their places, with units and the upward axis that the file tells."""

import sys
from pathlib import Path

import numpy as np
import pytest

from ncmodel.errors import MeshError
from ncmodel.mesh.load import load_mesh, read_geometry
from ncmodel.types import Floats, Ints
from tests.helpers.scene_files import QUADS, as_3mf, as_collada, as_step, box_object

ITEM = '<item objectid="1"/>'
BOX_NODE = '<instance_geometry url="#box"/>'


def read(path: Path, content: bytes) -> tuple[Floats, Ints]:
    path.write_bytes(content)
    return read_geometry(path)


def volume(vertices: Floats, faces: Ints) -> float:
    """Negative where faces look inwards."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.einsum("fi,fi->", a, np.cross(b, c)) / 6)


def test_3mf_is_upright_and_in_millimetres(tmp_path: Path) -> None:
    for unit, scale in {"millimeter": 1.0, "inch": 25.4, "micron": 1e-3}.items():
        vertices, faces = read(tmp_path / "box.3mf", as_3mf(box_object(1), ITEM, unit))
        np.testing.assert_allclose(np.ptp(vertices, axis=0), np.array([4, 1, 2]) * scale)
        assert len(faces) == 12
        assert volume(vertices, faces) == pytest.approx(8 * scale**3)


def test_3mf_components_are_in_their_places_and_mirrored_ones_outside_out(tmp_path: Path) -> None:
    assembly = (
        '<object id="2"><components><component objectid="1" transform="1 0 0 0 1 0 0 0 1 10 0 0"/>'
        '<component objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/></components></object>'
    )
    vertices, faces = read(
        tmp_path / "two.3mf",
        as_3mf(box_object(1) + assembly, '<item objectid="2" transform="0 1 0 -1 0 0 0 0 1 0 0 0"/>'),
    )
    # Along x from -4 to 14, then turned about z, then z up.
    np.testing.assert_allclose(np.ptp(vertices, axis=0), [2, 1, 18])
    assert volume(vertices, faces) == pytest.approx(16)


def test_3mf_models_in_other_parts_have_ids_of_their_own(tmp_path: Path) -> None:
    far = '<object id="7"><components><component p:path="/3D/b.model" objectid="1"/></components></object>'
    other = box_object(1) + box_object(2)
    packed = as_3mf(box_object(1, "other") + far, '<item objectid="7"/>', others={"3D/b.model": other})
    assert len(read(tmp_path / "parts.3mf", packed)[1]) == 12


def test_3mf_supports_are_passed_over(tmp_path: Path) -> None:
    (tmp_path / "a.3mf").write_bytes(as_3mf(box_object(1) + box_object(2, "support"), ITEM + '<item objectid="2"/>'))
    mesh = load_mesh(tmp_path / "a.3mf")
    assert (len(mesh.faces), mesh.notes) == (12, ("1 supports and modifiers are passed over",))


@pytest.mark.parametrize(
    ("axis", "extent"), [("", (4, 2, 1)), ("Y_UP", (4, 2, 1)), ("Z_UP", (4, 1, 2)), ("X_UP", (2, 4, 1))]
)
def test_collada_says_which_axis_is_up(axis: str, extent: tuple[int, int, int], tmp_path: Path) -> None:
    asset = f'<unit meter="0.01"/>{f"<up_axis>{axis}</up_axis>" if axis else ""}'
    vertices, faces = read(tmp_path / "box.dae", as_collada(f"<node>{BOX_NODE}</node>", asset))
    np.testing.assert_allclose(np.ptp(vertices, axis=0), np.array(extent) / 100)
    assert volume(vertices, faces) == pytest.approx(8e-6)


def test_collada_nodes_move_what_is_below_them_in_order(tmp_path: Path) -> None:
    nodes = (
        f'<node id="n"><translate>10 0 0</translate><rotate>0 0 2 90</rotate><node><scale>-1 1 1</scale>{BOX_NODE}'
        '</node></node><node><matrix>1 0 0 0  0 1 0 0  0 0 1 5  0 0 0 1</matrix><instance_node url="#n"/></node>'
    )
    vertices, faces = read(tmp_path / "box.dae", as_collada(nodes))
    np.testing.assert_allclose(vertices.min(axis=0), [8, -4, 0], atol=1e-12)
    np.testing.assert_allclose(vertices.max(axis=0), [10, 0, 6], atol=1e-12)
    assert volume(vertices, faces) == pytest.approx(16)


INPUT = '<input semantic="VERTEX" source="#v" offset="0"/>'
RINGS = "".join(f"<p>{a} {b} {c} {d}</p>" for a, b, c, d in QUADS)
TRIANGLES = " ".join(f"{a} {b} {c} {a} {c} {d}" for a, b, c, d in QUADS)


@pytest.mark.parametrize(
    "primitives",
    [
        f"<triangles count='12'>{INPUT}<p>{TRIANGLES}</p></triangles>",
        f"<polygons>{INPUT}{RINGS}</polygons>",
        f"<trifans>{INPUT}{RINGS}</trifans>",
        f"<tristrips>{INPUT}{''.join(f'<p>{a} {b} {d} {c}</p>' for a, b, c, d in QUADS)}</tristrips>"
        f"<lines>{INPUT}<p>0 1</p></lines>",
    ],
)
def test_collada_primitives(primitives: str, tmp_path: Path) -> None:
    vertices, faces = read(tmp_path / "box.dae", as_collada(f"<node>{BOX_NODE}</node>", "", primitives))
    assert len(faces) == 12
    assert volume(vertices, faces) == pytest.approx(8)


def test_collada_skins_are_as_they_were_bound(tmp_path: Path) -> None:
    skin = (
        '<library_controllers><controller id="c"><skin source="#box"><bind_shape_matrix>1 0 0 9 0 1 0 0 0 0 1 0 0 0 0 1'
        "</bind_shape_matrix></skin></controller></library_controllers>"
    )
    text = as_collada('<node><instance_controller url="#c"/></node>').replace(b"<scene>", skin.encode() + b"<scene>")
    vertices, _ = read(tmp_path / "skin.dae", text)
    np.testing.assert_array_equal(vertices.max(axis=0), [13, 2, 1])
    assert load_mesh(tmp_path / "skin.dae").notes == ("1 skins or morphs are in the pose in which they are bound",)


def test_step_is_tessellated_and_nothing_else_is_printed(tmp_path: Path) -> None:
    pytest.importorskip("cascadio")
    vertices, faces = read(tmp_path / "box.step", as_step())
    np.testing.assert_allclose(np.ptp(vertices, axis=0), [4e-3, 2e-3, 1e-3], rtol=1e-6)
    assert volume(vertices, faces) == pytest.approx(8e-9, rel=1e-5)
    assert len(load_mesh(tmp_path / "box.step").vertices) == 8, "faces share their corners"


def test_damaged_step_and_iges(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("cascadio")
    for name, content in {"a.stp": as_step()[:900], "b.igs": b"hello", "c.step": as_step([])}.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(MeshError, match=rf"{name}: not readable as .*; expected a mesh|{name}: no surfaces"):
            load_mesh(tmp_path / name)
    assert capfd.readouterr() == ("", "")


def test_a_missing_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cascadio", None)
    (tmp_path / "box.step").write_bytes(as_step())
    with pytest.raises(MeshError, match=r"box.step: .*cascadio is missing, pip install 'neural-contours\[cad\]'"):
        load_mesh(tmp_path / "box.step")


ENDLESS = '<object id="1"><components><component objectid="1"/></components></object>'
WRONG: dict[str, tuple[bytes, str]] = {
    "cut.3mf": (as_3mf(box_object(1), ITEM)[:200], "damaged .BadZipFile"),
    "page.3mf": (b"<!DOCTYPE html><html></html>", "a web page"),
    "text.3mf": (b"hello", "damaged .BadZipFile"),
    "gone.3mf": (as_3mf(box_object(1), '<item objectid="9"/>'), "damaged .KeyError: '9'"),
    "endless.3mf": (as_3mf(ENDLESS, ITEM), "damaged .RecursionError"),
    "empty.3mf": (as_3mf(box_object(1), ""), "nothing with faces is built in it; expected a mesh with faces"),
    "index.3mf": (
        as_3mf(box_object(1).replace('v1="0"', 'v1="8"'), ITEM),
        "faces use vertices 1..8",
    ),
    "cut.dae": (as_collada(f"<node>{BOX_NODE}</node>")[:-30], "XML that breaks off or is damaged"),
    "page.dae": (b"<?xml version='1.0'?><html></html>", "a web page"),
    "other.dae": (b"<?xml version='1.0'?><svg/>", "an XML document of another kind .svg."),
    "empty.dae": (as_collada("<node/>"), "no faces in its scene"),
    "gone.dae": (as_collada('<node><instance_geometry url="#ball"/></node>'), "damaged .KeyError: 'ball'"),
    "outside.dae": (as_collada('<node><instance_geometry url="b.dae#b"/></node>'), "it refers to 'b.dae#b', outside"),
    "few.dae": (
        as_collada(f"<node>{BOX_NODE}</node>", "", f"<polylist>{INPUT}<vcount>4</vcount><p>0 1 2</p></polylist>"),
        "3 corners for polygons of 4",
    ),
    "bare.dae": (
        as_collada(f"<node>{BOX_NODE}</node>", "", "<triangles><p>0 1 2</p></triangles>"),
        "triangles without the input",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_and_damaged_files_are_one_line(name: str, tmp_path: Path) -> None:
    content, message = WRONG[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(MeshError, match=rf"{name}: .*{message}") as caught:
        load_mesh(tmp_path / name)
    assert "\n" not in str(caught.value)
