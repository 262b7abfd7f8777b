"""The classic lines with thresholds tuned by exhaustive search: the appendix's SC-grid, RV-grid, AR-grid and all-grid.

One threshold each for suggestive contours, ridges with valleys, and apparent ridges, common to all shapes, is chosen to
minimise the mean Chamfer distance to the references of training views. Lines are extracted once a view; each family is
drawn and thinned once a threshold. A combination is taken as the union of its families' thin layers, so that its
distances follow from theirs.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from eval.baselines.rtsc import ALWAYS, AR, RV, SC, layer, plan
from eval.measures.evaluation import Target
from ncmodel.chamfer import Lines, chamfer_to_unions
from ncmodel.drawing.plan import Plan
from ncmodel.scene.view import View
from ncmodel.types import Floats, Image, LineFamily, Thresholds

GROUPS = (SC, RV, AR)
"""Families that share a threshold."""

METHODS = {"SC-grid": (SC,), "RV-grid": (RV,), "AR-grid": (AR,), "all-grid": GROUPS}
"""The appendix's four variants, by their names there -> what they draw."""

THRESHOLDS = 100
"""Values tried per threshold, regularly from 0 to 1, as in the paper."""


@dataclass(frozen=True)
class Search:
    """The outcome of a grid search.

    Attributes:
        thresholds: (L,) the thresholds that were tried.
        costs: (L + 1, L + 1, L + 1) mean Chamfer distance in pixels with suggestive contours, ridges with valleys, and
            apparent ridges at each threshold; the last index of an axis leaves the family out.
    """

    thresholds: tuple[float, ...]
    costs: Floats

    def best(self, *groups: tuple[LineFamily, ...]) -> Plan:
        """The settings with the least cost that draw these families and no others; the first among equals.

        Args:
            groups: Some of `GROUPS`.
        """
        off = len(self.thresholds)
        allowed = [slice(0, off) if group in groups else slice(off, None) for group in GROUPS]
        part = self.costs[tuple(allowed)]
        index = np.unravel_index(int(np.argmin(part)), part.shape)
        chosen = {group: self.thresholds[place] for group, place in zip(GROUPS, index, strict=True) if group in groups}
        values = {family.value: chosen.get(group) for group in GROUPS for family in group}
        families = tuple(family for group in chosen for family in group)
        return plan(families, Thresholds().with_values(**values))

    @property
    def methods(self) -> dict[str, Plan]:
        """The plans of `METHODS`."""
        return {name: self.best(*groups) for name, groups in METHODS.items()}


def search(examples: Sequence[tuple[View, Target]], count: int = THRESHOLDS) -> Search:
    """Try all combinations of thresholds on training views.

    Args:
        examples: Views and what their drawings are judged by; at least one.
        count: How many thresholds to try for each of the three, at least 2.
    """
    if not examples:
        raise ValueError("no examples to choose thresholds by")
    tried = tuple(float(value) for value in np.linspace(0.0, 1.0, count))
    costs = np.mean([example_costs(view, target, tried) for view, target in examples], axis=0)
    return Search(tried, costs)


def example_costs(view: View, target: Target, thresholds: Sequence[float]) -> Floats:
    """(L + 1, L + 1, L + 1) Chamfer distances of all combinations on one view, the mean over its references."""
    always = target.prepare(np.maximum.reduce([layer(view, family) for family in ALWAYS]))
    layers, places = zip(*(_distinct(_layers(view, target, group, thresholds)) for group in GROUPS), strict=True)
    costs = [chamfer_to_unions(always, layers, reference) for reference in target.references.values()]
    return np.asarray(np.mean(costs, axis=0)[np.ix_(*places)], dtype=np.float64)


def _layers(view: View, target: Target, group: tuple[LineFamily, ...], thresholds: Sequence[float]) -> list[Lines]:
    """The thin lines of a group at each threshold, and an empty drawing for leaving it out."""

    def ink(threshold: float) -> Image:
        return np.asarray(np.maximum.reduce([layer(view, family, threshold) for family in group]))

    empty = target.prepare(np.zeros((view.camera.height, view.camera.width), np.float32))
    return [*(target.prepare(ink(threshold)) for threshold in thresholds), empty]


def _distinct(layers: Sequence[Lines]) -> tuple[list[Lines], list[int]]:
    """The different ones among layers, and which of them each is: high thresholds leave the same lines, or none."""
    found: dict[bytes, int] = {}
    places = [found.setdefault(np.packbits(lines.mask).tobytes(), len(found)) for lines in layers]
    return [layers[places.index(number)] for number in range(len(found))], places
