"""A small data folder whose shapes can be drawn, votes on them, and a model trained on these."""

import json
from pathlib import Path

from dataset_tools.build.runners import HereRunner
from eval.comparison.bench import Options, compare_methods
from eval.comparison.report import Outcome
from ncmodel.data.data_folder import DataFolder
from tests.helpers import builds, micro_training

HELD_OUT, TRAINED_ON = "odd_bumpy", "ball"
LEVELS = 3
"""Thresholds that baselines are tuned through."""


def make_folder(root: Path) -> Path:
    """`root`/data with two views each of a shape to train on and one held out, `root`/pairs.jsonl, `root`/model."""
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
    for path in (root / "pairs.jsonl", root / "data" / "pairs.jsonl"):
        path.write_text(text, encoding="utf-8")
    micro_training.run(root / "data", root / "model.safetensors", epochs=1)
    return root


def compare(root: Path, out: Path, **options: object) -> Outcome:
    """Compare in this process, with what `make_folder` made."""
    chosen = {"models": [root / "model.safetensors"], "levels": LEVELS, "preset": "draft", **options}
    return compare_methods(root / "data", root / "pairs.jsonl", out, Options(**chosen), HereRunner())  # type: ignore[arg-type]
