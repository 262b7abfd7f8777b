"""`ncontours decision-tree`: trains the decision tree of Cole et al. (2008), a row of `compare`."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from ncmodel.cli.common import emit, progress

DataDir = Annotated[Path, typer.Argument(help="Folder that `dataset build` wrote.")]
Pairs = Annotated[Path, typer.Argument(help="Ranking pairs: which shapes are trained on, and what voters chose.")]
Output = Annotated[Path, typer.Option("--output", "-o", help="File for the tree, JSON; `compare --tree` reads it.")]
Pixels = Annotated[int, typer.Option(help="Pixels to learn from, half of them with ink.")]
Workers = Annotated[int | None, typer.Option(help="Processes; 0: this one. (default one a core)")]
Seed = Annotated[int, typer.Option(help="Of the choice of pixels.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print what it was trained on as JSON.")]


def decision_tree(
    data_dir: DataDir,
    pairs: Pairs,
    output: Output,
    pixels: Pixels = 40_000,
    workers: Workers = None,
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Train a decision tree on the drawings that voters chose: one of the methods that `compare` compares."""
    from dataset_tools.build.runners import core_count, runner_for
    from eval.comparison.tree_training import train_tree
    from ncmodel.errors import InputError

    if not output.absolute().parent.is_dir():
        raise InputError(output, "its folder doesn't exist", "a file in an existing folder")
    with runner_for(core_count() if workers is None else workers) as runner:
        tree = train_tree(data_dir, pairs, runner, pixels, seed, progress=progress)
    tree.save(output)
    record = {"tree": str(output), "rules": len(tree.rules), "ridges": asdict(tree.ridges), **tree.training}
    summary = f"{len(tree.rules)} leaves from {tree.training['pixels']} pixels of {tree.training['views']} views"
    emit(record, as_json, f"{summary}\n{output}")
