"""The demo's held-out views: every method's drawings, the simulated artists' drawings, and how pairs are scored."""

import json
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dataset_tools.artist import ArtistDrawings, crowd_artists, open_view
from dataset_tools.items import Item, list_items
from eval.baselines import canny, rtsc
from eval.evaluation import Settings, Target
from ncmodel.cli.common import progress
from ncmodel.errors import InputError
from ncmodel.files import write_text
from ncmodel.pictures import from_ink, write_png
from ncmodel.types import Image

TUNING_VIEWS = 12
"""Training views that Canny's parameters are tuned on."""

VALIDATION_SHARE = 8
"""Of the shapes that may be trained on, every so many-th watches over training instead."""


def split_for_training(pairs: Path, held_out: Sequence[str], output: Path) -> None:
    """Write the pairs that training may see: none of held-out shapes, and a validation split of its own.

    The choice of the best epoch looks at validation pairs, so these can't be the ones that the result is measured on.
    """
    records = [json.loads(line) for line in pairs.read_text(encoding="utf-8").splitlines()]
    kept = [record for record in records if record["shape"] not in held_out]
    shapes = sorted({record["shape"] for record in kept})
    watching = set(shapes[VALIDATION_SHARE // 2 :: VALIDATION_SHARE])
    for record in kept:
        record["split"] = "validation" if record["shape"] in watching else "train"
    write_text(output, "".join(json.dumps(record) + "\n" for record in kept))


def draw_held_out(out: Path, held_out: Sequence[str], preset: str, seed: int) -> None:
    """Draw the held-out views by every method, beside the simulated artists' drawings, under `out`/held-out."""
    from ncmodel.model import load_model

    data, folder = out / "data", out / "held-out"
    items = list_items(data)
    artists = ArtistDrawings(data, crowd_artists(seed=seed))
    canny_settings = _tune_canny([item for item in items if item.shape not in held_out], artists)
    model = load_model(out / "model.safetensors")
    views: dict[str, Any] = {}
    mine = [item for item in items if item.shape in held_out]
    if not mine:
        raise InputError(data, "no view of a held-out shape", f"views of {', '.join(held_out)}")
    with progress("Held-out views", len(mine)) as advance:
        for item in mine:
            view = open_view(data, item)
            for method, settings in rtsc.METHODS.items():
                _write(folder, method, item, rtsc.draw(view, settings))
            _write(folder, "Canny", item, canny.draw(view, canny_settings))
            begin = time.perf_counter()
            result = model.draw(view, effort=preset, seed=seed)
            seconds = time.perf_counter() - begin
            _write(folder, "NCs", item, result.ink)
            _write(folder, "NC-image", item, model.image_drawing(view))
            geometry = model.draw(view, effort=preset, seed=seed, image_branch=False)
            _write(folder, "NC-geometry", item, geometry.ink)
            _write(folder, "silhouettes", item, view.buffers.hit.astype(np.float32))
            for number, ink in enumerate(artists.inks(item)):
                _write(folder, f"references/{item.name}", number, ink)
            views[item.name] = {**result.to_record(), "seconds": seconds}
            advance(item.name)
    pairs = _score_pairs(model, data, out / "pairs.jsonl", set(held_out))
    write_text(folder / "model.json", json.dumps({"views": views, "pairs": pairs}, indent=1) + "\n")


def _write(folder: Path, group: str, item: Item | int, ink: Image) -> None:
    path = folder / group / f"{item.name if isinstance(item, Item) else item}.png"
    path.parent.mkdir(parents=True, exist_ok=True)
    write_png(path, from_ink(ink))


def _tune_canny(items: Sequence[Item], artists: ArtistDrawings) -> canny.CannySettings:
    chosen = items[:: max(1, len(items) // TUNING_VIEWS)][:TUNING_VIEWS]
    examples = []
    with progress("Canny's parameters: training views", len(chosen)) as advance:
        for item in chosen:
            view = open_view(artists.data_dir, item)
            references = {str(number): ink for number, ink in enumerate(artists.inks(item)[:1])}
            examples.append((view, Target.of(item.name, references, Settings(), view.buffers.hit)))
            advance(item.name)
    return canny.search(examples)
