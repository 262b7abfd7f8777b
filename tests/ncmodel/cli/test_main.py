"""Every command: its help, and one clear line with exit status 2 for bad input."""

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer

from ncmodel.cli.main import app, main

COMMANDS = {
    "draw",
    "features",
    "dataset build",
    "dataset clean",
    "dataset status",
    "crowd build",
    "crowd simulate",
    "crowd ingest",
    "crowd aggregate",
    "train",
    "evaluate",
    "demo",
}
"""What outside scripts call; there may be more."""

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def _commands() -> set[str]:
    return set(_leaves(typer.main.get_command(app), ""))


def _leaves(command: Any, name: str) -> Iterator[str]:
    if not hasattr(command, "list_commands"):
        yield name.strip()
        return
    for part in command.list_commands(None):
        yield from _leaves(command.get_command(None, part), f"{name} {part}")


def test_the_commands_that_scripts_call_exist() -> None:
    assert _commands() >= COMMANDS


@pytest.mark.parametrize("command", ["", *sorted(_commands())])
def test_help_explains(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*command.split(), "--help"]) == 0
    out = capsys.readouterr().out
    assert "Usage" in out
    assert "Learned" in out or len(out.splitlines()) > 6


@pytest.fixture
def files(tmp_path: Path) -> Path:
    """Files that are not what commands want."""
    (tmp_path / "triangle.obj").write_text(TRIANGLE, encoding="utf-8")
    (tmp_path / "no_mesh.obj").write_text("what is this?\n", encoding="utf-8")
    (tmp_path / "empty.obj").write_text("", encoding="utf-8")
    (tmp_path / "no_faces.ply").write_bytes(
        b"ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
    )
    (tmp_path / "nan.obj").write_text(TRIANGLE.replace("v 1", "v nan"), encoding="utf-8")
    (tmp_path / "wrong_keys.json").write_text('{"eye": [0, 0, 3]}', encoding="utf-8")
    (tmp_path / "no_json.json").write_text("{", encoding="utf-8")
    (tmp_path / "text.safetensors").write_text("not a checkpoint", encoding="utf-8")
    (tmp_path / "votes.csv").write_text("a,b\n1,2\n", encoding="utf-8")
    (tmp_path / "pairs.jsonl").write_text('{"shape": "x"}\n', encoding="utf-8")
    (tmp_path / "folder").mkdir()
    return tmp_path


BAD = {
    "unknown command": ("frobnicate", "No such command"),
    "unknown option": ("draw triangle.obj -o out.svg --frobnicate", "No such option"),
    "draw: missing file": ("draw absent.obj -o out.svg", "absent.obj"),
    "draw: empty file": ("draw empty.obj -o out.svg", "empty.obj"),
    "draw: not a mesh": ("draw no_mesh.obj -o out.svg", "no_mesh.obj"),
    "draw: no vertices": ("draw no_faces.ply -o out.svg", "no_faces.ply"),
    "draw: a folder": ("draw folder -o out.svg", "folder"),
    "draw: unknown format": ("draw triangle.obj -o out.bmp", "out.bmp"),
    "draw: wrong camera keys": ("draw triangle.obj -o out.svg --camera wrong_keys.json", "wrong_keys.json"),
    "draw: camera isn't JSON": ("draw triangle.obj -o out.svg --camera no_json.json", "no_json.json"),
    "draw: unknown family": ("draw triangle.obj -o out.svg --lines contours,hatching", "hatching"),
    "draw: bad threshold": ("draw triangle.obj -o out.svg --thresholds ridges=deep", "deep"),
    "draw: NaN threshold": ("draw triangle.obj -o out.svg --thresholds ridges=nan", "nan"),
    "draw: bad size": ("draw triangle.obj -o out.svg --size 0", "0"),
    "draw: no checkpoint": ("draw triangle.obj -o out.svg --model text.safetensors", "text.safetensors"),
    "features: missing camera": ("features triangle.obj --camera absent.json -o f.npz", "absent.json"),
    "features: not a mesh": ("features no_mesh.obj --camera wrong_keys.json -o f.npz", "no_mesh.obj|wrong_keys.json"),
    "dataset build: missing folder": ("dataset build absent data", "absent"),
    "dataset clean: not a mesh": ("dataset clean no_mesh.obj -o out.ply", "no_mesh.obj"),
    "dataset status: not a data folder": ("dataset status folder", "folder"),
    "crowd build: not a data folder": ("crowd build folder batch", "folder"),
    "crowd simulate: not a batch": ("crowd simulate folder -o results.csv", "folder"),
    "crowd ingest: not a batch": ("crowd ingest folder votes.csv -o out.csv", "folder"),
    "crowd aggregate: wrong columns": ("crowd aggregate votes.csv -o out.jsonl", "votes.csv"),
    "train: wrong pairs": ("train folder pairs.jsonl -o model.safetensors", "pairs.jsonl"),
    "train: unknown preset": ("train folder pairs.jsonl -o model.safetensors --preset huge", "huge"),
    "evaluate: missing folder": ("evaluate --drawings absent --references folder -o report", "absent"),
    "evaluate: empty folder": ("evaluate --drawings folder --references folder -o report", "folder"),
    "demo: somebody else's folder": ("demo .", "."),
}


@pytest.mark.parametrize("case", sorted(BAD))
def test_bad_input_is_one_clear_line(
    case: str, files: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(files)
    line, message = BAD[case]
    before = sorted(path.name for path in files.iterdir())
    assert main(line.split()) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert len(err.strip().splitlines()) == 1, err
    assert any(part in err for part in message.split("|")), err
    assert "Traceback" not in err
    left = set(sorted(path.name for path in files.iterdir())) - set(before)
    assert not {name for name in left if not (files / name).is_dir()}, "nothing half-done is left"


def test_the_command_runs_as_a_program(files: Path) -> None:
    line = [sys.executable, "-m", "ncmodel.cli.main", "draw", str(files / "absent.obj"), "-o", str(files / "x.svg")]
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("ncontours: ")
    assert len(done.stderr.splitlines()) == 1


def test_json_is_all_that_stdout_gets(files: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["draw", str(files / "triangle.obj"), "-o", str(files / "out.svg"), "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert isinstance(record, dict)
    assert (files / "out.svg").read_text(encoding="utf-8").startswith("<?xml")
