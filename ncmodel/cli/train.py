"""`ncontours train`: a data folder and ranking pairs become a model."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ncmodel.cli.common import emit, option_names, progress, warn
from ncmodel.errors import UsageError

if TYPE_CHECKING:
    from ncmodel.nets.presets import Preset

Data = Annotated[Path, typer.Argument(help="Data folder, as `ncontours dataset build` writes it.")]
Pairs = Annotated[Path, typer.Argument(help="Ranking pairs, as `ncontours crowd aggregate` writes them.")]
Output = Annotated[Path, typer.Option("--output", "-o", help="Checkpoint to write; an interrupted training goes on.")]
Stage = Annotated[str, typer.Option(help="ranker, translator, finetune, all three, or regressor (a baseline).")]
PresetName = Annotated[str, typer.Option("--preset", help="Size of the networks: tiny, small or paper.")]
SettingsFile = Annotated[
    Path | None, typer.Option("--settings", help="TOML file with rates, batches, passes and variation of your own.")
]
AsPublished = Annotated[
    bool, typer.Option("--as-published", help="Leave out what the paper doesn't have: varied views, averaged weights.")
]
ImageMaps = Annotated[
    str | None,
    typer.Option(help="The image branch reads these of depth,shaded_0..5,suggestive,ridges,valleys,..."),
]
PercentileOf = Annotated[
    str | None, typer.Option("--percentile", help="Unit of thresholds: 90th percentile over a view, or the mesh.")
]
Epochs = Annotated[int | None, typer.Option(help="Passes over the data in each stage; the preset's by default.")]
Seconds = Annotated[float | None, typer.Option(help="Stop early after this long. Not reproducible.")]
Seed = Annotated[int, typer.Option(help="Of initial weights, order and variation.")]
Restart = Annotated[bool, typer.Option("--restart", help="Start over instead of going on with an earlier training.")]
Device = Annotated[str, typer.Option(help="Where to compute: cpu, cuda, ...")]
Workers = Annotated[int, typer.Option(help="Processes that read pictures ahead.")]
MicroBatch = Annotated[
    int | None, typer.Option(help="Look at most at so many pairs or views at a time; steps stay whole.")
]
PrecisionOf = Annotated[
    str | None, typer.Option("--precision", help="float32 or bfloat16. (default bfloat16 on GPUs fast in it)")
]
BatchNormBy = Annotated[
    str, typer.Option("--batch-norm", help="Statistics of steps in parts: own, synchronised or frozen.")
]
SaveEvery = Annotated[float, typer.Option(help="Seconds after which a state is written within a pass.")]
ObjectiveOf = Annotated[
    str | None,
    typer.Option("--objective", help="pix2pixhd, or your own loss: an entry point's name, or MODULE:CLASS."),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print what was done as JSON.")]


def train(
    data: Data,
    pairs: Pairs,
    output: Output,
    stage: Stage = "all",
    preset: PresetName = "tiny",
    as_published: AsPublished = False,
    settings: SettingsFile = None,
    image_maps: ImageMaps = None,
    percentile: PercentileOf = None,
    epochs: Epochs = None,
    seconds: Seconds = None,
    seed: Seed = 0,
    restart: Restart = False,
    device: Device = "cpu",
    workers: Workers = 0,
    micro_batch: MicroBatch = None,
    precision: PrecisionOf = None,
    batch_norm: BatchNormBy = "own",
    save_every: SaveEvery = 300.0,
    objective: ObjectiveOf = None,
    as_json: AsJson = False,
) -> None:
    """Train the ranking module and the image translation branch."""
    from ncmodel.model.calibration import calibrate_file
    from ncmodel.training.processes import leads
    from ncmodel.training.train import TrainOptions, run_training

    with option_names(stages="stage"):
        options = TrainOptions(
            None if stage == "all" else (stage,),
            epochs,
            seconds,
            seed,
            restart,
            device,
            workers,
            micro_batch,
            precision,  # type: ignore[arg-type]  # it checks
            batch_norm,  # type: ignore[arg-type]
            save_every,
            objective,
            curves=True,
        )
        chosen = _preset(preset, as_published, settings, image_maps, percentile)
        report = run_training(data, pairs, output, chosen, options, progress, warn).to_record()
    if not leads():
        return
    report["preference"] = calibrate_file(output, data, pairs)
    emit(report, as_json, _summary(report))


def _preset(
    name: str, published: bool, settings: Path | None, image_maps: str | None, percentile: str | None
) -> "Preset":
    """The preset of that name, with other settings, inputs or units if some are given."""
    from ncmodel.nets.preset_settings import as_published, with_settings
    from ncmodel.nets.presets import preset_named

    preset = as_published(preset_named(name)) if published else preset_named(name)
    preset = preset if settings is None else with_settings(preset, settings)
    try:
        if image_maps is not None:
            inputs = tuple(part.strip() for part in image_maps.split(","))
            preset = replace(preset, translation=replace(preset.translation, inputs=inputs))
        return preset if percentile is None else replace(preset, percentile=percentile)  # type: ignore[arg-type]
    except ValueError as error:
        raise UsageError(str(error)) from error


def _summary(report: dict[str, Any]) -> str:
    """A line a stage."""
    lines = [
        f"{stage['stage']}: kept pass {stage['best_epoch']} of {stage['epochs']}"
        + "".join(f", {name.replace('_', ' ')} {value:.4f}" for name, value in stage["validation"].items())
        + f" ({stage['seconds']:.0f} s)"
        for stage in report["stages"]
    ]
    if (known := report["preference"]) is not None:
        error = f"expected calibration error {100 * known['error']:.1f} % on {known['pairs']} held-out pairs"
        lines.append(f"scores as shares of people: temperature {known['temperature']:.3g}, {error}")
    return "\n".join([*lines, report["checkpoint"]])
