"""Commands of other packages, completion by the shell, the version."""

import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

from ncmodel.cli.main import main

ENTRY_POINTS = """[ncontours.commands]
greet = strangers_module:greet
zoo = strangers_module:zoo
absent = no_such_module:command
number = strangers_module:NUMBER
draw = strangers_module:greet
"""

MODULE = """
import typer

NUMBER = 3
zoo = typer.Typer(help="Animals.")

def greet(name: str, loud: bool = False) -> None:
    \"\"\"Say hello.\"\"\"
    print(f"HELLO {name}" if loud else f"hello {name}")

@zoo.command()
def feed(animal: str) -> None:
    print(f"fed {animal}")
"""


@pytest.fixture
def stranger(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An installed package that adds commands: two that work, two that can't be loaded, one under a name of ours."""
    info = tmp_path / "stranger-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: stranger\nVersion: 1.0\n", encoding="utf-8")
    (info / "entry_points.txt").write_text(ENTRY_POINTS, encoding="utf-8")
    (tmp_path / "strangers_module.py").write_text(MODULE, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("greet you --loud", "HELLO you\n"),
        ("zoo feed lions", "fed lions\n"),
        ("zoo --help", "Animals."),
        ("--help", "Say hello."),
        ("--help", "Animals."),
        ("draw --help", "Draw the lines of shapes"),
    ],
)
@pytest.mark.usefixtures("stranger")
def test_packages_add_commands(arguments: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments.split()) == 0
    assert said in capsys.readouterr().out


@pytest.mark.parametrize(("name", "reason"), [("absent", "No module named"), ("number", "3 is not a callable object")])
@pytest.mark.usefixtures("stranger")
def test_a_command_that_cannot_be_loaded_says_so_in_one_line(
    name: str, reason: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([name]) == 2
    err = capsys.readouterr().err
    assert err.startswith(f"ncontours: {name}: can't be loaded from ")
    assert reason in err
    assert err.count("\n") == 1


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
        ("ncontours d", ["dataset", "demo", "draw"]),
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


def test_the_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"ncontours {version('neural-contours')}\n"
