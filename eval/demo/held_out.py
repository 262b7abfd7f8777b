"""The demo's held-out views: every method's drawings, the simulated artists' drawings, and how pairs are scored."""

import json
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from dataset_tools.simulation.artists import ArtistDrawings, crowd_artists
from eval.baselines import canny, grid, rtsc
from eval.measures.evaluation import Settings, Target
from ncmodel.cli.common import progress
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.data.pairs import read_pairs, write_pairs
from ncmodel.drawing.plan import Plan
from ncmodel.errors import InputError
from ncmodel.files import write_text
from ncmodel.images import from_ink, write_png
from ncmodel.model.predictor import Model, Variant, load_model
from ncmodel.scene.view import View
from ncmodel.types import FILTERED_FAMILIES, Image

VARIANTS: dict[str, Variant] = {"NC-geometry": "geometry", "NC-image": "image", "NCs": "full"}
"""The paper's names -> the model's."""

TUNING_VIEWS = 12
"""Training views that baselines' parameters are tuned on."""
GRID_LEVELS = 21
"""Thresholds tried per kind of line."""

VALIDATION_SHARE = 8
"""Of the shapes that may be trained on, every so many-th watches over training instead."""


def split_for_training(pairs: Path, held_out: Sequence[str], output: Path) -> None:
    """Write the pairs that training may see: none of held-out shapes, and a validation split of its own.

    The choice of the best epoch looks at validation pairs, so these can't be the ones that the result is measured on.
    """
    kept = [pair for pair in read_pairs(pairs) if pair.item.shape not in held_out]
    shapes = sorted({pair.item.shape for pair in kept})
    watching = set(shapes[VALIDATION_SHARE // 2 :: VALIDATION_SHARE])
    write_pairs(
        output, (replace(pair, split="validation" if pair.item.shape in watching else "train") for pair in kept)
    )


def draw_held_out(out: Path, held_out: Sequence[str], effort: str) -> None:
    """Draw the held-out views by every method, beside the simulated artists' drawings, under `out`/held-out."""
    data, folder = DataFolder(out / "data"), out / "held-out"
    items = data.items()
    artists = ArtistDrawings(data, crowd_artists())
    mine = [item for item in items if item.shape in held_out]
    if not mine:
        raise InputError(data.root, "no view of a held-out shape", f"views of {', '.join(held_out)}")
    canny_settings, tuned = _tune([item for item in items if item.shape not in held_out], artists)
    model = load_model(out / "model.safetensors")
    chosen: dict[str, Any] = {}
    with progress("Held-out views", len(mine)) as advance:
        for item in mine:
            view = data.open_view(item)
            for method, plan in {**rtsc.METHODS, **tuned}.items():
                _write(folder, method, item, rtsc.draw(view, plan))
            _write(folder, "Canny", item, canny.draw(view, canny_settings))
            _write(folder, "silhouettes", item, view.buffers.hit.astype(np.float32))
            for number, ink in enumerate(artists.inks(item)):
                _write(folder, f"references/{item.name}", number, ink)
            chosen[item.name] = _draw_variants(model, view, item, folder, effort)
            advance(item.name)
    pairs = _score_pairs(model, data, out / "pairs.jsonl", set(held_out))
    thresholds = {method: plan.filtered for method, plan in tuned.items()}
    record = {"views": chosen, "pairs": pairs, "tuned": thresholds}
    write_text(folder / "model.json", json.dumps(record, indent=1) + "\n")


def _draw_variants(model: Model, view: View, item: Item, folder: Path, effort: str) -> dict[str, Any]:
    """The model's three drawings of a view; returns what the full model chose, and in how many seconds."""
    record: dict[str, Any] = {}
    for method, variant in VARIANTS.items():
        begin = time.perf_counter()
        plan = model.choose(view, variant, effort)
        _write(folder, method, item, rtsc.draw(view, plan))
        if plan.score is not None:
            record = {
                "thresholds": {family.value: plan.thresholds.value(family) for family in FILTERED_FAMILIES},
                "score": plan.score,
                "evaluations": plan.evaluations,
                "seconds": time.perf_counter() - begin,
            }
    return record


def _score_pairs(model: Model, data: DataFolder, pairs: Path, held_out: set[str]) -> list[dict[str, Any]]:
    """The ranking module's scores of both drawings of every held-out pair."""
    import torch

    from ncmodel.training.batches import load_pairs
    from ncmodel.training.dataset import ViewImages
    from ncmodel.training.objectives import score_batch

    ranker = model.checkpoint.ranker
    if ranker is None:
        raise InputError("model.safetensors", "no ranking module", "a model trained in all stages")
    images = ViewImages(data, [ranker.dims.size])
    wanted = [pair for pair in read_pairs(pairs) if pair.item.shape in held_out]
    records = []
    for item in sorted({pair.item for pair in wanted}):
        mine = [pair for pair in wanted if pair.item == item]
        loaded = load_pairs(images, mine, ranker.dims.size)
        with torch.inference_mode():
            scores = score_batch(ranker, loaded.batch).tolist()
        records += [
            {"shape": item.shape, "view": item.view, "better_score": scores[better], "worse_score": scores[worse]}
            for better, worse in zip(loaded.better.tolist(), loaded.worse.tolist(), strict=True)
        ]
    return records


def _write(folder: Path, group: str, item: Item | int, ink: Image) -> None:
    path = folder / group / f"{item.name if isinstance(item, Item) else item}.png"
    path.parent.mkdir(parents=True, exist_ok=True)
    write_png(path, from_ink(ink))


def _tune(items: Sequence[Item], artists: ArtistDrawings) -> tuple[canny.CannySettings, dict[str, Plan]]:
    """Canny's parameters, and the appendix's four methods by name, both with the least Chamfer distance."""
    chosen = items[:: max(1, len(items) // TUNING_VIEWS)][:TUNING_VIEWS]
    examples = []
    with progress("Baselines' parameters: training views", len(chosen)) as advance:
        for item in chosen:
            view = artists.data.open_view(item)
            references = {str(number): ink for number, ink in enumerate(artists.inks(item)[:1])}
            examples.append((view, Target.of(item.name, references, Settings(), view.buffers.hit)))
            advance(item.name)
    return canny.search(examples), grid.search(examples, GRID_LEVELS).methods
