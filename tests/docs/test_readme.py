"""What README's first screen tells newcomers to type works as it stands."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.helpers.imports import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")
FIRST_SCREEN = README.partition("\n## ")[0]


def _blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", FIRST_SCREEN, re.DOTALL)


def test_first_drawing_at_the_command_line_and_in_python(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    install, *lines = _blocks("sh")[0].splitlines()
    assert install.endswith("pip install .")
    monkeypatch.chdir(tmp_path)
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    subprocess.run(["bash", "-euc", "\n".join(lines)], check=True, env={**os.environ, "PATH": path})
    drawn = (tmp_path / "bunny.svg").read_bytes()
    (python,) = _blocks("python")
    assert len([line for line in python.splitlines() if line]) == 3
    exec(python, {})
    assert drawn != (tmp_path / "bunny.svg").read_bytes() != b""


def test_two_commands_set_up_what_they_need() -> None:
    main_job, tests = _blocks("sh")[1:]
    assert main_job == ".ci/setup && .venv/bin/ncontours demo out\n"
    assert tests == ".ci/setup .venv test && .venv/bin/python -m pytest -n 2\n"


def test_terms_are_explained_before_they_are_used_in_tables() -> None:
    before = README.partition("\n|")[0]
    assert all(f"**{term}**" in before for term in ("SC", "RV", "AR", "rtsc"))
