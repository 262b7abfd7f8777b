"""A shape's name: readable, one shape's alone, and the same for ever."""

import itertools
import json
import shutil
import unicodedata
from pathlib import Path

import pytest

from dataset_tools.build.mesh_files import find_sources
from dataset_tools.build.shape_names import file_name, known_names, name_shapes
from ncmodel.data.data_folder import DataFolder
from tests.helpers.builds import build, contents, state

CHAIR, DESK = "\u6905\u5b50", "\u684c\u5b50"


def test_letters_of_all_scripts_stay() -> None:
    for name in (CHAIR, "стул", "\u0915\u0941\u0930\u094d\u0938\u0940", "كرسي", "a-1.5"):
        assert file_name(name) == unicodedata.normalize("NFC", name)
    assert file_name(unicodedata.normalize("NFD", "Stühle")) == "Stühle"
    assert file_name("a b/c\nd:*e") == "a_b_c_d_e"
    assert file_name("..") == "shape"


def test_long_names_are_cut_and_differ() -> None:
    long = [file_name(f"{CHAIR * 60}{end}") for end in "ab"]
    assert long[0] != long[1]
    assert all(len(name.encode()) < 200 and name.startswith(CHAIR) for name in long)


def test_names_are_different_whatever_the_paths() -> None:
    places = ["a/b.ply", "a b.ply", "a_b.ply", "a_b.obj", "A_B.stl", "a_b.ply.off", "a/b/ply.off"]
    names = name_shapes(places, {})
    assert len({name.casefold() for name in names.values()}) == len(places)
    for order in itertools.islice(itertools.permutations(places), 0, 5040, 97):
        assert name_shapes(order, {}) == names


def test_of_two_files_that_could_bear_a_name_neither_does() -> None:
    assert name_shapes(["chair.ply", "chair.stl"], {}) == {"chair.ply": "chair.ply", "chair.stl": "chair.stl"}
    assert name_shapes(["chair.ply", "chair.stl"], {"chair.stl": "chair"}) == {
        "chair.ply": "chair.ply",
        "chair.stl": "chair",
    }
    # Its file is gone, but the shape isn't: no other file takes its place.
    assert name_shapes(["chair.ply"], {"chair.stl": "chair"}) == {"chair.ply": "chair.ply"}


def test_files_that_are_added_leave_every_shape_as_it_is(meshes: Path, tmp_path: Path) -> None:
    here, data = tmp_path / "meshes", tmp_path / "data"
    here.mkdir()
    shutil.copy(meshes / "ball.ply", here / "chair.ply")
    shutil.copy(meshes / "ball.ply", here / f"{CHAIR}.ply")
    build(here, data)
    before = contents(data)
    assert {shape for shape, _ in state(data)} == {"chair", CHAIR}
    shutil.copy(meshes / "odd" / "bumpy.ply", here / "chair.PLY")
    shutil.copy(meshes / "odd" / "bumpy.ply", here / f"{DESK}.ply")
    build(here, data)
    after = contents(data)
    assert {shape for shape, _ in state(data)} == {"chair", CHAIR, "chair.PLY", DESK}
    shapes = [name for name in before if name.startswith(("shapes/", "views/"))]
    assert shapes
    assert {name: after[name] for name in shapes} == {name: before[name] for name in shapes}


@pytest.mark.parametrize(
    ("shapes", "expected"),
    [
        # The first of two got the plain name, as it did in folders of before.
        ({"chair": "chair.ply", "chair.stl": "chair.stl"}, {"chair.ply": "chair", "chair.stl": "chair.stl"}),
        ({"chair": "chair.stl"}, {"chair.ply": "chair.ply", "chair.stl": "chair"}),
        ({"shape": f"{CHAIR}.ply"}, {f"{CHAIR}.ply": "shape"}),
        ({"a_b": "b.ply", "a_b.ply": "a b.ply"}, {"a b.ply": "a_b.ply", "a/b.ply": "a_b"}),
        ({"a_c": "c.ply", "a_c.ply-2": "c.ply"}, {"a/c.ply": "a_c", "a\u00fc/c.ply": "a_c.ply-2"}),
        ({"chair": ""}, {"chair.ply": "chair"}),
    ],
)  # fmt: skip
def test_folders_of_before_go_on(tmp_path: Path, shapes: dict[str, str], expected: dict[str, str]) -> None:
    """They note the file's name alone; where that is damaged the shape's name tells."""
    data = DataFolder(tmp_path)
    for name, source in shapes.items():
        data.shape_folder(name).mkdir(parents=True)
        record = json.dumps({"source": source}) if source else "{"
        (data.shape_folder(name) / "clean.json").write_text(record)
    assert name_shapes(list(expected), known_names(data, list(expected))) == expected


def test_a_build_notes_where_each_shape_is_from(reference: tuple[Path, object]) -> None:
    record = json.loads((reference[0] / "shapes" / "odd_bumpy" / "clean.json").read_text())
    assert (record["source"], record["place"]) == ("bumpy.ply", "odd/bumpy.ply")
    assert known_names(DataFolder(reference[0]), [])["odd/bumpy.ply"] == "odd_bumpy"
    assert "cube" in {source.name for source in find_sources(reference[0].parent / "meshes", reference[0])}
