"""Training of the Geometry-Regressor: cross-entropy between I_G(t) and the drawing that people chose (appendix 4).

Only pixels that carry lines depend on t, so the loss is a mean over those of each view, at the resolution that lines
are drawn at. Where a family's line has faded away, t has no influence and its gradient is 0; as t stays below the
largest feature, there are always pixels left that have one.
"""

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor, nn

from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair, best_drawings
from ncmodel.errors import InputError
from ncmodel.images import read_grey
from ncmodel.model.filters import line_drawing
from ncmodel.model.maps import line_maps
from ncmodel.nets.devices import device_of
from ncmodel.nets.losses import ink_cross_entropy
from ncmodel.nets.presets import Preset
from ncmodel.nets.regressor import GeometryRegressor, MeshGraph
from ncmodel.training.batches import Poses, Stored, cut, draw_poses, even_chunks, items_of, load_batch, shuffled
from ncmodel.training.dataset import ViewImages
from ncmodel.training.loader import Examiner
from ncmodel.training.objectives import SCALE_VIEWS
from ncmodel.training.state import Measures
from ncmodel.types import Image, Ints

KEPT_VIEWS = 256
"""Views whose lines are kept in memory; each has some 0.5 MB of them."""


@dataclass(frozen=True, eq=False)
class ViewLines:
    """What of a view depends on t: P pixels that carry filtered lines.

    Attributes:
        graph: The mesh.
        pixels: (P,) flat indices of them.
        shape: (height, width) of the picture.
        lines: (4, P) ink of S, R, V, A, unfiltered.
        features: (4, P) what filters them, in units of the 90th percentiles.
        always: (P,) ink of contours and boundaries.
    """

    graph: MeshGraph
    pixels: Ints
    shape: tuple[int, int]
    lines: Tensor
    features: Tensor
    always: Tensor

    @property
    def largest(self) -> Tensor:
        """(4,) the largest feature along each family's lines; 0 for none."""
        return self.features.amax(dim=1) if len(self.pixels) else self.features.new_zeros(len(self.features))

    def on(self, device: torch.device) -> "ViewLines":
        """The same on a device."""
        tensors = (part.to(device) for part in (self.lines, self.features, self.always))
        return ViewLines(self.graph, self.pixels, self.shape, *tensors)


class LineImages(ViewImages):
    """The pictures of a data folder's views, and the lines of its meshes.

    Args:
        images: The same without lines.
    """

    def __init__(self, images: ViewImages) -> None:
        super().__init__(images.data, images.sizes, images.cache_bytes, images.inputs, images.percentile)
        self._lines: OrderedDict[Item, ViewLines] = OrderedDict()

    def for_one_of(self, workers: int) -> "LineImages":
        """See `ViewImages.for_one_of`."""
        return LineImages(super().for_one_of(workers))

    def view_lines(self, item: Item) -> ViewLines:
        """The lines of a view, computed from its mesh when they are first asked for."""
        if item not in self._lines:
            self._lines[item] = self._view_lines(item)
        self._lines.move_to_end(item)
        if len(self._lines) > KEPT_VIEWS:
            self._lines.popitem(last=False)
        return self._lines[item]

    def chosen(self, item: Item, index: int) -> Tensor:
        """(P,) ink of one of the eight drawings at the pixels of `view_lines`.

        Raises:
            InputError: The drawing hasn't the view's size.
        """
        lines, path = self.view_lines(item), self.data.drawing_path(item, index)
        ink = 1.0 - read_grey(path)
        if ink.shape != lines.shape:
            found, wanted = (f"{shape[1]} x {shape[0]} pixels" for shape in (ink.shape, lines.shape))
            raise InputError(path, found, f"{wanted}, as the view's camera has")
        return torch.from_numpy(ink.ravel()[lines.pixels])

    def _view_lines(self, item: Item) -> ViewLines:
        view = self.data.open_view(item)
        maps = line_maps(view, percentile=self.percentile)
        graph = MeshGraph.of(view.mesh.vertices, view.surface.normals, view.mesh.faces)
        pixels = np.flatnonzero(maps.lines.any(axis=0))

        def there(pictures: Image) -> Tensor:
            return torch.from_numpy(pictures.reshape(*pictures.shape[:-2], -1)[..., pixels])

        always = np.maximum(maps.contours, maps.boundaries)
        return ViewLines(graph, pixels, always.shape, there(maps.lines), there(maps.features), there(always))


@dataclass(frozen=True, eq=False)
class LineBatch:
    """Some views with their lines, and the ink that they should have.

    Attributes:
        maps: (B, K, S, S) what is seen of them.
        graph: Their meshes.
        views: Their lines.
        ink: (P,) of each view's chosen drawing, at the pixels that carry lines.
    """

    maps: Tensor
    graph: MeshGraph
    views: tuple[ViewLines, ...]
    ink: tuple[Tensor, ...]


@dataclass(frozen=True, eq=False)
class StoredLines:
    """A `LineBatch` as it is handed between processes."""

    pictures: Stored
    views: tuple[ViewLines, ...]
    ink: tuple[Tensor, ...]

    def on(self, device: torch.device) -> LineBatch:
        """The batch, on a device."""
        graph = MeshGraph.together([view.graph for view in self.views]).on(device)
        views, ink = tuple(v.on(device) for v in self.views), tuple(ink.to(device) for ink in self.ink)
        return LineBatch(self.pictures.on(device).maps, graph, views, ink)


@dataclass(frozen=True)
class LinePart:
    """Views that are looked at at once, each with the drawing that was chosen.

    Attributes:
        views: They.
        size: Side of their maps, pixels.
        poses: How the maps are shown; the thresholds stay the same.
    """

    views: tuple[tuple[Item, int], ...]
    size: int
    poses: Poses

    def __len__(self) -> int:
        return len(self.views)

    def cut(self, count: int) -> "list[LinePart]":
        """Up to `count` parts, of nearly the same length."""
        return [LinePart(tuple(part), self.size, self.poses) for part in cut(self.views, count)]

    def load(self, images: LineImages) -> StoredLines:
        """What they show."""
        pictures = load_batch(images, self.views, self.size, self.poses)
        lines = tuple(images.view_lines(item) for item, _ in self.views)
        return StoredLines(pictures, lines, tuple(images.chosen(*view) for view in self.views))


class RegressorObjective:
    """Cross-entropy between I_G(t) of the predicted thresholds and each view's best drawing."""

    name = "regressor"
    pretrained = False

    def __init__(self, preset: Preset, regressor: GeometryRegressor, images: LineImages, pairs: Sequence[Pair]) -> None:
        self.preset, self.regressor, self.images = preset, regressor, images
        best = best_drawings(pairs)
        held_out = {pair.item for pair in pairs if pair.split == "validation"}
        self.training = [(item, best[item]) for item in sorted(best) if item not in held_out]
        self.held_out = [(item, best[item]) for item in sorted(best) if item in held_out]
        self.networks: dict[str, nn.Module] = {"regressor": regressor}
        self.rates, self.averaging = preset.rates("regressor"), preset.averaging

    def prepare(self) -> None:
        """Measure the input scales."""
        stored = load_batch(self.images, self.training[:SCALE_VIEWS], self.regressor.size)
        encoder = self.regressor.image
        encoder.standardise.fit(encoder.pick(stored.on(device_of(self.regressor)).maps))

    def steps(self, rng: np.random.Generator) -> Sequence[LinePart]:
        """One step a few views."""
        size, variation = self.regressor.size, self.preset.variation
        chunks = even_chunks(shuffled(self.training, rng), self.rates.batch)
        return [LinePart(tuple(c), size, draw_poses(items_of(c), variation, size, rng)) for c in chunks]

    def loss(self, batch: LineBatch) -> Tensor:
        """The cross-entropy."""
        largest = torch.stack([view.largest for view in batch.views])
        thresholds = self.regressor(batch.graph, batch.maps, largest)
        return torch.stack(
            [drawing_loss(*each) for each in zip(batch.views, thresholds, batch.ink, strict=True)]
        ).mean()

    @torch.no_grad()
    def validate(self, examiner: Examiner) -> Measures:
        """Mean cross-entropy."""
        if not self.held_out:
            return {}
        self.regressor.eval()

        def loss(stored: StoredLines) -> Tensor:
            return self.loss(stored.on(device_of(self.regressor)))

        parts = [LinePart((view,), self.regressor.size, {}) for view in self.held_out]
        return {"cross_entropy": float(torch.stack(examiner.answers(parts, loss)).mean())}

    def loss_of(self, measures: Measures) -> float:
        """The cross-entropy."""
        return measures["cross_entropy"]


def drawing_loss(view: ViewLines, thresholds: Tensor, ink: Tensor) -> Tensor:
    """How surprised I_G(t) of (4,) thresholds is by a drawing, given as (P,) ink; 0 for a view without lines."""
    if not len(ink):
        return thresholds.sum() * 0.0
    return ink_cross_entropy(line_drawing(view.lines, view.features, view.always, thresholds[None])[0], ink)
