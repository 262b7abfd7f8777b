"""Pictures of many drawings: on pages beside the report, each of which opens by itself."""

import re
from pathlib import Path

import numpy as np
import pytest

from eval.measures import report
from ncmodel.cli.main import main
from ncmodel.images import from_ink, write_png


def evaluate(tmp_path: Path, count: int) -> Path:
    ink = np.zeros((40, 50))
    ink[20:23] = 1.0
    for folder in (tmp_path / "d", tmp_path / "r"):
        folder.mkdir(exist_ok=True)
        for path in folder.iterdir():
            path.unlink()
        for number in range(count):
            write_png(folder / f"shape_{number}.png", from_ink(ink))
    out = tmp_path / "out"
    assert (
        main(["evaluate", "--drawings", str(tmp_path / "d"), "--references", str(tmp_path / "r"), "-o", str(out)]) == 0
    )
    return out


def shown(path: Path) -> list[str]:
    """Headings of the grids on a page."""
    text = path.read_text()
    assert len(re.findall(r'<img src="data:', text)) == len(re.findall("<img src=", text))
    return re.findall(r"<h3>(.*?)</h3>", text)


def test_many_pictures_are_on_pages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report, "MOST_PICTURES", 4)  # two drawings, each with one overlay
    out = evaluate(tmp_path, 5)
    assert shown(out / "report.html") == []
    links = re.findall(r'<li><a href="(pages/.*?)">(.*?)</a>', (out / "report.html").read_text())
    assert links == [
        ("pages/0001.html", "shape_0 .. shape_1"),
        ("pages/0002.html", "shape_2 .. shape_3"),
        ("pages/0003.html", "shape_4 .. shape_4"),
    ]
    assert [name for page, _ in links for name in shown(out / page)] == [f"shape_{number}" for number in range(5)]
    assert all('<a href="../report.html">' in (out / page).read_text() for page, _ in links)


def test_pages_of_an_evaluation_before_are_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report, "MOST_PICTURES", 4)
    for count, pages in ((5, ["0001.html", "0002.html", "0003.html"]), (3, ["0001.html", "0002.html"]), (2, [])):
        out = evaluate(tmp_path, count)
        assert sorted(path.name for path in (out / "pages").iterdir()) == pages
    assert shown(out / "report.html") == ["shape_0", "shape_1"]
