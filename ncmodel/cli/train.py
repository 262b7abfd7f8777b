"""`ncontours train`: a data folder and ranking pairs become a model."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ncmodel.cli.common import emit, option_names, progress
from ncmodel.errors import UsageError

if TYPE_CHECKING:
    from ncmodel.nets.presets import Preset

Data = Annotated[Path, typer.Argument(help="Data folder, as `ncontours dataset build` writes it.")]
Pairs = Annotated[Path, typer.Argument(help="Ranking pairs, as `ncontours crowd aggregate` writes them.")]
Output = Annotated[Path, typer.Option("--output", "-o", help="Checkpoint to write; an interrupted training goes on.")]
Stage = Annotated[str, typer.Option(help="ranker, translator, finetune, or all three.")]
PresetName = Annotated[str, typer.Option("--preset", help="Size of the networks: tiny, small or paper.")]
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
AsJson = Annotated[bool, typer.Option("--json", help="Print what was done as JSON.")]


def train(
    data: Data,
    pairs: Pairs,
    output: Output,
    stage: Stage = "all",
    preset: PresetName = "tiny",
    image_maps: ImageMaps = None,
    percentile: PercentileOf = None,
    epochs: Epochs = None,
    seconds: Seconds = None,
    seed: Seed = 0,
    restart: Restart = False,
    device: Device = "cpu",
    as_json: AsJson = False,
) -> None:
    """Train the ranking module and the image translation branch."""
    from ncmodel.model.calibration import calibrate_file
    from ncmodel.training.train import TrainOptions, run_training

    with option_names(stages="stage"):
        options = TrainOptions(None if stage == "all" else (stage,), epochs, seconds, seed, restart, device)
        chosen = _preset(preset, image_maps, percentile)
        report = run_training(data, pairs, output, chosen, options, progress).to_record()
    report["preference"] = calibrate_file(output, data, pairs)
    emit(report, as_json, _summary(report))


def _preset(name: str, image_maps: str | None, percentile: str | None) -> "Preset":
    """The preset of that name, with other inputs or units if some are given."""
    from ncmodel.nets.presets import preset_named

    preset = preset_named(name)
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
