"""The 264 candidate drawings of a view, as unions of a few layers.

256 combine lines: suggestive contours, apparent ridges, and ridges with valleys, each at one of three thresholds or
off; with and without creases; with and without borders; occluding contours always. 8 are Canny edges of the shaded
view, 4 of them after edge-preserving filtering. A layer is drawn once, grey with its tapering; a drawing is the
maximum of its layers.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ncmodel.chamfer import distance_to
from ncmodel.drawing.settings import INK_LEVEL, Layer, Levels, draw_layer
from ncmodel.export.page import line_width
from ncmodel.scene.view import View
from ncmodel.tracing import timed
from ncmodel.types import Image, Mask


@dataclass(frozen=True)
class CandidateThresholds(Levels):
    """The thresholds that candidates go through, each family also off.

    Attributes:
        canny: Upper hysteresis thresholds on the gradient of a shaded view of 0..255; the lower ones are `canny_low` of
            them.
        canny_low: See there.
        smooth_space: Spatial scale of the domain transform, share of the shorter side.
        smooth_range: Its range scale, in greys of 0..255.
    """

    canny: tuple[float, float, float, float] = (40.0, 80.0, 160.0, 320.0)
    canny_low: float = 0.4
    smooth_space: float = 0.02
    smooth_range: float = 40.0


@dataclass(frozen=True)
class Edges(Layer):
    """A layer of Canny edges, `threshold` its upper one.

    Attributes:
        smoothed: After edge-preserving filtering.
    """

    smoothed: bool = False


@dataclass(frozen=True)
class Spec:
    """What one candidate is made of, as `candidates.json` holds it.

    Attributes:
        layers: Names of its layers.
        settings: The choice it stands for: thresholds (None: off) and switches.
    """

    layers: tuple[str, ...]
    settings: dict[str, Any]

    def to_record(self, index: int) -> dict[str, Any]:
        """The JSON object of candidate number `index`."""
        return {"index": index, **self.settings, "layers": list(self.layers)}


def layers_of(thresholds: CandidateThresholds) -> list[Layer]:
    """All layers, in a fixed order."""
    edges = [Edges(f"canny@{threshold:g}", (), threshold) for threshold in thresholds.canny]
    smoothed = [Edges(f"smoothed_canny@{threshold:g}", (), threshold, smoothed=True) for threshold in thresholds.canny]
    return [*thresholds.layers, *edges, *smoothed]


def specs_of(thresholds: CandidateThresholds) -> list[Spec]:
    """The 264 candidates in their fixed order: the settings of lines, then Canny and Canny after filtering."""
    specs = [Spec(setting.layers, {"kind": "lines", **asdict(setting)}) for setting in thresholds.settings]
    for smoothed, prefix in ((False, "canny"), (True, "smoothed_canny")):
        for threshold in thresholds.canny:
            settings = {
                "kind": "canny",
                "high": threshold,
                "low": thresholds.canny_low * threshold,
                "smoothed": smoothed,
            }
            specs.append(Spec((f"{prefix}@{threshold:g}",), settings))
    return specs


@dataclass(frozen=True, eq=False)
class Candidates:
    """The candidate drawings of a view.

    Attributes:
        specs: What each of the N candidates is.
        ink: (L, H, W) grey ink of the layers.
        members: (N, L) which layers each candidate consists of.
    """

    specs: Sequence[Spec]
    ink: Image
    members: Mask

    @cached_property
    def masks(self) -> Mask:
        """(L, H, W) inked pixels of the layers; those of a drawing are their union, as its ink is their maximum."""
        return np.asarray(self.ink > INK_LEVEL)

    def drawing(self, index: int) -> Image:
        """(H, W) ink of candidate `index`, with tapering."""
        drawing: Image = self.ink[self.members[index]].max(axis=0)
        return drawing

    def packed(self) -> NDArray[np.uint8]:
        """(N, H, ceil(W/8)) inked pixels of all candidates, eight in a byte along the last axis (`np.packbits`)."""
        layers = np.packbits(self.masks, axis=-1)
        return np.stack([np.bitwise_or.reduce(layers[member], axis=0) for member in self.members])


def draw_candidates(view: View, thresholds: CandidateThresholds) -> Candidates:
    """Draw all candidates of a view."""
    layers, specs = layers_of(thresholds), specs_of(thresholds)
    column = {layer.name: number for number, layer in enumerate(layers)}
    members = np.zeros((len(specs), len(layers)), dtype=bool)
    for row, spec in enumerate(specs):
        members[row, [column[name] for name in spec.layers]] = True
    return Candidates(specs, draw_layers(view, layers, thresholds), members)


def draw_layers(view: View, layers: Sequence[Layer], thresholds: CandidateThresholds) -> Image:
    """(L, H, W) grey ink of layers."""
    camera = view.camera
    ink = np.zeros((len(layers), camera.height, camera.width), dtype=np.float32)
    edges = _Edges(view, thresholds)
    for image, layer in zip(ink, layers, strict=True):
        if isinstance(layer, Edges):
            with timed(view.trace, "canny"):
                width = line_width("canny", camera.width, camera.height)
                image[:] = thick(edges.at(layer.threshold, layer.smoothed), width)
        else:
            draw_layer(view, layer, image)
    return ink


def thick(pixels: Mask, width: float) -> Image:
    """Lines of `width` pixels, anti-aliased, around one-pixel lines.

    Args:
        pixels: (H, W) the one-pixel lines.
        width: At least 1.
    """
    if not pixels.any():
        return np.zeros(pixels.shape, dtype=np.float32)
    return np.asarray(np.clip(width / 2 + 0.5 - distance_to(pixels), 0.0, 1.0), dtype=np.float32)


class _Edges:
    """Canny edges of a view's shading."""

    def __init__(self, view: View, thresholds: CandidateThresholds) -> None:
        self.view, self.thresholds = view, thresholds

    @cached_property
    def shading(self) -> NDArray[np.uint8]:
        """The unsmoothed shading, 0..255."""
        return np.asarray(np.rint(255 * self.view.shaded[0]), dtype=np.uint8)

    @cached_property
    def smoothed(self) -> NDArray[np.uint8]:
        """The shading after edge-preserving filtering.

        References:
            Gastal, Oliveira: Domain Transform for Edge-Aware Image and Video Processing. SIGGRAPH 2011.
        """
        space = self.thresholds.smooth_space * min(self.shading.shape)
        return np.asarray(
            cv2.ximgproc.dtFilter(self.shading, self.shading, space, self.thresholds.smooth_range), np.uint8
        )

    def at(self, threshold: float, smoothed: bool) -> Mask:
        """(H, W) one-pixel edges at an upper threshold."""
        image = self.smoothed if smoothed else self.shading
        return np.asarray(cv2.Canny(image, self.thresholds.canny_low * threshold, threshold, L2gradient=True) > 0)
