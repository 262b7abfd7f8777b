"""`ncontours import-weights`: the published checkpoints as one of ours."""

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
