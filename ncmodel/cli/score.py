"""`ncontours score`: how good drawings of a shape are, and how many people would prefer one to another."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ncmodel.cli.common import emit
from ncmodel.cli.maps import alone
from ncmodel.errors import UsageError

if TYPE_CHECKING:
    from ncmodel.model.scoring import DrawingScores


def score(
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILES",
            help="MESH (not with --maps), then DRAWING..: pictures with dark lines on light paper, in one frame.",
        ),
    ],
    camera: Annotated[
        Path | None, typer.Option(help="Camera file (JSON) that the drawings are seen through; not with --maps.")
    ] = None,
    model: Annotated[str, typer.Option(help="Checkpoint, or default: the one that ships.")] = "default",
    maps: Annotated[
        Path | None, typer.Option(help="Folder in the published layout in place of the mesh and its camera.")
    ] = None,
    up: Annotated[str, typer.Option(help="The mesh file's upward axis, y or z.")] = "y",
    device: Annotated[str, typer.Option(help="Where the model computes: cpu, cuda, ...")] = "cpu",
    as_json: Annotated[bool, typer.Option("--json", help="Print scores and probabilities as JSON.")] = False,
) -> None:
    """Score drawings by a model's ranking module, and tell how many people prefer one to another."""
    found = _of_mesh(files, camera, model, up, device) if maps is None else _of_maps(maps, files, camera, model, device)
    if not found.calibrated:
        sys.stderr.write(f"note: {model} was trained without held-out votes; how many people prefer what is a guess\n")
    emit(found.to_record(), as_json, _table(found))


def _of_mesh(files: list[Path], camera: Path | None, model: str, up: str, device: str) -> "DrawingScores":
    from ncmodel.model.scoring import score_drawings

    if camera is None:
        raise UsageError("--camera: found none, expected a camera file, or --maps in place of mesh and camera")
    if len(files) < 2:
        raise UsageError(f"found {files[0]} alone, expected a mesh and drawings of it")
    return score_drawings(files[0], _by_name(files[1:]), camera, model, up, device)


def _of_maps(maps: Path, drawings: list[Path], camera: Path | None, model: str, device: str) -> "DrawingScores":
    from ncmodel.published.folder import read_maps
    from ncmodel.published.model import load_model
    from ncmodel.published.pictures import score_maps

    alone(maps, **{"--camera": camera})
    return score_maps(read_maps(maps), _by_name(drawings), load_model(model, device=device))


def _by_name(drawings: list[Path]) -> dict[str, Path]:
    """Drawings by their files' names, or by their paths where two have one name."""
    names = {path.stem: path for path in drawings}
    return names if len(names) == len(drawings) else {str(path): path for path in drawings}


def _table(found: "DrawingScores") -> str:
    """Scores, the best first, and the per cent of people who prefer each drawing to each other one."""
    from ncmodel.report.text import text_table

    names = sorted(found.scores, key=lambda name: -found.scores[name])
    rows = [["", "score", *(f"over {name}" if len(names) > 1 else "" for name in names)]]
    for name in names:
        shares = ["" if other == name else f"{100 * found.probability(name, other):.0f} %" for other in names]
        rows.append([name, f"{found.scores[name]:.3f}", *shares])
    return text_table(rows)
