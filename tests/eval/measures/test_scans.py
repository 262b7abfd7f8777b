"""References in pencil, on grey paper, white on black: measured as black on white would be, or refused with a word."""

import json
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from eval.measures.evaluation import Settings
from eval.measures.folders import Folders, evaluate_folders
from eval.measures.scans import read_reference
from eval.measures.thinning import read_ink
from ncmodel.cli.main import main
from tests.helpers.commands import complaint

Grey = NDArray[np.float64]


def lines() -> Grey:
    """Ink of a circle and a stroke, antialiased."""
    ink = np.zeros((120, 160), np.uint8)
    cv2.circle(ink, (60, 60), 40, 255, 2, cv2.LINE_AA)
    cv2.line(ink, (110, 20), (140, 100), 255, 2, cv2.LINE_AA)
    return ink / 255


def noisy(brightness: Grey) -> Grey:
    return np.clip(brightness + np.random.default_rng(0).normal(0, 0.02, brightness.shape), 0, 1)


def write(path: Path, brightness: Grey) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), np.rint(255 * brightness).astype(np.uint8))
    return path


LOOKS: dict[str, Callable[[Grey], Grey]] = {
    "white on black": lambda ink: ink,
    "light on dark grey": lambda ink: noisy(0.25 + 0.4 * ink),
    "pencil": lambda ink: 1 - 0.35 * ink,
    "pale pencil on grey": lambda ink: noisy(0.75 - 0.3 * ink),
    "black on grey": lambda ink: 0.6 - 0.6 * ink,
    "black on dark grey": lambda ink: noisy(0.4 - 0.35 * ink),
    "pencil by a window": lambda ink: noisy(0.95 - 0.35 * np.linspace(0, 1, 160) - 0.22 * ink),
    "pencil under a lamp": lambda ink: noisy(0.95 * np.exp(-(np.linspace(-1, 0.3, 160) ** 2)) - 0.3 * ink),
    "chalk on an uneven board": lambda ink: noisy(0.15 + 0.25 * np.linspace(0, 1, 120)[:, None] + 0.5 * ink),
}


def measured(folder: Path) -> tuple[list[float], tuple[str, ...]]:
    """F1 of each reference, and the notes."""
    done = evaluate_folders(Folders({"d": folder / "d"}, folder / "r"), Settings(2.0), folder, lambda _: None)
    assert not done.failures
    (evaluation,) = done.comparison.evaluations.values()
    return [score.measures.f1 for score in evaluation.scores], done.notes


@pytest.mark.parametrize("look", LOOKS)
@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif"])
def test_every_look_measures_as_black_on_white_does(tmp_path: Path, look: str, suffix: str) -> None:
    write(tmp_path / "d" / "a.png", 1 - lines())
    write(tmp_path / "r" / f"a{suffix}", LOOKS[look](lines()))
    f1, notes = measured(tmp_path)
    assert f1 == [pytest.approx(1.0, abs=0.02)]
    assert not notes


def test_the_dark_edge_of_a_scan_does_not_hide_pencil(tmp_path: Path) -> None:
    """The edge itself is in the picture, and is measured."""
    page = 0.92 - 0.4 * lines()
    page[:, :3] = 0.1
    write(tmp_path / "d" / "a.png", 1 - lines())
    write(tmp_path / "r" / "a.jpg", page)
    (f1,), _ = measured(tmp_path)
    assert f1 > 0.8


def test_a_photograph_is_turned_as_the_camera_says(tmp_path: Path) -> None:
    """Tag 274 of a JPEG is 6 where it has to be turned by 90 degrees clockwise to be seen."""
    camera = Image.Exif()
    camera[274] = 6
    write(tmp_path / "d" / "a.png", 1 - lines())
    (tmp_path / "r").mkdir()
    turned = np.rot90(np.rint(255 * (1 - lines())).astype(np.uint8))
    Image.fromarray(np.ascontiguousarray(turned)).save(tmp_path / "r" / "a.jpg", exif=camera)
    f1, _ = measured(tmp_path)
    assert f1 == [pytest.approx(1.0, abs=0.02)]


def test_dark_lines_on_white_are_taken_as_they_are(tmp_path: Path) -> None:
    path = write(tmp_path / "a.png", 1 - 0.9 * lines())
    np.testing.assert_array_equal(read_reference(path), read_ink(path))
    blank = write(tmp_path / "b.png", np.full((50, 60), 0.95))
    np.testing.assert_array_equal(read_reference(blank), read_ink(blank))


def test_what_is_no_line_drawing_is_refused_with_a_word(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A shaded picture, and paper too grey with nothing on it."""
    for name in ("a", "b", "c"):
        write(tmp_path / "d" / f"{name}.png", 1 - lines())
    shaded = np.where(np.arange(160) < 70, 0.1, 1.0) * np.ones((120, 1))
    write(tmp_path / "r" / "a.png", shaded)
    write(tmp_path / "r" / "b.png", np.full((120, 160), 0.3))
    write(tmp_path / "r" / "c.png", 1 - lines())
    where = ["--drawings", str(tmp_path / "d"), "--references", str(tmp_path / "r"), "-o", str(tmp_path / "out")]
    line = complaint(capsys, "evaluate", *where, status=1)
    for part in ("a.png: 44% of it is ink; expected lines on paper", "b.png: 100% of it is ink"):
        assert part in line
    assert len(json.loads((tmp_path / "out" / "report.json").read_text())["drawings"]) == 1


def test_pictures_that_are_hardly_meant_are_noted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A drawing the wrong way round, one without lines, and outlines that take all lines away."""
    write(tmp_path / "d" / "inverse.png", lines())
    write(tmp_path / "d" / "blank.png", np.ones((120, 160)))
    for name in ("inverse", "blank"):
        write(tmp_path / "r" / f"{name}.png", 1 - lines())
    where = ["--drawings", str(tmp_path / "d"), "--references", str(tmp_path / "r"), "-o", str(tmp_path / "out")]
    assert main(["evaluate", *where]) == 0
    told = capsys.readouterr().err
    notes = json.loads((tmp_path / "out" / "report.json").read_text())["notes"]
    assert all(f"note: {note}\n" in told for note in notes)
    assert [note.removeprefix(f"{tmp_path}/") for note in notes] == [
        "d/blank.png: nothing is drawn in it",
        "d/inverse.png: 94% of it is ink; expected dark lines on light paper, at most a third",
    ]
    assert notes[0] in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")

    for name in ("inverse", "blank"):
        write(tmp_path / "s" / f"{name}.png", 1 - lines())
        write(tmp_path / "d" / f"{name}.png", 1 - lines())
    assert main(["evaluate", *where, "--silhouettes", str(tmp_path / "s")]) == 0
    notes = json.loads((tmp_path / "out" / "report.json").read_text())["notes"]
    assert len(notes) == 4
    assert all("nothing is left in it without what is near the silhouette" in note for note in notes)


def test_areas_and_silhouettes_without_an_outline_are_noted(tmp_path: Path) -> None:
    """A mask in place of a drawing; masks of zeros and ones, which look all black."""
    disc = np.hypot(*np.mgrid[-60:60, -80:80]) < 35
    write(tmp_path / "r" / "a.png", 1.0 - disc)
    write(tmp_path / "d" / "a.png", 1 - lines())
    _, notes = measured(tmp_path)
    assert [note.removeprefix(f"{tmp_path}/") for note in notes] == [
        "r/a.png: its lines are 45 pixels wide, as areas are; only their middle is measured"
    ]
    write(tmp_path / "r" / "a.png", 1 - lines())
    write(tmp_path / "s" / "a.png", disc / 255)
    folders = Folders({"d": tmp_path / "d"}, tmp_path / "r", tmp_path / "s")
    assert evaluate_folders(folders, Settings(2.0), tmp_path, lambda _: None).notes == (
        "a: its silhouette has no outline; expected a mask or an outline, black on white",
    )
