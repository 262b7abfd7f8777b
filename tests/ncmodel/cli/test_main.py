"""Every command: its help, and one clear line with exit status 2 for bad input."""

import json
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest
import typer

from ncmodel.cli.main import app, main
from tests.helpers.commands import complaint

COMMANDS = {
    "draw",
    "features",
    "dataset build",
    "dataset clean",
    "dataset status",
    "crowd build",
    "crowd serve",
    "crowd links",
    "crowd backup",
    "crowd ingest",
    "crowd aggregate",
    "crowd topup",
    "crowd simulate",
    "train",
    "evaluate",
    "bench",
    "demo",
}
"""What outside scripts call; there may be more."""

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def _commands() -> dict[str, Any]:
    """Every command by its name, groups too; the program's own is ''."""
    return dict(_with_parts(typer.main.get_command(app), ""))


def _with_parts(command: Any, name: str) -> Iterator[tuple[str, Any]]:
    yield name, command
    for part in _parts(command):
        yield from _with_parts(command.get_command(None, part), f"{name} {part}".strip())


def _parts(command: Any) -> list[str]:
    return list(command.list_commands(None)) if hasattr(command, "list_commands") else []


ALL = _commands()
CALLED = sorted(name for name, command in ALL.items() if not _parts(command))


def test_the_commands_that_scripts_call_exist() -> None:
    assert set(CALLED) >= COMMANDS


@pytest.mark.parametrize("name", sorted(ALL))
def test_help_explains(name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """A command's help is its docstring's first line, and says something about every argument and option."""
    monkeypatch.setenv("COLUMNS", "500")  # wide enough for lines that aren't broken
    command = ALL[name]
    assert main([*name.split(), "--help"]) == 0
    lines = [line.strip("│ ") for line in capsys.readouterr().out.splitlines()]
    assert lines[1].startswith(f"Usage: ncontours {name}".strip())
    summary = command.callback.__doc__ if command.callback else command.help
    assert lines[3] == summary.splitlines()[0]
    for option in command.params:
        names = {*option.opts, option.metavar, f"{option.name}..."}
        assert option.help, f"{option.name} is explained"
        assert any(names & set(row.split()) and option.help in row for row in lines), f"{option.name} is listed"
    for part in _parts(command):
        assert any(row.split()[:1] == [part] and len(row.split()) > 3 for row in lines), f"{part} is listed"


def test_the_version_is_that_of_the_installed_package(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"ncontours {version('neural-contours')}\n"


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
    "dataset shapes: unknown family": ("dataset shapes shapes --families dragon", "dragon"),
    "dataset build: missing folder": ("dataset build absent data", "absent"),
    "dataset disjoint: missing folder": ("dataset disjoint absent folder", "absent"),
    "dataset views: no cameras": ("dataset views folder folder", "folder"),
    "dataset clean: not a mesh": ("dataset clean no_mesh.obj -o out.ply", "no_mesh.obj"),
    "dataset status: not a data folder": ("dataset status folder", "folder"),
    "dataset export: not a view": ("dataset export folder out", "folder"),
    "dataset import: not of the format": ("dataset import folder maps.npz", "folder"),
    "dataset sheet: no view": ("dataset sheet folder -o sheet.png", "folder"),
    "dataset levels: no view": ("dataset levels folder", "folder"),
    "dataset bench: unknown option": ("dataset bench --frobnicate", "No such option"),
    "crowd build: not a data folder": ("crowd build folder batch", "folder"),
    "crowd simulate: not a batch": ("crowd simulate folder -o results.csv", "folder"),
    "crowd ingest: not a batch": ("crowd ingest folder votes.csv -o out.csv", "folder"),
    "crowd aggregate: wrong columns": ("crowd aggregate votes.csv -o out.jsonl", "votes.csv"),
    "crowd serve: not a batch": ("crowd serve folder --db votes.sqlite", "folder"),
    "crowd links: nobody": ("crowd links --db votes.sqlite --base-url https://a.example -o links.csv", "count"),
    "crowd backup: no database": ("crowd backup absent.sqlite -o copy.sqlite", "absent.sqlite"),
    "crowd topup: wrong columns": ("crowd topup folder votes.csv batch", "votes.csv"),
    "crowd audit: wrong columns": ("crowd audit votes.csv -o audit.html", "votes.csv"),
    "crowd review: wrong columns": ("crowd review votes.csv results.csv -o review.csv", "votes.csv"),
    "crowd trial: not a data folder": ("crowd trial folder -o trial.html", "folder"),
    "crowd study build: missing folder": (
        "crowd study build batch --ours NC=absent --against other=folder --renders folder",
        "absent",
    ),
    "crowd study simulate: not a batch": ("crowd study simulate folder -o results.csv", "folder"),
    "crowd study ingest: not a batch": ("crowd study ingest folder votes.csv -o answers.csv", "folder"),
    "crowd study report: wrong columns": ("crowd study report folder votes.csv -o study.html", "votes.csv|key.json"),
    "crowd study topup: not a batch": ("crowd study topup folder votes.csv more", "key.json"),
    "train: wrong pairs": ("train folder pairs.jsonl -o model.safetensors", "pairs.jsonl"),
    "train: unknown preset": ("train folder pairs.jsonl -o model.safetensors --preset huge", "huge"),
    "score: missing model": (
        "score triangle.obj absent.png --camera wrong_keys.json --model gone.safetensors",
        "gone.safetensors|wrong_keys.json|absent.png",
    ),
    "import-weights: missing file": ("import-weights --ranker gone.pth -o x.safetensors", "gone.pth"),
    "export-onnx: missing model": ("export-onnx gone.safetensors -o networks", "gone.safetensors"),
    "compare: wrong pairs": ("compare folder pairs.jsonl --model gone.safetensors -o report", "pairs.jsonl|folder"),
    "decision-tree: wrong pairs": ("decision-tree folder pairs.jsonl -o tree.json", "pairs.jsonl|folder"),
    "evaluate: missing folder": ("evaluate --drawings absent --references folder -o report", "absent"),
    "evaluate: empty folder": ("evaluate --drawings folder --references folder -o report", "folder"),
    "fit-camera: missing drawing": ("fit-camera triangle.obj absent.png -o camera.json", "absent.png"),
    "references: missing folder": ("references absent named -o people --names {shape}_{artist}", "absent"),
    "register: missing scan": ("register absent.jpg -o out.png --size 64", "absent.jpg"),
    "bench: missing mesh": ("bench absent.obj -o report", "absent.obj"),
    "demo: somebody else's folder": ("demo .", "."),
}


def test_every_command_meets_bad_input() -> None:
    assert {case.partition(":")[0] for case in BAD} >= set(CALLED)


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


PROGRAM = """
import sys
from ncmodel.cli.main import main
status = main(sys.argv[1:])
print(status, *sorted(name for name in sys.modules if name.split(".")[0] in ("ncmodel", "dataset_tools", "eval")))
"""


def test_a_drawing_loads_no_module_of_another_command(files: Path) -> None:
    line = [sys.executable, "-c", PROGRAM, "draw", str(files / "triangle.obj"), "-o", str(files / "out.svg")]
    status, *loaded = subprocess.run(line, capture_output=True, text=True, check=True).stdout.split()
    assert status == "0"
    assert {name for name in loaded if name.startswith("ncmodel.cli.")} == {
        "ncmodel.cli.common",
        "ncmodel.cli.draw",
        "ncmodel.cli.draw_job",
        "ncmodel.cli.draw_options",
        "ncmodel.cli.limited",
        "ncmodel.cli.provenance",
        "ncmodel.cli.main",
    }
    assert {name.split(".")[0] for name in loaded} == {"ncmodel"}


@pytest.fixture
def another_distribution(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An installed package with commands of its own, one of which has the name of ours."""
    home = tmp_path / "site"
    (home / "plotting_tools-1.0.dist-info").mkdir(parents=True)
    (home / "plotting_tools-1.0.dist-info" / "METADATA").write_text("Name: plotting-tools\nVersion: 1.0\n")
    (home / "plotting_tools-1.0.dist-info" / "entry_points.txt").write_text(
        "[ncontours.commands]\n"
        "plot = plotting_tools:plot\n"
        "draw = plotting_tools:plot\n"
        "pens = plotting_tools:pens\n"
        "number = plotting_tools:NUMBER\n"
        "absent = plotting_tools_elsewhere:plot\n"
        "unnamed = plotting_tools:no_such_function\n"
        "broken = plotting_tools_broken:plot\n"
    )
    (home / "plotting_tools.py").write_text(
        'def plot(pens: int = 1) -> None:\n    """Plot with pens."""\n    print(f"plotted with {pens} pens")\n\n'
        "import typer\n\nNUMBER = 3\npens = typer.Typer(help='Pens of all widths.')\n\n"
        "@pens.command()\ndef buy(count: int) -> None:\n    print(f'bought {count} pens')\n"
    )
    (home / "plotting_tools_broken.py").write_text("raise RuntimeError('out of\\nink')\n")
    monkeypatch.syspath_prepend(str(home))
    return home


@pytest.mark.usefixtures("another_distribution")
class TestOtherDistributions:
    """Commands of packages that aren't ours."""

    def test_their_commands_are_found_and_called(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["plot", "--pens", "3"]) == 0
        assert capsys.readouterr().out == "plotted with 3 pens\n"
        assert main(["--help"]) == 0
        assert "Plot with pens." in capsys.readouterr().out

    def test_their_groups_are_found_and_called(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["pens", "buy", "3"]) == 0
        assert capsys.readouterr().out == "bought 3 pens\n"
        assert main(["--help"]) == 0
        assert "Pens of all widths." in capsys.readouterr().out

    @pytest.mark.parametrize("place", [0, 1000], ids=["before ours", "behind ours"])
    def test_ours_cannot_be_replaced(
        self, place: int, files: Path, another_distribution: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        path = [part for part in sys.path if part != str(another_distribution)]
        path.insert(place, str(another_distribution))
        monkeypatch.setattr(sys, "path", path)
        assert main(["draw", str(files / "triangle.obj"), "-o", str(files / "out.svg")]) == 0
        assert (files / "out.svg").exists()

    @pytest.mark.parametrize(
        ("name", "reason"),
        [
            ("absent", "absent: can't be loaded from plotting_tools_elsewhere:plot (ModuleNotFoundError: "),
            ("unnamed", "unnamed: can't be loaded from plotting_tools:no_such_function (AttributeError: "),
            ("number", "number: can't be loaded from plotting_tools:NUMBER (TypeError: "),
            ("broken", "broken: can't be loaded from plotting_tools_broken:plot (RuntimeError: out of ink)"),
        ],
    )
    def test_one_that_cannot_be_loaded_is_one_line_and_harms_no_other(
        self, name: str, reason: str, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert reason in complaint(capsys, name)
        assert main(["--help"]) == 0
        out, err = capsys.readouterr()
        assert name in out
        assert "Draw the lines of shapes." in out
        assert err == ""
        assert main(["plot"]) == 0
