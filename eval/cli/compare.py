"""`ncontours compare`: all methods on the same views, with what could have been chosen."""

from pathlib import Path
from typing import Annotated

import typer

from ncmodel.cli.common import emit, progress
from ncmodel.errors import BatchError

DataDir = Annotated[Path, typer.Argument(help="Folder that `dataset build` wrote.")]
Pairs = Annotated[Path, typer.Argument(help="Ranking pairs: which shapes are trained on, and what voters chose.")]
Output = Annotated[Path, typer.Option("--output", "-o", help="Folder for the report; started again, it goes on.")]
References = Annotated[
    str, typer.Option(help="Folder of references, SHAPE_VIEW.png or SHAPE_VIEW/*.png; or simulated (artists).")
]
Models = Annotated[
    list[Path] | None,
    typer.Option("--model", help="Checkpoint, or default; several are told apart by name."),
]
TreeFile = Annotated[Path | None, typer.Option("--tree", help="What `decision-tree` trained: a row more.")]
Views = Annotated[
    str, typer.Option(help="Whose views: held-out (shapes that aren't trained on), validation, train or all.")
]
Shapes = Annotated[str | None, typer.Option(help="Of these only the views of some shapes, a,b,c. (default all)")]
Baseline = Annotated[str, typer.Option(help="Row that the others are compared with.")]
Preset = Annotated[str, typer.Option(help="Of the models: draft, balanced or accurate.")]
Device = Annotated[str, typer.Option(help="Where the models compute: cpu, cuda, ...")]
TuningViews = Annotated[int | None, typer.Option(help="Tune baselines on at most so many training views (default all)")]
TolerancePixels = Annotated[float, typer.Option(help="How far apart near pixels may be, in pictures 768 wide.")]
Whole = Annotated[bool, typer.Option("--keep-silhouettes", help="Count what is near the silhouettes too.")]
Workers = Annotated[int | None, typer.Option(help="Processes; 0: this one. (default one a core)")]
Seed = Annotated[int, typer.Option(help="Of the resampling.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print compare.json.")]


def compare(
    data_dir: DataDir,
    pairs: Pairs,
    output: Output,
    references: References = "simulated",
    models: Models = None,
    tree: TreeFile = None,
    views: Views = "held-out",
    shapes: Shapes = None,
    baseline: Baseline = "all-grid",
    preset: Preset = "balanced",
    device: Device = "cpu",
    tuning_views: TuningViews = None,
    tolerance_pixels: TolerancePixels = 5.0,
    keep_silhouettes: Whole = False,
    workers: Workers = None,
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Compare models, classic lines and the best possible choice, on views that have references."""
    from dataset_tools.build.runners import core_count, runner_for
    from eval.comparison.bench import Options, compare_methods
    from eval.measures.evaluation import Settings

    options = Options(
        models=models or (),
        tree=tree,
        references=references,
        views=views,
        shapes=shapes.split(",") if shapes else (),
        baseline=baseline,
        preset=preset,
        device=device,
        tuning_views=tuning_views,
        settings=Settings(tolerance_pixels),
        whole=keep_silhouettes,
        seed=seed,
    )
    with runner_for(core_count() if workers is None else workers) as runner:
        outcome = compare_methods(data_dir, pairs, output, options, runner, progress)
    record = outcome.write()
    emit(record, as_json, f"{outcome.to_text()}\n{output / 'report.html'}")
    if outcome.failed:
        raise BatchError(f"{len(outcome.failed)} views not measured: {'; '.join(outcome.failed)}")
