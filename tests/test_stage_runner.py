"""Stages run once, are measured, resume where they were, and pass their complaints on."""

import json
from pathlib import Path

import pytest

from ncmodel.cli.stage_runner import Stage, measure, run_stages
from ncmodel.errors import BatchError, InputError, NeuralContoursError


def append(path: Path, text: str) -> None:
    with path.open("a", encoding="utf-8") as file:
        file.write(text)


def fail(path: Path, text: str) -> None:
    raise InputError(path, text, "something else")


def fail_partly(path: Path) -> None:
    path.write_text("most of it", encoding="utf-8")
    raise BatchError("1 of 3 failed")


def die() -> None:
    import os

    os._exit(7)


def allocate(megabytes: int) -> None:
    block = bytearray(megabytes << 20)
    block[::4096] = b"x" * len(block[::4096])


def stages(folder: Path) -> list[Stage]:
    return [
        Stage(name, f"write {name}", append, (folder / name, name), (folder / name,))
        for name in ("one", "two", "three")
    ]


def test_finished_stages_do_not_run_again(tmp_path: Path) -> None:
    first = run_stages(stages(tmp_path), tmp_path)
    second = run_stages(stages(tmp_path), tmp_path)
    assert first == second
    assert (tmp_path / "one").read_text(encoding="utf-8") == "one"
    assert all(entry.seconds > 0 for entry in first.values())


def test_a_lost_output_is_made_again_and_so_is_all_that_follows(tmp_path: Path) -> None:
    run_stages(stages(tmp_path), tmp_path)
    (tmp_path / "two").unlink()
    run_stages(stages(tmp_path), tmp_path)
    contents = [(tmp_path / name).read_text(encoding="utf-8") for name in ("one", "two", "three")]
    assert contents == ["one", "two", "threethree"]


def test_a_complaint_stops_the_road_and_keeps_what_was_done(tmp_path: Path) -> None:
    bad = Stage("bad", "complain", fail, (tmp_path / "x", "nonsense"), (tmp_path / "x",))
    with pytest.raises(NeuralContoursError, match="x: nonsense; expected something else"):
        run_stages([*stages(tmp_path)[:1], bad], tmp_path)
    assert list(json.loads((tmp_path / "stages.json").read_text(encoding="utf-8"))) == ["one"]


def test_items_that_failed_are_a_note(tmp_path: Path) -> None:
    part = Stage("part", "half-way", fail_partly, (tmp_path / "part",), (tmp_path / "part",))
    assert run_stages([part], tmp_path)["part"].note == "1 of 3 failed"


def test_a_process_that_dies_is_a_complaint() -> None:
    with pytest.raises(NeuralContoursError, match="die ended with status 7"):
        measure(die)


def test_memory_is_that_of_the_stage() -> None:
    small, large = measure(allocate, 1), measure(allocate, 200)
    assert 150 << 20 < large.peak_bytes - small.peak_bytes < 300 << 20


def test_a_spoiled_record_is_named(tmp_path: Path) -> None:
    (tmp_path / "stages.json").write_text("{", encoding="utf-8")
    with pytest.raises(InputError, match=r"stages\.json: not JSON"):
        run_stages(stages(tmp_path), tmp_path)
