"""The drawing of the architecture shows the code as it is."""

import re
from pathlib import Path
from xml.etree import ElementTree

from docs.make_architecture import BOX, FIGURE, MARGIN, WIDTH, figure
from tests.helpers.imports import CHAIN, ROOT, TEMPLATES

SVG = "{http://www.w3.org/2000/svg}"


def test_the_drawing_in_the_docs_is_up_to_date() -> None:
    assert FIGURE.read_text(encoding="utf-8") == figure(ROOT), "run: python -m docs.make_architecture"


def test_rooms_fit_on_the_page() -> None:
    drawn = ElementTree.fromstring(FIGURE.read_text(encoding="utf-8"))
    left = [float(box.attrib["x"]) for box in drawn.iter(f"{SVG}rect") if box.get("class", "").startswith("room")]
    assert len(left) > 20
    assert min(left) > MARGIN
    assert max(left) < WIDTH - MARGIN - BOX


def _tree(root: Path, imports: str) -> Path:
    files = {
        "ncmodel/mesh/__init__.py": '"""Mesh files to meshes."""\n',
        "ncmodel/mesh/load.py": "",
        "ncmodel/lines/__init__.py": '"""Where lines run."""\n',
        "ncmodel/lines/ridges.py": imports,
        "dataset_tools/votes/__init__.py": '"""What comes back."""\n',
        "eval/measures/__init__.py": '"""Drawings against drawings."""\n',
    }
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        (root / name.partition("/")[0] / "__init__.py").touch()
    return root


def test_an_import_makes_an_arrow(tmp_path: Path) -> None:
    alone = figure(_tree(tmp_path, ""))
    linked = figure(_tree(tmp_path, "from ncmodel.mesh import load\n"))
    assert linked.count('class="arrow ') == alone.count('class="arrow ') + 1
    assert "Mesh files to meshes<" in alone


PAGE = ROOT / "docs" / "architecture.md"
PLACE = re.compile(r"`([a-z_0-9/.]+/[a-z_0-9/.]*)`((?:(?::|,) `\w+`)*)")
"""A path of the tree, and the names in it that follow: `folder/file.py`: `one`, `other`."""


def test_the_page_names_what_there_is() -> None:
    places = PLACE.findall(PAGE.read_text(encoding="utf-8"))
    assert len(places) > 50
    missing = []
    for path, names in places:
        text = (ROOT / path).read_text(encoding="utf-8") if (ROOT / path).is_file() else ""
        missing += [] if (ROOT / path).exists() else [path]
        missing += [
            f"{path}: {name}"
            for name in re.findall(r"`(\w+)`", names)
            if not re.search(rf"^(?:def|class) {name}\b|^{name}\b.*=", text, re.MULTILINE)
        ]
    assert missing == []


def test_the_page_names_every_package() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert all(f"`{name}/" in page for name in (*CHAIN, TEMPLATES))
