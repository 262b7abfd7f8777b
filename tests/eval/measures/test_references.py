"""Drawings and references on disk, matched by name."""

import unicodedata
from pathlib import Path

import numpy as np
import pytest

from eval.measures.references import find_drawings, find_references, most_consistent, pair_up
from ncmodel.chamfer import Lines
from ncmodel.errors import InputError


def touch(root: Path, *names: str) -> Path:
    for name in names:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).touch()
    return root


def test_references_are_files_and_folders_of_one_name(tmp_path: Path) -> None:
    root = touch(tmp_path, "b.png", "a/2.png", "a/1.PNG", "a.png", "notes.txt", "c/readme.md", "c/deep/x.png")
    found = find_references(root)
    assert {name: [p.relative_to(root).as_posix() for p in paths] for name, paths in found.items()} == {
        "a": ["a.png", "a/1.PNG", "a/2.png"],
        "b": ["b.png"],
    }
    assert list(found) == ["a", "b"]


def test_jpeg_and_tiff_are_references_and_clutter_is_not(tmp_path: Path) -> None:
    root = touch(
        tmp_path, "a.jpg", "._a.jpg", "b/1.TIFF", "b/2.tif", "b/._1.tif", "b/3.jpeg", ".c/1.png", "__MACOSX/x.png"
    )
    assert {name: [path.name for path in paths] for name, paths in find_references(root).items()} == {
        "a": ["a.jpg"],
        "b": ["1.TIFF", "2.tif", "3.jpeg"],
    }


def test_drawings_are_what_draw_wrote_but_its_contact_sheet(tmp_path: Path) -> None:
    assert list(find_drawings(touch(tmp_path, "cat.png", "._cat.png", "contact-sheet.png", "cat.svg"))) == ["cat"]
    touch(tmp_path, "cat.PNG")
    with pytest.raises(InputError, match=r"cat\.png: the name of cat\.PNG too; expected one picture of a name"):
        find_drawings(tmp_path)


def test_names_match_however_their_letters_are_stored(tmp_path: Path) -> None:
    """Some systems store an accent beside its letter."""
    composed, apart = (unicodedata.normalize(form, "b\u00fcste") for form in ("NFC", "NFD"))
    drawings = touch(tmp_path / "d", f"{composed}.png", f"{apart}2.png")
    references = touch(tmp_path / "r", f"{apart}/1.png", f"{composed}2.png")
    pairing = pair_up(drawings, references)
    assert list(pairing.drawings) == list(pairing.references) == [composed, f"{composed}2"]
    assert not pairing.without_reference + pairing.without_drawing


def test_names_are_matched_and_the_rest_named(tmp_path: Path) -> None:
    drawings = touch(tmp_path / "d", "a.png", "b.png", "only_drawn.png")
    references = touch(tmp_path / "r", "a.png", "b/1.png", "b/2.png", "only_human.png")
    pairing = pair_up(drawings, references)
    assert list(pairing.drawings) == list(pairing.references) == ["a", "b"]
    assert pairing.without_reference == ("only_drawn",)
    assert pairing.without_drawing == ("only_human",)


def test_folders_that_share_no_name_are_refused(tmp_path: Path) -> None:
    drawings, references = touch(tmp_path / "d", "a.png"), touch(tmp_path / "r", "b.png", "c.png", "d.png", "e.png")
    with pytest.raises(
        InputError, match=r"no drawing has a reference \(a\); expected names as in .*b, c, d and 1 more"
    ):
        pair_up(drawings, references)


@pytest.mark.parametrize("find", [find_drawings, find_references])
def test_a_folder_must_exist_and_hold_pictures(tmp_path: Path, find: object) -> None:
    assert callable(find)
    (tmp_path / "file").touch()
    (tmp_path / "empty").mkdir()
    for name, found in [("missing", "doesn't exist"), ("file", "is a file"), ("empty", "no PNG file")]:
        with pytest.raises(InputError, match=f"{name}: {found}"):
            find(tmp_path / name)


def line_at(row: int) -> Lines:
    mask = np.zeros((60, 30), bool)
    mask[row] = True
    return Lines.of(mask)


def test_the_most_consistent_reference_is_the_one_nearest_to_the_rest() -> None:
    assert most_consistent([line_at(row) for row in (0, 12, 50)]) == 1
    assert most_consistent([line_at(row) for row in (50, 10, 12, 0, 11)]) == 4


def test_of_equals_the_first_is_taken() -> None:
    assert most_consistent([line_at(3)]) == 0
    assert most_consistent([line_at(3), line_at(7)]) == 0
    with pytest.raises(ValueError, match="no references"):
        most_consistent([])


def test_an_empty_reference_is_not_the_consistent_one() -> None:
    empty = Lines.of(np.zeros((60, 30), bool))
    assert most_consistent([empty, line_at(4), line_at(8)]) == 1
