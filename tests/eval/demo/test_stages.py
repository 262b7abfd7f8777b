"""Stages run once, are measured, resume where they were, and pass their complaints on."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from eval.demo.stages import Stage, measure, run_stages
from ncmodel.errors import BatchError, InputError, NeuralContoursError
from tests.helpers.waiting import wait_until


def append(path: Path, text: str) -> None:
    with path.open("a", encoding="utf-8") as file:
        file.write(text)


def fail(path: Path, text: str) -> None:
    raise InputError(path, text, "something else")


def fail_partly(path: Path) -> None:
    path.write_text("most of it", encoding="utf-8")
    raise BatchError("1 of 3 failed")


def die() -> None:
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


def test_the_folder_may_be_spelled_in_another_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run_stages(stages(tmp_path), tmp_path)
    monkeypatch.chdir(tmp_path.parent)
    relative = Path(tmp_path.name)
    run_stages(stages(relative), relative)
    assert (tmp_path / "three").read_text(encoding="utf-8") == "three"


def test_a_stage_that_cannot_resume_starts_from_nothing(tmp_path: Path) -> None:
    (tmp_path / "one").write_text("half of an earlier run", encoding="utf-8")
    once = Stage("one", "write one", append, (tmp_path / "one", "one"), (tmp_path / "one",), resumes=False)
    run_stages([once], tmp_path)
    assert (tmp_path / "one").read_text(encoding="utf-8") == "one"


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


def test_a_killed_road_leaves_no_stage_behind(tmp_path: Path) -> None:
    pipeline = subprocess.Popen([sys.executable, "-c", PIPELINE, str(tmp_path)], stderr=subprocess.DEVNULL)
    pid_file = tmp_path / "pid"
    wait_until(pid_file.exists)
    stage = int(pid_file.read_text(encoding="utf-8"))
    assert _alive(stage)
    pipeline.kill()
    pipeline.wait()
    wait_until(lambda: not _alive(stage))


PIPELINE = """
import sys
from pathlib import Path
from tests.eval.demo.test_stages import linger
from eval.demo.stages import measure
measure(linger, Path(sys.argv[1]))
"""


def linger(folder: Path) -> None:
    aside = folder / "pid.part"
    aside.write_text(str(os.getpid()), encoding="utf-8")
    aside.rename(folder / "pid")
    time.sleep(300)


def _alive(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"
