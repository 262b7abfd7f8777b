"""What is compared. A method draws a view; its picture is the file that `ncontours draw` would write."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from eval.baselines import canny, decision_tree, geometry_regressor, grid, rtsc
from eval.baselines.decision_tree import Tree
from eval.comparison.tuning import Tuned
from ncmodel.drawing.draw import draw, draw_view
from ncmodel.drawing.drawing import Drawing
from ncmodel.drawing.plan import Plan
from ncmodel.errors import ArgumentError
from ncmodel.export.page import legible_width
from ncmodel.export.png import png
from ncmodel.images import png_ink
from ncmodel.model.predictor import Model, Variant
from ncmodel.nets.checkpoints import Checkpoint
from ncmodel.nets.presets import CURVATURE_MAPS, MAPS, Preset
from ncmodel.nets.regressor import GeometryRegressor
from ncmodel.scene.view import View
from ncmodel.training.adversarial import Pix2pixHDObjective
from ncmodel.training.own import objective_name
from ncmodel.types import Image

PLAIN = "draw"
"""The row of plain `ncontours draw`."""

CLASSIC = (*rtsc.METHODS, *grid.METHODS, "Canny", PLAIN)
"""The rows that need no model, in the table's order."""

TREE = "Decision Tree"
"""The paper's name for the row of a trained decision tree."""

REGRESSOR = "Geometry-Regressor"
"""The appendix's name for the row of a network that predicts thresholds."""

VARIANTS: Mapping[str, Variant] = {"NC-geometry": "geometry", "NC-image": "image", "NCs": "full"}
"""The paper's names -> the model's."""

IMAGE, PIX2PIXHD = "NC-image", "pix2pixHD"
IMAGE_INPUTS: Mapping[tuple[str, ...], str] = {
    ("depth", "shaded_0"): "NC-image-noms",
    (*MAPS, *CURVATURE_MAPS): "NC-image-curv",
}
"""What an image branch reads -> the paper's name for its row, where that isn't `IMAGE`."""

LEARNED = (*VARIANTS, *IMAGE_INPUTS.values(), PIX2PIXHD)
"""The rows of models, whatever these were trained to do."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """What a method drew.

    Attributes:
        ink: (H, W) as it is measured: in pictures under 384 pixels no line is thinner than a pixel.
        png: The file, as `ncontours draw` writes it.
        plan: What was decided, where there was something to decide.
    """

    ink: Image
    png: bytes
    plan: Plan | None = None

    @staticmethod
    def of(drawing: Drawing) -> "Drawn":
        """A drawing, and its file."""
        ink = drawing.ink(legible_width(drawing.width, drawing.height))
        return Drawn(as_read(ink), png(drawing.picture()), drawing.plan)


def as_read(ink: Image) -> Image:
    """(H, W) ink as it is read from its file, in 256 greys: what `evaluate` measures."""
    return np.asarray(1.0 - np.rint(255.0 * (1.0 - ink)) / 255.0, dtype=np.float32)


class Method(Protocol):
    """One row of the table."""

    @property
    def name(self) -> str:
        """What the row and the folder of its drawings are called."""

    def draw(self, view: View) -> Drawn:
        """Draw a view."""


@dataclass(frozen=True)
class FixedPlan:
    """The same families at the same thresholds for every view: rtsc's, or tuned ones."""

    name: str
    plan: Plan

    def draw(self, view: View) -> Drawn:
        """See `Method.draw`."""
        return Drawn.of(draw_view(view, self.plan))


@dataclass(frozen=True)
class PlainDraw:
    """What `ncontours draw` does unasked."""

    name: str = PLAIN

    def draw(self, view: View) -> Drawn:
        """See `Method.draw`."""
        return Drawn.of(draw(view.surface, view.camera))


@dataclass(frozen=True)
class CannyEdges:
    """Canny edges of the shaded view."""

    settings: canny.CannySettings
    name: str = "Canny"

    def draw(self, view: View) -> Drawn:
        """See `Method.draw`."""
        ink = canny.draw(view, self.settings)
        return Drawn(ink, png_ink(ink))


@dataclass(frozen=True)
class DecisionTree:
    """What a trained decision tree finds in the maps of the view."""

    tree: Tree
    name: str = TREE

    def draw(self, view: View) -> Drawn:
        """See `Method.draw`."""
        return Drawn.of(decision_tree.draw(view, self.tree))


@dataclass(frozen=True, eq=False)
class Learned:
    """A trained model's choice."""

    name: str
    model: Model
    variant: Variant
    preset: str

    def draw(self, view: View) -> Drawn:
        """See `Method.draw`."""
        drawing = draw(view.surface, view.camera, model=self.model, variant=self.variant, preset=self.preset)
        return Drawn.of(drawing)


@dataclass(frozen=True, eq=False)
class Regressed:
    """What a network that predicts thresholds draws."""

    name: str
    regressor: GeometryRegressor
    preset: Preset

    def draw(self, view: View) -> Drawn:
        """See `Method.draw`."""
        return Drawn.of(geometry_regressor.draw(view, self.regressor, self.preset))


def classic_methods(tuned: Tuned, tree: Tree | None = None) -> list[Method]:
    """The methods called `CLASSIC`, and a decision tree's if there is one."""
    defaults = [FixedPlan(name, plan) for name, plan in rtsc.METHODS.items()]
    grids = [FixedPlan(name, plan) for name, plan in tuned.plans.items()]
    trees = [] if tree is None else [DecisionTree(tree)]
    return [*defaults, *grids, CannyEdges(tuned.canny), PlainDraw(), *trees]


def learned_methods(models: Mapping[str, Model], preset: str) -> list[Method]:
    """What each model can draw.

    Args:
        models: Label -> model.
        preset: Of the search for thresholds.
    """
    found: list[Method] = []
    for label, model in models.items():
        checkpoint = model.checkpoint
        if checkpoint.regressor is not None:
            found.append(Regressed(row_name(REGRESSOR, label), checkpoint.regressor, checkpoint.preset))
        found += [
            Learned(row_name(image_row(checkpoint) if row == IMAGE else row, label), model, variant, preset)
            for row, variant in VARIANTS.items()
            if variant in model.variants
        ]
    return found


def image_row(checkpoint: Checkpoint) -> str:
    """The paper's name for the row of an image branch, by how it was trained and by what it reads."""
    trained = checkpoint.training.get("stages", {}).get("translator", {})
    if trained.get("objective") == objective_name(Pix2pixHDObjective):
        return PIX2PIXHD
    return IMAGE_INPUTS.get(checkpoint.preset.translation.inputs, IMAGE)


def row_names(models: Mapping[str, Model], with_tree: bool = False) -> list[str]:
    """The names of all rows that are methods."""
    return [*CLASSIC, *([TREE] if with_tree else []), *(method.name for method in learned_methods(models, "draft"))]


def row_name(row: str, label: str) -> str:
    """A model's row: its label tells several models apart; an only one has none."""
    return f"{row}@{label}" if label else row


def labels(checkpoints: Sequence[Path]) -> list[str]:
    """A label for each checkpoint, by which its rows are told apart: "" for an only one.

    Raises:
        ArgumentError: Two of them can't be told apart.
    """
    if len(checkpoints) < 2:
        return [""] * len(checkpoints)
    for names in ([path.stem for path in checkpoints], [_with_folder(path) for path in checkpoints]):
        if _all_differ(names):
            return names
    twice = Counter(_with_folder(path) for path in checkpoints).most_common(1)[0][0]
    raise ArgumentError("model", f"two of the name {twice}", "files of different names, or in folders of such")


def _with_folder(path: Path) -> str:
    return f"{path.resolve().parent.name}-{path.stem}"


def _all_differ(names: Iterable[str]) -> bool:
    counts = Counter(names)
    return max(counts.values()) == 1
