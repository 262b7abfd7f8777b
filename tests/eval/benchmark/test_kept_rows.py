"""Rows of a run that was stopped, that failed at a mesh, or that other code wrote."""

from collections.abc import Callable, Iterable
from pathlib import Path

import pytest

from eval.benchmark import kept_rows
from eval.benchmark.kept_rows import measure_kept
from eval.benchmark.neatness import Neatness
from ncmodel.errors import MeshError
from ncmodel.mesh.load import make_mesh
from ncmodel.scene.surface import Surface
from ncmodel.types import Mesh
from tests.helpers.dirty import box


class Counting:
    """Measures nothing, tells what it was given, and fails at shapes of one name."""

    def __init__(self, fails_at: str = "") -> None:
        self.asked: list[str] = []
        self.fails_at = fails_at

    def __call__(self, surfaces: Iterable[Surface], advance: Callable[[str], None]) -> list[Neatness]:
        rows = []
        for surface in surfaces:
            name = surface.mesh.name
            self.asked.append(name)
            if name == self.fails_at:
                raise MeshError(name, "a hole", "none")
            advance(name)
            rows.append(Neatness(name, 30.0, 20.0, 0.1 + 0.2, 1.0, 2.0, 0.5, 0.25, float(len(self.asked))))
        return rows


def boxes(*names: str) -> list[Mesh]:
    return [make_mesh(*box(), name=name) for name in names]


def test_what_was_measured_is_not_measured_again(tmp_path: Path) -> None:
    told: list[str] = []
    first, second = Counting(), Counting()
    rows, failures = measure_kept(Neatness, first, boxes("a", "b"), tmp_path / "rows.csv", told.append)
    again, _ = measure_kept(Neatness, second, boxes("a", "c", "b"), tmp_path / "rows.csv", told.append)
    assert (first.asked, second.asked, failures) == (["a", "b"], ["c"], [])
    assert [row.shape for row in again] == ["a", "c", "b"]
    assert [again[0], again[2]] == rows
    assert told == ["a", "b", "a", "c", "b"]


def test_a_mesh_that_fails_is_told_and_the_others_are_kept(tmp_path: Path) -> None:
    rows, failures = measure_kept(Neatness, Counting("b"), boxes("a", "b", "c"), tmp_path / "rows.csv", lambda _: None)
    assert [row.shape for row in rows] == ["a", "c"]
    assert failures == ["b: b: a hole; expected none"]
    later = Counting()
    rows, failures = measure_kept(Neatness, later, boxes("a", "b", "c"), tmp_path / "rows.csv", lambda _: None)
    assert (later.asked, failures, len(rows)) == (["b"], [], 3)


def test_a_run_that_is_stopped_keeps_what_it_has(tmp_path: Path) -> None:
    def stopped(surfaces: Iterable[Surface], advance: Callable[[str], None]) -> list[Neatness]:
        if [surface.mesh.name for surface in surfaces] == ["b"]:
            raise KeyboardInterrupt
        return Counting()(boxes_of("a"), advance)

    def boxes_of(name: str) -> list[Surface]:
        return [Surface(mesh) for mesh in boxes(name)]

    with pytest.raises(KeyboardInterrupt):
        measure_kept(Neatness, stopped, boxes("a", "b"), tmp_path / "rows.csv", lambda _: None)
    later = Counting()
    measure_kept(Neatness, later, boxes("a", "b"), tmp_path / "rows.csv", lambda _: None)
    assert later.asked == ["b"]


def test_other_meshes_other_code_and_other_columns_are_measured_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "rows.csv"
    measure_kept(Neatness, Counting(), boxes("a"), file, lambda _: None)
    longer = Counting()
    measure_kept(Neatness, longer, [make_mesh(*box((0, 0, 0), (2, 1, 1)), name="a")], file, lambda _: None)
    monkeypatch.setattr(kept_rows, "_code", lambda: b"another version")
    newer = Counting()
    measure_kept(Neatness, newer, boxes("a"), file, lambda _: None)
    file.write_text(file.read_text(encoding="utf-8").replace("jaggedness", "wildness"), encoding="utf-8")
    wild = Counting()
    measure_kept(Neatness, wild, boxes("a"), file, lambda _: None)
    assert (longer.asked, newer.asked, wild.asked) == (["a"], ["a"], ["a"])


def test_the_file_is_a_table(tmp_path: Path) -> None:
    measure_kept(Neatness, Counting(), boxes("a", "b"), tmp_path / "rows.csv", lambda _: None)
    head, *rows = (tmp_path / "rows.csv").read_text(encoding="utf-8").splitlines()
    assert head.startswith("shape,azimuth,elevation,jaggedness,dashes,")
    assert [row.split(",")[:4] for row in rows] == [[name, "30.0", "20.0", "0.30000000000000004"] for name in "ab"]
