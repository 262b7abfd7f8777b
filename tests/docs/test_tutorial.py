"""The tutorial's commands, as they stand on the page, from meshes to a drawing by a trained model."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ncmodel.images import read_grey
from tests.helpers.pages import ROOT, blocks


def shim(path: Path, call: str) -> None:
    """A program that calls this Python."""
    path.write_text(f'#!/bin/sh\nexec "{sys.executable}" {call}"$@"\n', encoding="utf-8")
    path.chmod(0o755)


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder in which all commands of the tutorial were run, in order, in one shell."""
    programs, folder = tmp_path_factory.mktemp("programs"), tmp_path_factory.mktemp("tutorial")
    shim(programs / "ncontours", "-m ncmodel.cli.main ")
    shim(programs / "python", "")
    script = "\n".join(block.text for block in blocks(ROOT / "docs/tutorial.md", "sh"))
    environment = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT)}
    run = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", script], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert run.returncode == 0, f"{run.stdout}\n{run.stderr}"
    return folder


def test_drawings_are_made(done: Path) -> None:
    few, many = ((done / name).read_text(encoding="utf-8") for name in ("bunny.svg", "bunny-more.svg"))
    assert 'id="ridges"' not in few
    assert 'id="ridges"' in many
    assert many.count("<path") > few.count("<path")
    assert read_grey(done / "cow.png").shape == (768, 768)


def test_votes_become_pairs(done: Path) -> None:
    assert (done / "data/index.csv").read_text(encoding="utf-8").count("done") == 6
    assert (done / "sheet.png").stat().st_size > 10_000
    assert (done / "pairs.jsonl").read_text(encoding="utf-8").count('"split": "train"') >= 7


def test_the_model_draws(done: Path) -> None:
    assert (done / "model.safetensors").stat().st_size > 100_000
    assert 'id="contours"' in (done / "bunny-model.svg").read_text(encoding="utf-8")
