"""Trainings that take moments."""

from pathlib import Path

from ncmodel.nets.presets import Preset, RankingDims, Rates, TranslationDims
from ncmodel.training.train import TrainOptions, TrainReport, run_training

MICRO = Preset(
    "micro",
    TranslationDims(size=32, width=2, levels=2, blocks=1),
    RankingDims(size=32, width=2, blocks=(1, 1)),
    ranker=Rates(1e-3, batch=16, epochs=3),
    translator=Rates(1e-3, batch=2, epochs=3),
    finetune=Rates(1e-4, batch=16, epochs=2),
)
"""Small enough to train in moments; what is tested with it doesn't depend on size."""


class Interrupted(Exception):
    """What tests break a training off with."""


def run(data: Path, out: Path, **options: object) -> TrainReport:
    """Train on a data folder's own pairs; options as `TrainOptions` has them."""
    return run_training(data, data / "pairs.jsonl", out, MICRO, TrainOptions(**options))  # type: ignore[arg-type]
