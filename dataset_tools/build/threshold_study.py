"""What the candidates' thresholds do on real views: how much of the lines each one keeps, how many drawings differ."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dataset_tools.build.config import BuildConfig
from ncmodel.config import read_config
from ncmodel.data.data_folder import DataFolder
from ncmodel.drawing.settings import FILTERS
from ncmodel.drawing.thresholding import fade
from ncmodel.scene.view import View
from ncmodel.types import Floats, LineFamily, Threshold

PERCENTILES = (10, 50, 90)


@dataclass(frozen=True)
class KeptShare:
    """The share of a family's visible length that a threshold keeps, over many views.

    Attributes:
        family: The family.
        threshold: The threshold.
        shares: Its percentiles `PERCENTILES`.
    """

    family: LineFamily
    threshold: float
    shares: tuple[float, ...]


@dataclass(frozen=True)
class ThresholdStudy:
    """Thresholds measured on the views of a data folder.

    Attributes:
        views: How many.
        kept: One entry a family and threshold.
        distinct: Percentiles of the number of different ones among the 256 drawings of lines of a view.
    """

    views: int
    kept: tuple[KeptShare, ...]
    distinct: tuple[float, ...]

    def to_record(self) -> dict[str, Any]:
        """JSON-ready values."""
        kept = [{"family": one.family, "level": one.threshold, "shares": one.shares} for one in self.kept]
        return {"views": self.views, "kept": kept, "distinct": self.distinct}


def study_thresholds(data_dir: str | Path) -> ThresholdStudy:
    """Measure the candidates' thresholds that a data folder was built with on its views.

    Raises:
        InputError: It has no finished view.
    """
    data = DataFolder(data_dir)
    items = data.items()
    chosen = read_config(BuildConfig, data.config_path).levels
    steps = [
        (family, threshold)
        for name, families in FILTERS.items()
        for family in families
        for threshold in getattr(chosen, name)
    ]
    shares = np.array([_shares(data.open_view(item), steps) for item in items])
    kept = tuple(KeptShare(*step, _percentiles(shares[:, i])) for i, step in enumerate(steps))
    distinct = [different_drawings(data.view_folder(item)) for item in items]
    return ThresholdStudy(len(items), kept, _percentiles(distinct))


def different_drawings(folder: Path) -> int:
    """How many of a view's drawings of lines differ in some pixel."""
    specs = json.loads((folder / "candidates.json").read_text(encoding="utf-8"))
    with np.load(folder / "candidates.npz") as archive:
        ink = archive["ink"]
    return len({ink[spec["index"]].tobytes() for spec in specs if spec["kind"] == "lines"})


def _shares(view: View, steps: Sequence[tuple[LineFamily, float]]) -> list[float]:
    """Share of the visible length left at each threshold; NaN where a view has no such line."""
    result = []
    for family, threshold in steps:
        lines = view.visible(family)
        total = _length(lines.points)
        result.append(_length(fade(lines, Threshold(threshold)).points) / total if total > 0 else float("nan"))
    return result


def _length(points: Floats) -> float:
    return float(np.linalg.norm(points[:, 1] - points[:, 0], axis=1).sum())


def _percentiles(values: Iterable[float]) -> tuple[float, ...]:
    known = [value for value in values if not np.isnan(value)]
    return tuple(round(float(value), 3) for value in np.percentile(known, PERCENTILES)) if known else ()
