"""Drawings are those that are stored, and what compares them sees every kind of change."""

import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

import pytest

from ncmodel.cli.main import main
from ncmodel.types import LineFamily
from tests.helpers.golden_drawings import DRAWINGS, FOLDER, differences
from tests.helpers.mesh_files import write_obj
from tests.helpers.pictures import SVG


@pytest.mark.parametrize("name", DRAWINGS)
def test_drawings_are_those_that_are_stored(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, pytestconfig: pytest.Config
) -> None:
    make, command = DRAWINGS[name]
    monkeypatch.chdir(tmp_path)
    write_obj(tmp_path / f"{name}.obj", make())
    assert main(command.split()) == 0
    drawn, stored = tmp_path / f"{name}.svg", FOLDER / f"{name}.svg"
    if pytestconfig.getoption("--update-golden"):
        stored.write_bytes(drawn.read_bytes())
    told = differences(drawn.read_text(encoding="utf-8"), stored.read_text(encoding="utf-8"))
    assert not told, "\n".join([f"{drawn} isn't {stored}:", *told])


def test_the_stored_drawings_show_all_families() -> None:
    document = ET.parse(FOLDER / "window.svg")
    assert {group.get("id") for group in document.iter(f"{SVG}g")} == {family.value for family in LineFamily}


def longest(root: ET.Element) -> ET.Element:
    return max(root.iter(f"{SVG}path"), key=lambda path: len(path.attrib["d"]))


def move(root: ET.Element) -> None:
    path = longest(root)
    numbers = [float(word) for word in path.attrib["d"].lstrip("M").split()]
    path.set("d", "M" + " ".join(str(x + 0.707) for x in numbers))  # a pixel, right and down


def remove(root: ET.Element) -> None:
    path = longest(root)
    next(group for group in root.iter(f"{SVG}g") if path in list(group)).remove(path)


def add(root: ET.Element) -> None:
    ET.SubElement(next(root.iter(f"{SVG}g")), f"{SVG}path", {"d": "M1 1 9 3"})


def fade(root: ET.Element) -> None:
    path = longest(root)
    grey = int(path.get("stroke", "#000000")[1:3], 16)
    path.set("stroke", f"#{grey + 26 if grey < 128 else grey - 26:02x}0000")  # a tenth of black


def rename(root: ET.Element) -> None:
    next(root.iter(f"{SVG}g")).set("id", "hatching")


def widen(root: ET.Element) -> None:
    next(root.iter(f"{SVG}g")).set("stroke-width", "9")


def resize(root: ET.Element) -> None:
    root.set("width", "97")


@pytest.mark.parametrize("name", DRAWINGS)
@pytest.mark.parametrize(
    ("change", "message"),
    [
        (move, "missing, the first at"),
        (remove, "missing"),
        (add, "not expected, the first at"),
        (fade, "of opacity"),
        (rename, "families are hatching"),
        (widen, "lines are 9 wide, expected"),
        (resize, "width is 97, expected"),
    ],
)
def test_every_change_is_told(name: str, change: Callable[[ET.Element], None], message: str) -> None:
    stored = (FOLDER / f"{name}.svg").read_text(encoding="utf-8")
    root = ET.fromstring(stored.encode())
    change(root)
    assert message in "\n".join(differences(ET.tostring(root, encoding="unicode"), stored))


@pytest.mark.parametrize("name", DRAWINGS)
def test_last_digits_and_the_order_of_lines_make_no_difference(name: str) -> None:
    stored = (FOLDER / f"{name}.svg").read_text(encoding="utf-8")
    root = ET.fromstring(stored.encode())
    for group in root.iter(f"{SVG}g"):
        for path in list(group)[::-1]:
            group.remove(path)
            group.append(path)
            pairs = path.attrib["d"].lstrip("M").split()
            turned = [f"{float(u) + 0.02} {float(v) - 0.02}" for u, v in zip(pairs[::2], pairs[1::2], strict=True)]
            path.set("d", "M" + " ".join(turned[::-1]))
    assert differences(ET.tostring(root, encoding="unicode"), stored) == []
