"""`ncontours score`: how good drawings of a shape are, and how many people would prefer one to another."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ncmodel.cli.common import emit

if TYPE_CHECKING:
    from ncmodel.model.scoring import DrawingScores


def score(
    mesh: Annotated[Path, typer.Argument(metavar="MESH", help="Mesh file.")],
    drawings: Annotated[
        list[Path],
        typer.Argument(metavar="DRAWING", help="Pictures with dark lines on light paper, in the camera's frame."),
    ],
    camera: Annotated[Path, typer.Option(help="Camera file (JSON) that the drawings are seen through.")],
    model: Annotated[str, typer.Option(help="Checkpoint, or default: the one that ships.")] = "default",
    up: Annotated[str, typer.Option(help="The mesh file's upward axis, y or z.")] = "y",
    device: Annotated[str, typer.Option(help="Where the model computes: cpu, cuda, ...")] = "cpu",
    as_json: Annotated[bool, typer.Option("--json", help="Print scores and probabilities as JSON.")] = False,
) -> None:
    """Score drawings by a model's ranking module, and tell how many people prefer one to another."""
    from ncmodel.model.scoring import score_drawings

    found = score_drawings(mesh, _by_name(drawings), camera, model, up, device)
    if not found.calibrated:
        sys.stderr.write(f"note: {model} was trained without held-out votes; how many people prefer what is a guess\n")
    emit(found.to_record(), as_json, _table(found))


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
