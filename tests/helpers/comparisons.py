"""A small data folder whose shapes can be drawn, votes on them, and a model trained on these."""

import json
from dataclasses import replace
from pathlib import Path

from dataset_tools.build.runners import HereRunner
from eval.comparison.bench import Options, compare_methods
from eval.comparison.report import Outcome
from ncmodel.data.data_folder import DataFolder
from ncmodel.nets.presets import StatisticsDims
from ncmodel.training.train import TrainOptions, run_training
from tests.helpers import builds, micro_training

HELD_OUT, TRAINED_ON = "odd_bumpy", "ball"
LEVELS = 3
"""Thresholds that baselines are tuned through."""


def make_folder(root: Path) -> Path:
    """`root`/data with two views each of a shape to train on and one held out, `root`/pairs.jsonl, and two models.

    `root`/model.safetensors counts ink and looks at pictures, `root`/pictures.safetensors looks at pictures alone.
    """
    builds.build(builds.make_meshes(root / "meshes"), root / "data")
    items = DataFolder(root / "data").items()
    assert {item.shape for item in items} == {HELD_OUT, TRAINED_ON}
    records = [
        {
            **item.record,
            "better": 2,
            "worse": worse,
            "votes_for": 3,
            "votes": 5,
            "split": "train" if item.shape == TRAINED_ON else "validation",
        }
        for item in items
        for worse in range(8)
        if worse != 2 and item.name != f"{HELD_OUT}_1"
    ]
    text = "".join(json.dumps(record) + "\n" for record in records)
    (root / "pairs.jsonl").write_text(text, encoding="utf-8")
    counting = replace(micro_training.MICRO, statistics=StatisticsDims())
    for name, preset in (("model", counting), ("pictures", micro_training.MICRO)):
        run_training(root / "data", root / "pairs.jsonl", root / f"{name}.safetensors", preset, TrainOptions(epochs=1))
    return root


def compare(root: Path, out: Path, **options: object) -> Outcome:
    """Compare in this process, with what `make_folder` made."""
    chosen = {"models": [root / "model.safetensors"], "levels": LEVELS, "preset": "draft", **options}
    return compare_methods(root / "data", root / "pairs.jsonl", out, Options(**chosen), HereRunner())  # type: ignore[arg-type]
