"""The published networks at work as the published code has them: its frame, filter, ridge detector and lines."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np
import torch

from ncmodel.drawing.plan import Plan
from ncmodel.errors import ArgumentError, UsageError
from ncmodel.model.maps import network_maps
from ncmodel.model.predictor import Model, Variant
from ncmodel.model.threshold_search import BUDGETS, Budget
from ncmodel.nets.blocks import threads_for
from ncmodel.nets.checkpoints import load_checkpoint
from ncmodel.nets.devices import device_named
from ncmodel.nets.presets import MAPS
from ncmodel.nets.shipped import checkpoint_path
from ncmodel.published.folder import HEIGHT, WIDTH, PublishedView
from ncmodel.published.rendering import framed, published_view
from ncmodel.published.ridges import centre_lines, line_mask
from ncmodel.published.scoring import PublishedScore
from ncmodel.published.search import published_search
from ncmodel.published.weights import centred
from ncmodel.scene.view import View
from ncmodel.types import FILTERED_FAMILIES, Image, LineFamily, Mask, Thresholds

Mode = Literal["paper", "published"]

SCHEDULE = "published"
"""The budget that searches as the published code does: for hours without a GPU."""


BASE = Plan((LineFamily.CONTOURS, LineFamily.CREASES), Thresholds(None, None, None, None))
"""What is always drawn."""


@dataclass(frozen=True, eq=False)
class Choice:
    """What was chosen of a view.

    Attributes:
        plan: Families and thresholds; without the image branch's strokes.
        ink: (H, W) the drawing I(t), pixel by pixel.
        mask: (H, W) pixels of the image branch's lines, if it takes part.
    """

    plan: Plan
    ink: Image
    mask: Mask | None


class PublishedModel(Model):
    """Imported networks that draw as the published code does.

    `choose` sees the shape in the middle of 1024 x 768 pixels, whatever the camera's own picture. Contours and creases
    are always drawn, boundaries never; the image branch's lines come with them.
    """

    layout = torch.contiguous_format
    """The published one: another sums in another order."""

    def choose(
        self,
        view: View,
        variant: Variant | None = None,
        budget: Budget | str = "balanced",
        families: Sequence[LineFamily] = tuple(LineFamily),
    ) -> Plan:
        """Decide what to draw of a view; as `Model.choose`, with thresholds as the published code measures them.

        Raises:
            UsageError: The model lacks a network that the variant needs, or there is no such budget.
        """
        variant = self.known_variant(variant)
        seen = View(view.surface, framed(view.camera), view.crease_angle)
        if variant == "image":
            # Neither lines nor features are computed for it.
            mask: Mask | None = line_mask(self.paper(network_maps(seen)))
            plan = BASE
        else:
            choice = self.choose_lines(published_view(seen), variant, budget, families)
            plan, mask = choice.plan, choice.mask
        if mask is None:
            return plan
        scale = min(WIDTH / view.camera.width, HEIGHT / view.camera.height)
        middle, own = np.array([WIDTH, HEIGHT]) / 2, np.array([view.camera.width, view.camera.height]) / 2
        moved = (replace(stroke, points=(stroke.points - middle) / scale + own) for stroke in centre_lines(mask))
        return replace(plan, strokes=tuple(moved))

    def choose_lines(
        self,
        view: PublishedView,
        variant: Variant | None = None,
        budget: Budget | str = "balanced",
        families: Sequence[LineFamily] = tuple(LineFamily),
    ) -> Choice:
        """Decide what to draw of the maps of a view.

        Args:
            view: The maps, 1024 x 768.
            variant: Which branches take part; all that the model has by default.
            budget: "draft", "balanced", "accurate", or "published": its own schedule of random starts.
            families: The families that may be drawn, besides contours and creases.

        Raises:
            UsageError: The maps have another size, or as `choose` does.
        """
        variant = self.known_variant(variant)
        allowed = np.array([family in families for family in FILTERED_FAMILIES])
        view = replace(view, lines=view.lines * allowed[:, None, None].astype(np.float32))
        mask = None if variant == "geometry" else line_mask(self.paper(view.maps))
        image = None if mask is None else mask.astype(np.float32)
        if variant == "image":
            assert image is not None
            return Choice(BASE, np.maximum(view.base, image), mask)
        ranker = self.checkpoint.ranker
        assert ranker is not None, "its variants wouldn't have this one"
        scored = partial(PublishedScore, view=view, image=image)
        score = scored(ranker)
        if budget == SCHEDULE:
            with threads_for(ranker.dims.width):
                optimum = published_search(score)
        else:
            optimum = self.search(scored, self.known_budget(budget))
        units = dict(zip(FILTERED_FAMILIES, view.p90.tolist(), strict=True))
        thresholds = Thresholds(None, None, None, None, unit="published", p90=units, feature_size=view.feature_size)
        chosen = {
            f: t for f, t, there in zip(FILTERED_FAMILIES, optimum.thresholds, score.present, strict=True) if there
        }
        plan = Plan(
            families=(*BASE.families, *chosen),
            thresholds=thresholds.with_values(**{family.value: t for family, t in chosen.items()}),
            score=optimum.score,
            evaluations=optimum.evaluations,
            converged=optimum.converged,
        )
        return Choice(plan, score.ink(optimum.thresholds), mask)

    def paper(self, maps: Image) -> Image:
        """(H, W) probability of paper, not line, that the image branch sees in a view; it isn't padded.

        Args:
            maps: (7, H, W) depth and shaded maps.

        Raises:
            UsageError: The model has no image branch.
        """
        translator = self.checkpoint.translator
        if translator is None:
            raise UsageError("this model has no image branch")
        names = translator.dims.inputs
        seen = torch.from_numpy(centred(maps[[MAPS.index(name) for name in names]], names))[None]
        seen = seen.to(translator.standardise.scale)
        with torch.inference_mode():
            return np.asarray(torch.sigmoid(-translator.translate(seen))[0, 0].float().cpu().numpy())

    def known_budget(self, budget: Budget | str) -> Budget:
        """As `Model.known_budget`; the published schedule is no such budget, but may be named too."""
        if isinstance(budget, str) and budget not in BUDGETS:
            raise ArgumentError("preset", repr(budget), f"one of {', '.join(BUDGETS)}, {SCHEDULE}")
        return super().known_budget(budget)


def load_model(path: str | Path, mode: Mode | None = None, device: str | torch.device = "cpu") -> Model:
    """Read a checkpoint, ready to draw.

    Args:
        path: The file, or "default" for the model that ships with the package.
        mode: "paper" draws as the paper says, "published" as the published code does. By default what the networks are
            made for: the latter only for imported ones.
        device: Where to compute: "cpu", "cuda", or another of torch's devices.

    Raises:
        InputError: The file isn't a checkpoint, or is damaged.
        UsageError: There is no such mode or device, or these networks weren't imported.
    """
    if mode not in (None, "paper", "published"):
        raise ArgumentError("mode", repr(mode), "paper or published")
    place = device_named(device)
    checkpoint = load_checkpoint(checkpoint_path(path), place)
    published = checkpoint.preset.published
    if mode == "published" and not published:
        raise ArgumentError("mode", "'published'", "paper: this checkpoint's networks weren't imported")
    return (PublishedModel if published and mode != "paper" else Model)(checkpoint, place)
