"""The settings that a view's drawings are chosen among: unions of lines at a few thresholds.

256 combine suggestive contours, apparent ridges, and ridges with valleys, each at one of three thresholds or off, with
and without creases, with and without borders; occluding contours always (section 4 of the paper). What they are made of
are a dozen layers: lines of a family at a threshold, each drawn once.
"""

import itertools
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ncmodel.drawing.draw import strokes_of
from ncmodel.drawing.plan import Plan
from ncmodel.drawing.thresholding import fade
from ncmodel.export.png import strokes_ink
from ncmodel.scene.view import View
from ncmodel.tracing import timed
from ncmodel.types import Image, LineFamily, Mask, Threshold, Thresholds

INK_LEVEL = 0.1
"""A pixel is inked where a drawing is darker than this."""

FILTERS = {
    "suggestive": (LineFamily.SUGGESTIVE,),
    "apparent": (LineFamily.APPARENT,),
    "ridges_valleys": (LineFamily.RIDGES, LineFamily.VALLEYS),
}
"""What is switched through its thresholds together."""


@dataclass(frozen=True)
class Layer:
    """Lines of some families at one threshold.

    Attributes:
        name: Unique.
        families: Lines drawn at `threshold`.
        threshold: rtsc's; 0 for families without one.
    """

    name: str
    families: tuple[LineFamily, ...] = ()
    threshold: float = 0.0


@dataclass(frozen=True)
class Setting:
    """One choice: thresholds in rtsc's units (None: off) and switches.

    Attributes:
        suggestive: Of suggestive contours.
        apparent: Of apparent ridges.
        ridges_valleys: Of ridges and valleys.
        creases: Whether creases are drawn.
        borders: Whether borders are drawn.
    """

    suggestive: float | None
    apparent: float | None
    ridges_valleys: float | None
    creases: bool
    borders: bool

    @property
    def layers(self) -> tuple[str, ...]:
        """The names of the layers that it is the union of."""
        names = [LineFamily.CONTOURS.value]
        thresholds = {name: getattr(self, name) for name in FILTERS}
        names += [f"{name}@{threshold:g}" for name, threshold in thresholds.items() if threshold is not None]
        names += [LineFamily.CREASES.value] * self.creases + [LineFamily.BOUNDARIES.value] * self.borders
        return tuple(names)

    def plan(self) -> Plan:
        """What draws it."""
        thresholds = Thresholds(self.suggestive, self.ridges_valleys, self.ridges_valleys, self.apparent)
        switched = {LineFamily.BOUNDARIES: self.borders, LineFamily.CREASES: self.creases}
        families = (
            LineFamily.CONTOURS,
            *(family for family, drawn in switched.items() if drawn),
            *(family for family in Thresholds.families if thresholds.value(family) is not None),
        )
        return Plan(families, thresholds)


@dataclass(frozen=True)
class Levels:
    """The thresholds that settings go through, each family also off.

    Attributes:
        suggestive: Thresholds in rtsc's units, the paper's.
        apparent: Likewise; chosen so that kept lengths differ on real meshes.
        ridges_valleys: Likewise.
    """

    suggestive: tuple[float, float, float] = (0.001, 0.01, 0.1)
    apparent: tuple[float, float, float] = (0.01, 0.1, 1.0)
    ridges_valleys: tuple[float, float, float] = (0.03, 0.1, 0.3)

    @cached_property
    def layers(self) -> tuple[Layer, ...]:
        """All layers, in a fixed order: what is always or never filtered, then the filters at rising thresholds."""
        plain = (LineFamily.CONTOURS, LineFamily.CREASES, LineFamily.BOUNDARIES)
        layers = [Layer(family.value, (family,)) for family in plain]
        for name, families in FILTERS.items():
            layers += [Layer(f"{name}@{threshold:g}", families, threshold) for threshold in getattr(self, name)]
        return tuple(layers)

    @cached_property
    def settings(self) -> tuple[Setting, ...]:
        """The 256 settings in their fixed order; the last switch, borders, changes fastest."""
        choices = [(*getattr(self, name), None) for name in FILTERS]
        return tuple(Setting(*chosen) for chosen in itertools.product(*choices, (False, True), (False, True)))

    @cached_property
    def members(self) -> Mask:
        """(256, 12) which layers each setting consists of."""
        column = {layer.name: number for number, layer in enumerate(self.layers)}
        settings = self.settings
        members = np.zeros((len(settings), len(column)), dtype=np.bool_)
        for row, setting in enumerate(settings):
            members[row, [column[name] for name in setting.layers]] = True
        return members


@dataclass(frozen=True, eq=False)
class LayeredDrawings:
    """All drawings of a view that settings choose among.

    Attributes:
        levels: What the layers are.
        ink: (12, H, W) grey ink of the layers; a drawing is the maximum of its layers.
    """

    levels: Levels
    ink: Image

    @cached_property
    def masks(self) -> Mask:
        """(12, H, W) inked pixels of the layers; those of a drawing are their union."""
        return np.asarray(self.ink > INK_LEVEL)

    def drawing(self, index: int) -> Image:
        """(H, W) ink of a setting's drawing, with tapering."""
        drawing: Image = self.ink[self.levels.members[index]].max(axis=0)
        return drawing


def draw_layers(view: View, levels: Levels) -> LayeredDrawings:
    """Draw all layers of a view: lines as a drawing at the layer's threshold has them."""
    layers = levels.layers
    ink = np.zeros((len(layers), view.camera.height, view.camera.width), dtype=np.float32)
    for image, layer in zip(ink, layers, strict=True):
        draw_layer(view, layer, image)
    return LayeredDrawings(levels, ink)


def draw_layer(view: View, layer: Layer, image: Image) -> None:
    """Draw one layer of a view onto (H, W) ink."""
    for family in layer.families:
        strokes = strokes_of(view, fade(view.visible(family), Threshold(layer.threshold)))
        with timed(view.trace, "raster"):
            np.maximum(image, strokes_ink(strokes, view.camera), out=image)
