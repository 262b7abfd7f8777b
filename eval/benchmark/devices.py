"""The paper's ranking module on another device beside the CPU: `python -m eval.benchmark.devices -o devices.json`.

On random weights and a view of random strokes, so that nothing has to be at hand: what a device computes and how fast
doesn't depend on what the weights have learned.
"""

import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import torch
import typer

from ncmodel.files import write_bytes
from ncmodel.model.maps import LineMaps
from ncmodel.model.predictor import Model
from ncmodel.model.score import DrawingScore
from ncmodel.model.threshold_search import LARGE_BUDGETS
from ncmodel.nets.blocks import initialise
from ncmodel.nets.checkpoints import Checkpoint
from ncmodel.nets.devices import is_fast_in_bfloat16, prepared
from ncmodel.nets.presets import MAPS, PRESETS, RankingDims
from ncmodel.nets.ranking import RankingModule
from ncmodel.types import Image

SIDE = 768
"""Of the view, pixels."""

SEED = 0


@dataclass(frozen=True)
class DeviceRow:
    """What a device does.

    Attributes:
        device: Its name.
        bfloat16: Whether rough numbers are bfloat16.
        score: Of one drawing, exactly.
        gradient: (4,) of that in t.
        rough_score: The same score in rough numbers.
        score_seconds: A rough score takes.
        gradient_seconds: A rough score with its gradient takes.
        thresholds: (4,) that the search finds.
        search_score: Of these.
        evaluations: Of the search.
        search_seconds: It takes.
        peak_megabytes: Of the device's own memory meanwhile; 0 on a CPU.
    """

    device: str
    bfloat16: bool
    score: float
    gradient: tuple[float, ...]
    rough_score: float
    score_seconds: float
    gradient_seconds: float
    thresholds: tuple[float, ...] = ()
    search_score: float = 0.0
    evaluations: int = 0
    search_seconds: float = 0.0
    peak_megabytes: float = 0.0


@dataclass(frozen=True)
class Comparison:
    """A device beside the CPU.

    Attributes:
        cpu: The CPU.
        other: The device.
        score_difference: Of one drawing's exact score, relative.
        gradient_difference: Of its gradient, relative to the largest part.
        search_difference: The score of what the device's search found less that of the CPU's, both by the CPU.
        ink_difference: Between these two drawings, as a share of the ink.
    """

    cpu: DeviceRow
    other: DeviceRow
    score_difference: float
    gradient_difference: float
    search_difference: float
    ink_difference: float


def random_view() -> tuple[Image, LineMaps]:
    """(7, H, W) maps of a ball, and random strokes on it."""
    rng = np.random.default_rng(SEED)
    rows, columns = np.mgrid[:SIDE, :SIDE] / SIDE - 0.5
    reach = np.hypot(rows, columns) / 0.44
    cosine = np.sqrt(np.clip(1 - reach**2, 0, 1))
    waves = [np.sin(40 * rng.normal() * rows + 40 * rng.normal() * columns + rng.uniform(0, 6)) for _ in range(9)]
    shades = [cosine * (1 + 0.1 * wave / (level + 1)) for level, wave in enumerate(waves[: len(MAPS) - 1])]
    seen = np.where(reach < 1, np.clip([0.5 + 0.3 * reach, *shades], 0, 1), 1.0).astype(np.float32)
    strokes = [(np.abs(wave) < 0.06) & (reach < 1) for wave in waves[4:8]]
    lines = np.array(strokes, dtype=np.float32)
    features = (lines * rng.gamma(2.0, 0.5, lines.shape)).astype(np.float32)
    contours = (np.abs(reach - 1) < 0.01).astype(np.float32)
    return seen, LineMaps(lines, features, contours, np.zeros_like(contours), np.ones(4))


def random_model(dims: RankingDims, device: str) -> Model:
    """A ranking module with random weights, the same on all devices."""
    ranker = RankingModule(dims)
    initialise(ranker, torch.Generator().manual_seed(SEED))
    for norm in (module for module in ranker.modules() if isinstance(module, torch.nn.BatchNorm2d)):
        torch.nn.init.ones_(norm.weight)  # else every residual block is the identity
    return Model(Checkpoint(replace(PRESETS["paper"], ranking=dims), ranker=ranker), device)


def measure_device(model: Model, view: tuple[Image, LineMaps], preset: str) -> DeviceRow:
    """Score, differentiate and search on the model's device."""
    ranker, device, t = model.checkpoint.ranker, model.device, np.array([0.3, 0.5, 0.8, 0.2])
    assert ranker is not None
    scored = partial(DrawingScore, maps=view[0], lines=view[1])
    score, gradient = scored(ranker).slope(t, False)
    quick = scored(prepared(ranker), rough=True)
    on_gpu = device.type == "cuda"
    row = DeviceRow(
        device=torch.cuda.get_device_name(device) if on_gpu else f"{device.type}, {torch.get_num_threads()} threads",
        bfloat16=is_fast_in_bfloat16(device),
        score=score,
        gradient=tuple(gradient.tolist()),
        rough_score=float(quick.scores(t[None], False)[0]),
        score_seconds=_seconds(lambda: quick.scores(t[None], False)),
        gradient_seconds=_seconds(lambda: quick.slope(t, False)),
    )
    if on_gpu:
        torch.cuda.reset_peak_memory_stats(device)
    begin = time.perf_counter()
    optimum = model.search(scored, LARGE_BUDGETS[preset])
    seconds = time.perf_counter() - begin
    peak = torch.cuda.max_memory_allocated(device) / 1e6 if on_gpu else 0.0
    return replace(
        row,
        thresholds=optimum.thresholds,
        search_score=optimum.score,
        evaluations=optimum.evaluations,
        search_seconds=seconds,
        peak_megabytes=peak,
    )


def compare(device: str, dims: RankingDims = PRESETS["paper"].ranking, preset: str = "balanced") -> Comparison:
    """A device beside the CPU.

    Raises:
        UsageError: This machine has no such device.
    """
    view = random_view()
    models = [random_model(dims, place) for place in ("cpu", device)]
    cpu, other = (measure_device(model, view, preset) for model in models)
    on_cpu = models[0].checkpoint.ranker
    assert on_cpu is not None
    scored = DrawingScore(on_cpu, *view)
    found = np.array([cpu.thresholds, other.thresholds])
    scores, drawn = scored.scores(found, False), scored.drawings(torch.from_numpy(found).float(), False)
    apart = np.abs(np.subtract(cpu.gradient, other.gradient)).max() / np.abs(cpu.gradient).max()
    return Comparison(
        cpu=cpu,
        other=other,
        score_difference=abs(other.score - cpu.score) / max(abs(cpu.score), 1e-12),
        gradient_difference=float(apart),
        search_difference=float(scores[1] - scores[0]),
        ink_difference=float((drawn[0] - drawn[1]).abs().sum() / drawn[0].sum()),
    )


def _seconds(work: Callable[[], object]) -> float:
    """Of the second run, on the clock; results come back from the device, so it has ended."""
    work()
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def main(
    output: Annotated[Path, typer.Option("-o", "--output", help="JSON file to write.")],
    device: Annotated[str, typer.Option(help="What to hold against the CPU.")] = "cuda",
    preset: Annotated[Literal["draft", "balanced", "accurate"], typer.Option(help="Of the search.")] = "balanced",
) -> None:
    """Write and print the comparison."""
    text = json.dumps(asdict(compare(device, preset=preset)), indent=1)
    write_bytes(output, text.encode())
    typer.echo(text)


if __name__ == "__main__":
    typer.run(main)
