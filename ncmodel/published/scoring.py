"""Drawings of a view as the published code filters them, and their score, as functions of thresholds.

Letters in shapes: B drawings, P pixels that carry filtered lines, S side of the ranking module's input.
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import torch
from torch import Tensor

from ncmodel.errors import UsageError
from ncmodel.model.filters import Glance
from ncmodel.model.letterbox import Square
from ncmodel.nets.devices import numbers
from ncmodel.nets.presets import BACKGROUND
from ncmodel.nets.ranking import RankingModule
from ncmodel.published.folder import HEIGHT, WIDTH, PublishedView
from ncmodel.published.weights import centred, stored
from ncmodel.types import SUGGESTIVE_FADE, Floats, Image, Mask

MOST = 5.0
"""Thresholds beyond count as this one."""

SMALLEST = 1e-12
"""Keeps quotients finite where a feature is 0."""

TABULATED = 256
"""Thresholds whose ink is counted; between them, it is taken to fall linearly."""

CHUNK = 128
"""Drawings seen from afar at a time."""


def faded(family: int, strength: Tensor, facing: Tensor, t: Tensor) -> Tensor:
    """What thresholds leave of a family's ink: as in rtsc of suggestive contours, 1 - t / strength of the others.

    Args:
        family: Its place in t.
        strength: (P,) what thresholds are compared with.
        facing: (P,) n.v.
        t: (B, 1) thresholds.

    Returns:
        (B, P) shares.
    """
    if family > 0:
        return (1.0 - t / (strength + SMALLEST)).clamp(0.0, 1.0)
    excess = torch.relu(strength - t * facing)
    return (excess / (SUGGESTIVE_FADE * facing + excess + SMALLEST)).clamp(0.0, 1.0)


def filtered(lines: Tensor, strength: Tensor, facing: Tensor, thresholds: Tensor) -> Tensor:
    """Lines faded by thresholds.

    Args:
        lines: (4, P) ink of suggestive contours, ridges, valleys and apparent ridges, unfiltered.
        strength: (4, P) D fs^2, fs k1, -fs k1 and fs^2 q1.
        facing: (P,) n.v.
        thresholds: (B, 4), which count as 0..`MOST`.

    Returns:
        (B, 4, P) ink.
    """
    t = thresholds.clamp(0.0, MOST)[:, :, None]
    left = [faded(family, own, facing, t[:, family]) for family, own in enumerate(strength)]
    return torch.stack(left, dim=1) * lines


class Fading:
    """How much ink of one family is left at which threshold.

    Args:
        family: Its place in t.
        lines: (P,) its ink.
        strength: (P,) what thresholds are compared with.
        facing: (P,) n.v.
    """

    def __init__(self, family: int, lines: Tensor, strength: Tensor, facing: Tensor) -> None:
        drawn = lines > 0
        self._family = family
        self._lines, self._strength, self._facing = lines[drawn], strength[drawn], facing[drawn]

    @property
    def present(self) -> bool:
        """Whether the family has lines in this view."""
        return len(self._lines) > 0

    def threshold(self, share: float) -> float:
        """The t at which `share` of the ink is left, 0 for share 1; the least t that leaves nothing, or `MOST`, for 0.

        Raises:
            ValueError: The family has no lines.
        """
        if not self.present:
            raise ValueError("this family has no lines")
        thresholds, left = self._left
        return float(np.interp(-share, -left, thresholds)) if share > 0.0 else float(thresholds[-1])

    @cached_property
    def _left(self) -> tuple[Floats, Floats]:
        """Thresholds from 0 to the last one, and the share of ink that each leaves, falling.

        They are close together where they are small, where most ink fades.
        """
        against = self._facing.clamp(min=SMALLEST) if self._family == 0 else 1.0
        last = min(float((self._strength / against).max()), MOST)
        thresholds = torch.linspace(0.0, 1.0, TABULATED, dtype=self._lines.dtype).square() * last
        rows = [faded(self._family, self._strength, self._facing, t.reshape(1, 1))[0] for t in thresholds]
        ink = np.array([float(row @ self._lines) for row in rows])
        return thresholds.double().numpy(), ink / max(float(ink[0]), SMALLEST)


class PublishedScore:
    """The ranking module's score of I(t), for one view; higher is better, unlike in the published code.

    It is what `threshold_search.optimise` climbs. Contours and creases are always drawn, boundaries never.

    Args:
        ranker: The published ranking module.
        view: The view, of the published size.
        image: (H, W) ink of the image branch, if it takes part.
        rough: Compute everything in the numbers in which the device is fastest.

    Raises:
        UsageError: The view has another size.
    """

    has_boundaries = False

    def __init__(
        self, ranker: RankingModule, view: PublishedView, image: Image | None = None, rough: bool = False
    ) -> None:
        check_size(view)
        self._ranker, self._like, self._rough = ranker, ranker.head.weight, rough
        self._square = Square(HEIGHT, WIDTH, ranker.dims.size)
        names = ranker.dims.inputs
        self._maps = self._tensor(centred(self._square.fit(view.network_maps(names), BACKGROUND), names))[None]
        always = view.base if image is None else np.maximum(view.base, image)
        self._base = self._tensor(always).reshape(-1)
        self._pixels = torch.from_numpy(np.flatnonzero(view.lines.any(axis=0))).to(self._like.device)
        self._lines = self._tensor(view.lines).reshape(4, -1)[:, self._pixels]
        self._facing = self._tensor(view.n_dot_v).reshape(-1)[self._pixels]
        self._strength = self._tensor(strengths(view)).reshape(4, -1)[:, self._pixels]

    @cached_property
    def fading(self) -> list["Fading"]:
        """How each of the four families fades."""
        lines, strength, facing = (part.double().cpu() for part in (self._lines, self._strength, self._facing))
        return [Fading(family, *parts, facing) for family, parts in enumerate(zip(lines, strength, strict=True))]

    @property
    def present(self) -> Mask:
        """(4,) which families have lines in this view."""
        return np.array([family.present for family in self.fading])

    def scores(self, thresholds: Floats, boundaries: bool = False, rough: bool = False) -> Floats:
        """(B,) scores of (B, 4) thresholds; rough ones in the numbers in which the device is fastest."""
        with torch.inference_mode(), numbers(self._like.device, rough or self._rough):
            found = [self.score(self.drawings(self._tensor(t)[None])) for t in thresholds]
        return torch.cat(found).double().cpu().numpy()

    def slope(self, thresholds: Floats, boundaries: bool = False) -> tuple[float, Floats]:
        """The score at one (4,) t, and its (4,) gradient."""
        t = self._tensor(thresholds)[None].requires_grad_()
        with numbers(self._like.device, self._rough):
            score = self.score(self.drawings(t))[0]
        (gradient,) = torch.autograd.grad(score, t)
        return score.item(), gradient[0].double().cpu().numpy()

    def glance(self, thresholds: Floats) -> Floats:
        """(B, C) what the drawings of (B, 4) thresholds look like from afar, without the image branch."""
        (lines, strength, facing), always = self._seen
        t = torch.from_numpy(thresholds).to(lines.dtype)
        parts = [filtered(lines, strength, facing, some).max(dim=1).values for some in torch.split(t, CHUNK)]
        return self._glance(torch.maximum(torch.cat(parts), always).numpy())

    @cached_property
    def _glance(self) -> Glance:
        ink = self._lines.max(dim=0).values.float().cpu().numpy()
        return Glance(self._pixels.cpu().numpy(), ink, (HEIGHT, WIDTH))

    @cached_property
    def _seen(self) -> tuple[tuple[Tensor, Tensor, Tensor], Tensor]:
        """What filters the pixels that are looked at from afar; and their ink that is always drawn."""
        pixels = torch.from_numpy(self._glance.pixels).to(self._pixels.device)
        parts = self._lines[:, pixels], self._strength[:, pixels], self._facing[pixels]
        always = self._base[self._pixels[pixels]]
        return (parts[0].cpu(), parts[1].cpu(), parts[2].cpu()), always.cpu()

    def drawings(self, thresholds: Tensor) -> Tensor:
        """(B, 4) thresholds -> (B, 1, H, W) drawings I(t): at each pixel the strongest line."""
        ink = filtered(self._lines, self._strength, self._facing, thresholds)
        layers = torch.cat([ink, self._base[self._pixels].expand(len(ink), 1, -1)], dim=1)
        strongest = layers.max(dim=1).values.clamp(0.0, 1.0)
        whole = self._base.expand(len(ink), -1).index_copy(1, self._pixels, strongest)
        return whole.reshape(-1, 1, HEIGHT, WIDTH)

    def score(self, drawings: Tensor) -> Tensor:
        """(B, 1, H, W) drawings -> (B,) scores, no drawing outside the picture."""
        (top, left), (rows, columns) = self._square.corner, self._square.inner
        size = self._square.size
        around = (left, size - columns - left, top, size - rows - top)
        whole = torch.nn.functional.pad(drawings, around)
        # One convolution over all channels: sums in the published order have the published digits.
        seen = torch.cat([whole, self._maps.expand(len(whole), -1, -1, -1)], dim=1)
        return self._ranker.rank(self._ranker.stem(seen))

    def of_picture(self, ink: Image) -> float:
        """The score of a drawing of which only its (H, W) ink is known."""
        with torch.inference_mode():
            return float(self.score(self._tensor(ink)[None, None])[0])

    def ink(self, thresholds: Sequence[float]) -> Image:
        """(H, W) the drawing at one t."""
        with torch.inference_mode():
            return np.asarray(self.drawings(self._tensor(np.array([thresholds])))[0, 0].float().cpu().numpy())

    def _tensor(self, values: Floats | Image) -> Tensor:
        return torch.from_numpy(np.ascontiguousarray(values)).to(self._like)


def strengths(view: PublishedView) -> Image:
    """(4, H, W) what thresholds in rtsc's units are compared with: features times fs^n.

    They are multiplied and rounded in the published order, D fs fs but (fs fs) q1: which of two pixels is the larger
    decides on a gradient's way through the network, and the last digit may.
    """
    values, size = (stored(view.features) * view.p90[:, None, None]).astype(np.float32), np.float32(view.feature_size)
    suggestive, ridges, valleys, apparent = values
    return np.stack([suggestive * size * size, ridges * size, valleys * size, apparent * (size * size)])


def check_size(view: PublishedView) -> None:
    """Raise a UsageError unless a view has the size that the published code expects."""
    if view.size != (WIDTH, HEIGHT):
        found = "{} x {}".format(*view.size)
        raise UsageError(f"maps of {found} pixels, expected {WIDTH} x {HEIGHT}, which the published networks see")
