"""The command `ncontours evaluate`: its files, exit status and one-line complaints."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from eval.cli.evaluate import resolve_tolerance
from eval.measures.metrics import f1_score
from ncmodel.cli.main import main
from ncmodel.errors import UsageError
from ncmodel.images import from_ink, write_png
from tests.helpers.commands import complaint

KEYS = {"name", "reference", "precision", "recall", "f1", "iou", "chamfer"}


def draw(path: Path, *rows: int, size: tuple[int, int] = (60, 80)) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    ink = np.zeros(size)
    for row in rows:
        ink[row - 1 : row + 2] = 1.0
    write_png(path, from_ink(ink))


@pytest.fixture
def folders(tmp_path: Path) -> Path:
    draw(tmp_path / "d" / "bunny_0.png", 10, 30)
    draw(tmp_path / "d" / "cow_0.png", 20)
    draw(tmp_path / "r" / "bunny_0.png", 11)
    draw(tmp_path / "r" / "cow_0" / "ann.png", 23)
    draw(tmp_path / "r" / "cow_0" / "ben.png", 22, 40)
    return tmp_path


def command(root: Path, *more: str) -> list[str]:
    return [
        "evaluate", "--drawings", str(root / "d"), "--references", str(root / "r"), "-o", str(root / "out"), *more
    ]  # fmt: skip


def test_the_report_has_the_keys_and_numbers_of_the_format(folders: Path) -> None:
    assert main(command(folders, "--tolerance-pixels", "2")) == 0
    report = json.loads((folders / "out" / "report.json").read_text())
    assert [set(drawing) for drawing in report["drawings"]] == [KEYS] * 3
    assert [(d["name"], d["reference"]) for d in report["drawings"]] == [
        ("bunny_0", "bunny_0.png"),
        ("cow_0", "cow_0/ann.png"),
        ("cow_0", "cow_0/ben.png"),
    ]
    bunny, ann, ben = report["drawings"]
    assert (bunny["precision"], bunny["recall"]) == (0.5, 1.0)
    # Thinning takes a pixel or two from a line's ends.
    assert (ann["precision"], ann["chamfer"]) == (0.0, pytest.approx(3.0, abs=0.05))
    assert (ben["precision"], ben["recall"]) == (1.0, 0.5)
    mean = report["mean"]
    assert set(mean) == KEYS - {"name", "reference"}
    assert (mean["precision"], mean["recall"]) == pytest.approx((0.5, 0.5))
    assert mean["f1"] == pytest.approx(f1_score(mean["precision"], mean["recall"]))
    assert report["settings"]["tolerance_pixels"] == 2.0
    assert all(math.isfinite(end) for interval in report["interval"].values() for end in interval.values())


def test_the_page_stands_alone_and_shows_every_drawing(folders: Path) -> None:
    assert main(command(folders)) == 0
    page = (folders / "out" / "report.html").read_text(encoding="utf-8")
    assert page.count('<img src="data:image/png;base64,') == 5
    assert "cow_0/ben.png" in page
    assert "http" not in page.replace("http-equiv", "").replace("http://www.w3.org", "")


def test_json_is_the_only_thing_on_stdout(folders: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(command(folders, "--json")) == 0
    assert json.loads(capsys.readouterr().out) == json.loads((folders / "out" / "report.json").read_text())


def test_the_same_call_writes_the_same_bytes(folders: Path) -> None:
    written = []
    for _ in range(2):
        assert main(command(folders)) == 0
        written.append([(folders / "out" / name).read_bytes() for name in ("report.json", "report.html")])
    assert written[0] == written[1]


def test_a_tolerance_on_the_page(folders: Path) -> None:
    assert main(command(folders, "--tolerance-mm", "1", "--mm-per-pixel", "0.25")) == 0
    settings = json.loads((folders / "out" / "report.json").read_text())["settings"]
    assert (settings["tolerance_pixels"], settings["tolerance_mm"], settings["mm_per_pixel"]) == (4.0, 1.0, 0.25)


def test_tolerances_that_contradict_each_other() -> None:
    assert resolve_tolerance(None, None, None) == (5.0, {})
    assert resolve_tolerance(None, None, 0.5)[0] == 2.0
    for bad in [(1.0, 1.0, 1.0), (1.0, None, 1.0), (None, 1.0, None)]:
        with pytest.raises(UsageError, match="expected"):
            resolve_tolerance(*bad)


def test_the_most_consistent_reference_only(folders: Path) -> None:
    draw(folders / "r" / "cow_0" / "eve.png", 22)
    assert main(command(folders, "--most-consistent")) == 0
    report = json.loads((folders / "out" / "report.json").read_text())
    assert [d["reference"] for d in report["drawings"]] == ["bunny_0.png", "cow_0/eve.png"]


def test_silhouettes_go(folders: Path) -> None:
    draw(folders / "s" / "bunny_0.png", 30)
    draw(folders / "s" / "cow_0.png", 50)
    assert main(command(folders, "--silhouettes", str(folders / "s"))) == 0
    assert json.loads((folders / "out" / "report.json").read_text())["drawings"][0]["precision"] == 1.0


def test_methods_beside_each_other(folders: Path, capsys: pytest.CaptureFixture[str]) -> None:
    draw(folders / "other" / "bunny_0.png", 11)
    draw(folders / "other" / "cow_0.png", 22)
    assert main(command(folders, "--drawings", str(folders / "other"))) == 0
    report = json.loads((folders / "out" / "report.json").read_text())
    assert list(report["methods"]) == ["d", "other"]
    assert report["methods"]["d"] == report["mean"]
    assert report["methods"]["other"]["f1"] > report["mean"]["f1"]
    assert capsys.readouterr().out.splitlines()[2].startswith("other")
    assert "2 folders of 1 names" in complaint(capsys, *command(folders, "--drawings", str(folders / "x" / ".." / "d")))


def test_what_cannot_be_measured_is_named_and_the_rest_is_written(
    folders: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    draw(folders / "d" / "lonely.png", 5)
    draw(folders / "r" / "undrawn.png", 5)
    draw(folders / "d" / "wide.png", 5, size=(60, 81))
    draw(folders / "r" / "wide.png", 5)
    draw(folders / "r" / "zapped.png", 5)
    (folders / "d" / "zapped.png").write_bytes(b"not a picture")
    line = complaint(capsys, *command(folders), status=1)
    assert line.startswith("ncontours: 4 not measured: ")
    for part in (
        "lonely.png: no reference of that name",
        "undrawn: a reference without a drawing",
        "wide: the drawing is 81 x 60 pixels, wide.png is 80 x 60 pixels",
        "zapped.png: 13 bytes, damaged or no picture",
    ):
        assert part in line
    report = json.loads((folders / "out" / "report.json").read_text())
    assert len(report["drawings"]) == 3
    assert len(report["failures"]) == 4
    assert "4 not measured" in (folders / "out" / "report.html").read_text(encoding="utf-8")


def test_a_missing_silhouette_fails_its_drawing_only(folders: Path, capsys: pytest.CaptureFixture[str]) -> None:
    draw(folders / "s" / "bunny_0.png", 50)
    assert "cow_0.png: can't be read (No such file or directory)" in complaint(
        capsys, *command(folders, "--silhouettes", str(folders / "s")), status=1
    )


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--drawings", "nowhere"], "nowhere: doesn't exist; expected a folder of drawings"),
        (["--references", "nowhere"], "nowhere: doesn't exist; expected a folder of references"),
        (["--silhouettes", "nowhere"], "nowhere: doesn't exist; expected a folder of drawings"),
        (["--tolerance-pixels", "-1"], "--tolerance-pixels: found -1.0, expected 0 or more"),
        (["--tolerance-pixels", "nan"], "--tolerance-pixels: found nan"),
        (["--tolerance-pixels", "1", "--tolerance-mm", "1"], "expected one of them"),
        (["--tolerance-mm", "1"], "expected --mm-per-pixel"),
        (["--mm-per-pixel", "0"], "--mm-per-pixel: found 0.0, expected more than 0"),
        (["--threshold", "2"], "--threshold: found 2.0, expected a number above 0"),
        (["--threshold", "x"], "--threshold"),
    ],
)
def test_bad_input_is_one_line_and_status_2(
    folders: Path, capsys: pytest.CaptureFixture[str], options: list[str], words: str
) -> None:
    assert words in complaint(capsys, *command(folders, *options))
    assert not (folders / "out").exists()


def test_when_nothing_can_be_measured_nothing_is_written(folders: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("bunny_0", "cow_0"):
        (folders / "d" / f"{name}.png").write_bytes(b"")
    assert main(command(folders)) == 2
    assert "nothing could be measured" in capsys.readouterr().err.splitlines()[-1]
    assert not (folders / "out").exists()
