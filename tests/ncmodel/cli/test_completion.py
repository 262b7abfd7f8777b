"""The shell completes commands, which are loaded when they are asked for, and options."""

import subprocess
import sys
from pathlib import Path

import pytest


def complete(words: str) -> list[str]:
    """What the shell offers for the last of the words."""
    count = len(words.split(" ")) - 1
    env = {"_NCONTOURS_COMPLETE": "complete_bash", "COMP_WORDS": words, "COMP_CWORD": str(count)}
    command = [sys.executable, "-m", "ncmodel.cli.main"]
    done = subprocess.run(
        command, capture_output=True, text=True, check=True, env={"PYTHONPATH": ":".join(sys.path), **env}
    )
    return done.stdout.split()


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ("ncontours cro", ["crowd"]),
        ("ncontours crowd st", ["study"]),
        ("ncontours crowd study build --dr", ["--drawing-side"]),
        ("ncontours d", ["dataset", "decision-tree", "demo", "draw"]),
    ],
)
def test_the_shell_completes_commands_and_options(words: str, offered: list[str]) -> None:
    assert complete(words) == offered


@pytest.mark.parametrize("option", ["--show-completion", "--install-completion"])
def test_completion_is_shown_and_installed(option: str, tmp_path: Path) -> None:
    # A test's parent is no shell, so the shell is named.
    env = {"_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1", "HOME": str(tmp_path), "PYTHONPATH": ":".join(sys.path)}
    command = [sys.executable, "-m", "ncmodel.cli.main", option, "bash"]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=env)
    written = [path.read_text(encoding="utf-8") for path in tmp_path.rglob("*.sh")]
    assert "complete -o default -F _ncontours_completion ncontours" in "".join([done.stdout, *written])
    assert len(written) == (option == "--install-completion")
