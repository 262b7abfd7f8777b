"""The trained model: which lines of a view to draw, and which to add that geometry doesn't know of.

Three variants, as the paper's ablation has them: "full" is both branches merged; "geometry" leaves the image branch
out; "image" is the image branch alone, for which no line of the mesh is computed. A checkpoint without one of the
networks offers what is left.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from typing import Literal, Protocol

import torch

from ncmodel.drawing.plan import MODEL_CRUMB, Plan
from ncmodel.errors import ArgumentError, UsageError
from ncmodel.export.png import strokes_ink
from ncmodel.model.letterbox import Square
from ncmodel.model.maps import line_maps, network_maps
from ncmodel.model.ridge_detection import find_ridges, polylines
from ncmodel.model.score import DrawingScore
from ncmodel.model.setting_choice import choose_setting
from ncmodel.model.surrogate_search import optimise_with_surrogate
from ncmodel.model.threshold_search import Budget, Optimum, ScoredDrawing, budget_named, optimise
from ncmodel.nets.blocks import WIDE, threads_for
from ncmodel.nets.checkpoints import Checkpoint, load_checkpoint
from ncmodel.nets.devices import device_named, numbers, prepared
from ncmodel.nets.presets import BACKGROUND
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.shipped import checkpoint_path
from ncmodel.scene.hard_edges import has_hard_edges
from ncmodel.scene.view import View
from ncmodel.tracing import timed
from ncmodel.types import FILTERED_FAMILIES, Image, LineFamily, Stroke, Thresholds

Variant = Literal["full", "geometry", "image"]

SEEN_SIDE = 768
"""Shorter side, pixels, of the pictures that the networks' inputs are averaged from: that of the training views, whose
lines are as thin. Larger and smaller drawings get the thresholds chosen at this size."""

LONGEST_SIDE = 4 * SEEN_SIDE
"""Longer side that such a picture has at most."""


class Scored(Protocol):
    """Makes the score of a view's drawings."""

    def __call__(self, ranker: RankingModule, /, *, rough: bool = False) -> ScoredDrawing:
        """What a ranking module says of them, in the numbers in which its device is fastest if `rough`."""


class Model:
    """Trained networks, ready to draw.

    Args:
        checkpoint: The networks.
        device: Where the two networks that see pictures compute: "cpu", "cuda", or another of torch's devices.

    Raises:
        UsageError: This machine has no such device.
    """

    layout = torch.channels_last
    """Of the networks in memory: the quickest."""

    def __init__(self, checkpoint: Checkpoint, device: str | torch.device = "cpu") -> None:
        self.checkpoint, self.device = checkpoint, device_named(device)
        for name, network in checkpoint.networks.items():
            network.eval().requires_grad_(False)
            # Numbers are counted on the CPU, and few.
            network.to("cpu" if name == "statistics" else self.device)
            network.to(memory_format=self.layout)  # type: ignore[call-overload]

    @cached_property
    def _rough_ranker(self) -> RankingModule:
        assert self.checkpoint.ranker is not None
        return prepared(self.checkpoint.ranker)

    @property
    def variants(self) -> tuple[Variant, ...]:
        """What this model can draw; the first one uses all that it has."""
        needs: dict[Variant, tuple[str, ...]] = {
            "full": ("ranker", "translator"),
            "geometry": ("ranker",),
            "image": ("translator",),
        }
        have = set(self.checkpoint.networks)
        if "statistics" in have:
            have.add("ranker")  # it ranks by itself
        return tuple(variant for variant, names in needs.items() if set(names) <= have)

    def known_variant(self, variant: Variant | None) -> Variant:
        """The variant that is meant: all that the model has for None.

        Raises:
            UsageError: The model lacks a network that it needs.
        """
        if not self.variants:
            holds = ", ".join(self.checkpoint.networks) or "no network"
            raise UsageError(f"this model holds {holds}; expected a ranker or a translator, by which to draw")
        variant = variant or self.variants[0]
        if variant not in self.variants:
            raise ArgumentError("variant", repr(variant), f"one of {', '.join(self.variants)}, which this model offers")
        return variant

    def known_budget(self, budget: Budget | str) -> Budget:
        """The search budget that is meant: large ranking modules have others by the same names.

        Raises:
            UsageError: There is none of that name, or it needs a model that counts ink.
        """
        if not isinstance(budget, str):
            return budget
        if budget == "instant" and self.checkpoint.statistics is None:
            raise ArgumentError("preset", "'instant'", "draft, balanced or accurate: this model doesn't count ink")
        return budget_named(budget, self.checkpoint.preset.ranking.width >= WIDE)

    def choose(
        self,
        view: View,
        variant: Variant | None = None,
        budget: Budget | str = "balanced",
        families: Sequence[LineFamily] = tuple(LineFamily),
    ) -> Plan:
        """Decide what to draw of a view.

        Args:
            view: The view.
            variant: Which branches take part; all that the model has by default.
            budget: How thoroughly the choice is made: "instant" (only by a model that counts ink), "draft", "balanced",
                "accurate", or a budget of your own.
            families: The families that may be drawn, besides contours; boundaries always may.

        Returns:
            The plan, its thresholds in units of the 90th percentiles, or of rtsc's where settings are chosen among.

        Raises:
            UsageError: The model lacks a network that the variant needs, or as `known_budget` does.
        """
        budget, variant, preset = self.known_budget(budget), self.known_variant(variant), self.checkpoint.preset
        seen = as_seen(view)
        maps = network_maps(seen, preset.inputs, preset.percentile)
        strokes = () if variant == "geometry" else self._image_lines(maps, seen, rough=budget.looks > 0)
        plan = Plan((), Thresholds(None, None, None, None, unit="p90"), strokes)
        if variant != "image" and self.checkpoint.statistics is not None:
            plan = self._with_setting(plan, seen, maps, budget, families)
        elif variant != "image":
            plan = self._with_geometry(plan, seen, maps, budget, [f for f in families if f in FILTERED_FAMILIES])
        if variant != "image":
            plan = replace(plan, finished=True, crumb=MODEL_CRUMB, rims=True)
        scale = view.camera.width / seen.camera.width
        return replace(plan, strokes=tuple(replace(s, points=s.points * scale) for s in plan.strokes))

    def probability(self, maps: Image, rough: bool = False) -> Image:
        """(S, S) line probability that the image branch sees in (K, H, W) maps, at its own resolution.

        Args:
            maps: (K, H, W) the maps of the preset's inputs.
            rough: Compute in the numbers in which the device is fastest; a hundredth may be lost.

        Raises:
            UsageError: The model has no image branch.
        """
        translator = self.checkpoint.translator
        if translator is None:
            raise UsageError("this model has no image branch")
        square = Square(maps.shape[1], maps.shape[2], translator.dims.size)
        placed = torch.from_numpy(square.fit(maps, BACKGROUND))[None].to(self.device)
        with torch.inference_mode(), numbers(self.device, rough):
            found: Image = translator(placed)[0, 0].float().cpu().numpy()
        return found

    def search(self, scored: Scored, budget: Budget) -> Optimum:
        """The thresholds of the drawing that the ranking module likes best.

        Args:
            scored: Makes the score of a view's drawings of a ranking module; with `rough`, in quick numbers.
            budget: How thoroughly to search.

        Raises:
            UsageError: No score is a number.
        """
        ranker = self.checkpoint.ranker
        assert ranker is not None
        with threads_for(ranker.dims.width):
            exact = scored(ranker)
            if not budget.looks:
                return optimise(exact, budget)
            quick = self._rough_ranker
            return optimise_with_surrogate(exact, exact if quick is ranker else scored(quick, rough=True), budget.looks)

    def _image_lines(self, maps: Image, seen: View, rough: bool) -> tuple[Stroke, ...]:
        """The image branch's lines, in the pixels of the maps."""
        with timed(seen.trace, "image_branch"):
            probability = self.probability(maps, rough)
        with timed(seen.trace, "ridges"):
            square = Square(maps.shape[1], maps.shape[2], probability.shape[0])
            return polylines(find_ridges(probability), square)

    def _with_setting(
        self, plan: Plan, seen: View, maps: Image, budget: Budget, families: Sequence[LineFamily]
    ) -> Plan:
        """The plan with the setting that people would most probably prefer."""
        counting = self.checkpoint.statistics
        assert counting is not None
        image = strokes_ink(plan.strokes, seen.camera) if plan.strokes else None
        allowed = (*families, LineFamily.BOUNDARIES)
        with threads_for(self.checkpoint.preset.ranking.width):
            choice = choose_setting(
                seen, maps, counting, self.checkpoint.ranker, budget.shortlist, allowed, image, budget.mirrored
            )
        chosen = choice.setting.plan()
        # What the settings of a surface of hard edges differ in is what they show of its curved sides: people draw all
        # such edges, and none of what is sharp on a sculpted one.
        hard = LineFamily.CREASES in families and has_hard_edges(seen.surface, seen.crease_angle)
        edges = [LineFamily.CREASES] * hard + [LineFamily.INTERSECTIONS]
        smooth = [family for family in chosen.families if family is not LineFamily.CREASES]
        return replace(
            chosen,
            families=(*smooth, *(family for family in edges if family in families)),
            strokes=plan.strokes,
            score=choice.score,
            evaluations=choice.evaluations,
        )

    def _with_geometry(
        self, plan: Plan, seen: View, maps: Image, budget: Budget, families: Sequence[LineFamily]
    ) -> Plan:
        """The plan with thresholds and families decided by the ranking module."""
        lines = line_maps(seen, families, self.checkpoint.preset.percentile)
        image = strokes_ink(plan.strokes, seen.camera) if plan.strokes else None
        with timed(seen.trace, "threshold_search"):
            scored = partial(DrawingScore, maps=maps, lines=lines, image=image, mirrored=budget.mirrored)
            optimum = self.search(scored, budget)
        chosen: dict[LineFamily, float] = {}
        for index, family in enumerate(FILTERED_FAMILIES):
            # From the largest feature on, a threshold leaves no line: the family is off.
            if optimum.present[index] and optimum.thresholds[index] < float(lines.features[index].max()):
                chosen[family] = optimum.thresholds[index]
        p90 = {family: float(lines.p90[index]) for index, family in enumerate(FILTERED_FAMILIES)}
        return Plan(
            families=(LineFamily.CONTOURS, *([LineFamily.BOUNDARIES] if optimum.boundaries else []), *chosen),
            thresholds=replace(plan.thresholds, p90=p90).with_values(**{f.value: t for f, t in chosen.items()}),
            strokes=plan.strokes,
            score=optimum.score,
            evaluations=optimum.evaluations,
            converged=optimum.converged,
        )


def load_model(path: str | Path, device: str | torch.device = "cpu") -> Model:
    """Read a checkpoint, ready to draw.

    Args:
        path: The file, or "default" for the model that ships with the package.
        device: Where to compute: "cpu", "cuda", or another of torch's devices.

    Raises:
        InputError: The file isn't a checkpoint, or is damaged.
        UsageError: This machine has no such device.
    """
    place = device_named(device)
    return Model(load_checkpoint(checkpoint_path(path), place), place)


def as_seen(view: View) -> View:
    """The view at the resolution that the networks' inputs come from."""
    camera = view.camera
    # A strip is seen at less than that, so that its length stays bounded.
    scale = min(SEEN_SIDE / min(camera.width, camera.height), LONGEST_SIDE / max(camera.width, camera.height))
    width, height = max(1, round(camera.width * scale)), max(1, round(camera.height * scale))
    if (width, height) == (camera.width, camera.height):
        return view
    return View(view.surface, camera.resized(width, height), view.crease_angle)
