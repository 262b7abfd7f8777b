"""`ncontours import-weights` and `ncontours export-onnx`: networks that come from, or go to, other programs."""

from pathlib import Path
from typing import Annotated

import typer

from ncmodel.cli.common import emit


def import_weights(
    output: Annotated[Path, typer.Option("--output", "-o", help="Checkpoint to write.")],
    ranker: Annotated[Path | None, typer.Option(help="The ranking module: neural_ranking_module.pth.")] = None,
    translator: Annotated[Path | None, typer.Option(help="The image branch: image_translation_branch.pth.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print what was imported as JSON.")] = False,
) -> None:
    """Turn the published code's weights, both or either, into a checkpoint for draw and score."""
    from ncmodel.nets.checkpoints import save_checkpoint
    from ncmodel.published.weights import import_weights as imported

    checkpoint = imported(ranker, translator)
    save_checkpoint(output, checkpoint)
    parameters = {name: sum(p.numel() for p in net.parameters()) for name, net in checkpoint.networks.items()}
    counts = ", ".join(f"{name} ({count:,} parameters)" for name, count in parameters.items())
    record = {"checkpoint": str(output), "parameters": parameters, **checkpoint.training}
    emit(record, as_json, f"{counts} in {output}")


def export_onnx(
    model: Annotated[str, typer.Argument(metavar="MODEL", help="Checkpoint, or default: the one that ships.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for ranker.onnx and translator.onnx.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print files and the maps they read as JSON.")] = False,
) -> None:
    """Write a model's networks as ONNX files."""
    from ncmodel.nets.checkpoints import load_checkpoint
    from ncmodel.nets.onnx_export import export_onnx as export
    from ncmodel.nets.shipped import checkpoint_path

    checkpoint = load_checkpoint(checkpoint_path(model))
    files = {name: str(path) for name, path in export(checkpoint, output).items()}
    maps = list(checkpoint.preset.inputs)
    emit({"files": files, "maps": maps}, as_json, "\n".join([*files.values(), f"maps: {', '.join(maps)}"]))
