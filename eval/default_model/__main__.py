"""The one command that makes the model that ships.

python -m eval.default_model WORK_DIR MESH_DIR -o default.safetensors
"""

from pathlib import Path
from typing import Annotated

import typer

from ncmodel.cli.common import progress


def main(
    work: Annotated[Path, typer.Argument(help="Folder for what was measured, to go on with.")],
    meshes: Annotated[Path, typer.Argument(help="Real meshes; those whose names say so are trained on.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Checkpoint to write.")],
    shapes: Annotated[int, typer.Option(help="Made shapes, two views each.", min=1)] = 230,
    real_views: Annotated[int, typer.Option(help="Views of each real mesh.", min=1)] = 8,
    questions: Annotated[int, typer.Option(help="Questions about each view.", min=1)] = 9,
    seed: Annotated[int, typer.Option(help="Of votes and training.", min=0)] = 0,
    workers: Annotated[int | None, typer.Option(help="Processes; 0: this one. (default one a core)")] = None,
) -> None:
    """Make shapes, measure their views, simulate votes, train the ranker on numbers."""
    from dataset_tools.build.runners import core_count, runner_for
    from dataset_tools.collection.families import split_of
    from dataset_tools.simulation.participants import Crowd
    from eval.default_model.training import simulated_pairs, train_statistics, training_shapes
    from eval.default_model.views import MeasuredView, ShapeTask, measure_all
    from ncmodel.mesh.load import SUFFIXES
    from ncmodel.nets.checkpoints import save_checkpoint
    from ncmodel.nets.presets import preset_named

    folder = work / "views"
    folder.mkdir(parents=True, exist_ok=True)
    real = [path for path in sorted(meshes.iterdir()) if path.suffix.lower() in SUFFIXES]
    tasks = [ShapeTask(str(path), real_views, str(folder)) for path in real if split_of(path.stem) == "training"]
    tasks += [ShapeTask(name, 2, str(folder)) for name in training_shapes(shapes)]
    with runner_for(core_count() if workers is None else workers) as runner:
        failed = measure_all(tasks, runner, progress)
    for shape, reason in failed.items():
        typer.echo(f"{shape}: {reason}", err=True)
    names = [item.name for task in tasks if task.shape not in failed for item in task.items]
    views = [MeasuredView.load(folder / f"{name}.npz") for name in names]
    pairs = simulated_pairs(views, questions, Crowd(), seed)
    preset = preset_named("small")
    checkpoint = train_statistics(views, pairs, preset, work / f"statistics-{seed}.state", seed, progress)
    save_checkpoint(output, checkpoint)
    typer.echo(f"{len(views)} views, {len(pairs)} pairs: {checkpoint.training['stages']['statistics']}")


if __name__ == "__main__":
    typer.run(main)
