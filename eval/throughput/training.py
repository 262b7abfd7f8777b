"""Views and pairs a second, and memory, of training steps."""

import resource
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from torch import nn

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.pairs import Pair
from ncmodel.nets.blocks import WIDE, initialise, threads_for
from ncmodel.nets.presets import PRESETS, Preset
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.translation import TranslationBranch
from ncmodel.training.batches import PairPart, ViewPart
from ncmodel.training.dataset import ViewImages
from ncmodel.training.loader import Loader
from ncmodel.training.loop import Means, Trainer
from ncmodel.training.objectives import FinetuneObjective, Objective, RankerObjective, TranslatorObjective

WARM_UP = 2
"""Steps before the clock starts: kernels are chosen, workers start."""

GIB = float(1 << 30)


@dataclass(frozen=True)
class Setup:
    """What is measured.

    Attributes:
        preset: Name of the preset.
        stage: "ranker", "translator" or "finetune".
        bfloat16: Whether convolutions compute in it.
        workers: Processes that decode pictures ahead.
        batch: Pairs, or for the translator views, a step; the preset's by default.
    """

    preset: str
    stage: str
    bfloat16: bool
    workers: int
    batch: int | None = None


@dataclass(frozen=True)
class Speed:
    """What was measured of a setup.

    Attributes:
        setup: The setup.
        batch: Pairs or views a step.
        steps: Steps that were timed; 0 if it couldn't be.
        seconds: A step, the mean.
        views: Views a second.
        pairs: Pairs a second; for the translator, views.
        memory: GiB, at the most: of the GPU; on a CPU of the whole process so far.
        parameters: Numbers that are trained.
        failure: Why it couldn't be measured.
    """

    setup: Setup
    batch: int
    steps: int = 0
    seconds: float = 0.0
    views: float = 0.0
    pairs: float = 0.0
    memory: float = 0.0
    parameters: int = 0
    failure: str = ""


def measure_speed(setup: Setup, data: DataFolder, pairs: Sequence[Pair], device: torch.device, seconds: float) -> Speed:
    """Take steps for so long (at least one after the warm-up), every picture decoded anew.

    Args:
        setup: What is measured.
        data: Where the views are.
        pairs: Among their drawings.
        device: Where to compute.
        seconds: For all, the warm-up included; longer if a step is.
    """
    preset = _preset(setup)
    batch = preset.rates(setup.stage).batch
    width = WIDE if setup.stage != "ranker" else preset.ranking.width
    # A cache that holds nothing: as in a data set much larger than the memory.
    images = ViewImages(data, (preset.translation.size, preset.ranking.size), cache_bytes=0, inputs=preset.inputs)
    try:
        with threads_for(width), Loader(images, setup.workers) as loader:
            return _timed(setup, _objective(setup.stage, preset, images, pairs, device), loader, device, seconds)
    except (RuntimeError, OSError) as error:  # out of memory, mostly; the other setups are measured all the same
        return Speed(setup, batch, failure=" ".join(str(error).split())[:80] or type(error).__name__)
    finally:
        if device.type == "cuda":
            torch.cuda.empty_cache()
            torch.cuda.reset_peak_memory_stats(device)


def _preset(setup: Setup) -> Preset:
    preset = PRESETS[setup.preset]
    if setup.batch is None:
        return preset
    changed: dict[str, Any] = {setup.stage: replace(preset.rates(setup.stage), batch=setup.batch)}
    return replace(preset, **changed)


def _objective(
    stage: str, preset: Preset, images: ViewImages, pairs: Sequence[Pair], device: torch.device
) -> Objective:
    """The stage, with networks as they are before the first step."""
    ranker, translator = (
        RankingModule(preset.ranking, preset.inputs),
        TranslationBranch(preset.translation, preset.inputs),
    )
    for network in (ranker, translator):
        initialise(network, torch.Generator().manual_seed(0))
    if stage == "ranker":
        return RankerObjective(preset, ranker.to(device), images, pairs)
    if stage == "translator":
        return TranslatorObjective(preset, translator.to(device), images, pairs)
    return FinetuneObjective(preset, ranker.to(device), translator.to(device), images, pairs)


def _timed(setup: Setup, objective: Objective, loader: Loader, device: torch.device, seconds: float) -> Speed:
    begin = time.monotonic()
    trainer = Trainer(objective, Means(setup.workers, bfloat16=setup.bfloat16))
    trainer.learn()
    taken: list[float] = []
    views = pairs = 0
    for number, (step, loaded) in enumerate(_endless(objective, loader)):
        before = time.monotonic()
        trainer.step([1.0], iter([loaded]))  # it ends with a number on the CPU, which waits for the GPU
        after = time.monotonic()
        if number < WARM_UP and after - begin < seconds / 2:
            last = after
            continue
        # From the end of the step before to this one's: what waiting for pictures costs is in it.
        taken.append(after - (last if number else before))
        last = after
        views += len({pair.item for pair in step.pairs} if isinstance(step, PairPart) else step.views)
        pairs += len(step)
        if after - begin > seconds:
            break
    total = sum(taken)
    return Speed(
        setup,
        batch=round(pairs / len(taken)),
        steps=len(taken),
        seconds=total / len(taken),
        views=views / total,
        pairs=pairs / total,
        memory=_peak(device),
        parameters=_count(trainer.networks),
    )


def _endless(objective: Objective, loader: Loader) -> Iterator[tuple[PairPart | ViewPart, Any]]:
    """Steps with their pictures, pass after pass of a great many, so that workers needn't stop in between."""
    rng = np.random.default_rng(0)
    steps: list[Any] = [step for _ in range(1000) for step in objective.steps(rng)]
    yield from zip(steps, loader.load(steps), strict=True)


def _peak(device: torch.device) -> float:
    if device.type == "cuda":
        return torch.cuda.max_memory_allocated(device) / GIB
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / GIB


def _count(networks: nn.Module) -> int:
    return sum(parameter.numel() for parameter in networks.parameters())
