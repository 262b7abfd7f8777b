"""Measures training steps, and one drawing, on the machine at hand.

python -m eval.throughput -o REPORT --device cuda --workers 12 --seconds 300
"""

import itertools
import os
import platform
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import torch
import typer

from eval.throughput.drawing import Agreement, compare_drawings
from eval.throughput.growth import PROCESSES
from eval.throughput.pictures import write_views
from eval.throughput.report import Throughput, speed_rows
from eval.throughput.training import Setup, Speed, measure_speed
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.pairs import Pair
from ncmodel.nets.devices import device_named
from ncmodel.nets.presets import PRESETS

STAGES = ("ranker", "translator", "finetune")

DRAWING_SECONDS = 90.0
"""Kept for the drawing, whose kernels are compiled first."""


def main(
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for throughput.json, .md and .html.")],
    device: Annotated[str, typer.Option(help="Where to train: cpu, cuda.")] = "cpu",
    presets: Annotated[str, typer.Option(help="Of tiny,small,paper.")] = "paper,small,tiny",
    workers: Annotated[int, typer.Option(help="Processes that decode ahead, beside none.", min=1)] = 2,
    seconds: Annotated[float, typer.Option(help="For everything; a step that has begun is finished.")] = 300.0,
    views: Annotated[int, typer.Option(help="Made-up views.", min=10)] = 20,
    drawing: Annotated[bool, typer.Option(help="Compare a drawing on CPU and device.")] = True,
) -> None:
    """Measure training steps with and without bfloat16 and workers, and a drawing."""
    place, draws = device_named(device), drawing and device != "cpu"
    end = time.monotonic() + seconds - (DRAWING_SECONDS if draws else 0)
    asked = presets.split(",")
    setups = setups_of(asked, workers, several=place.type != "cpu")
    with tempfile.TemporaryDirectory() as folder:
        pairs = write_views(Path(folder), views)
        speeds, left_out = measure(setups, DataFolder(folder), pairs, place, end)
    found = Throughput(_machine(place), speeds, left_out, None, "" if draws else "it wasn't asked for, or of no device")
    found.write(output)
    if draws:
        drawn, reason = _draw(place)
        found = replace(found, drawing=drawn, no_drawing=reason)
        found.write(output)
    typer.echo((output / "throughput.md").read_text(encoding="utf-8"))


def setups_of(presets: Sequence[str], workers: int, several: bool) -> list[Setup]:
    """What to measure, what matters most first: the first preset as it is trained.

    Args:
        presets: Names.
        workers: Processes that decode ahead, beside none.
        several: Whether the device is one that several are taken of, and fast in bfloat16: a GPU.
    """
    ways = list(itertools.product((workers, 0), (several, not several)))
    first = [Setup(presets[0], stage, several, workers) for stage in STAGES]
    if several:  # what one of them looks at of a step
        first += [replace(s, batch=max(1, PRESETS[s.preset].rates(s.stage).batch // PROCESSES)) for s in first]
    rest = [Setup(preset, stage, rough, number) for number, rough in ways for preset in presets for stage in STAGES]
    return [*first, *(setup for setup in rest if setup not in first)]


def measure(
    setups: list[Setup], data: DataFolder, pairs: list[Pair], device: torch.device, end: float
) -> tuple[list[Speed], list[str]]:
    """Measure setups until the time is up, each for its share of what is left."""
    speeds: list[Speed] = []
    for number, setup in enumerate(setups):
        left = end - time.monotonic()
        if left <= 0:
            return speeds, [f"{s.preset} {s.stage}, {s.workers} workers" for s in setups[number:]]
        speeds.append(measure_speed(setup, data, pairs, device, left / (len(setups) - number)))
        typer.echo(" ".join(speed_rows(speeds)[-1]), err=True)
    return speeds, []


def _draw(device: torch.device) -> tuple[Agreement | None, str]:
    """The drawing's comparison, or why there is none."""
    try:
        return compare_drawings(device), ""
    except ImportError as error:
        return None, str(error)


def _machine(device: torch.device) -> dict[str, str]:
    name = torch.cuda.get_device_name(device) if device.type == "cuda" else platform.machine()
    return {
        "device": name,
        "processors": str(os.cpu_count()),
        "Python": platform.python_version(),
        "PyTorch": torch.__version__,
        "date": time.strftime("%Y-%m-%d"),
    }


if __name__ == "__main__":
    typer.run(main)
