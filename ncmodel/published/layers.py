"""The layers that settings choose among, of a view of which only the folder of maps is known."""

import numpy as np
import torch

from ncmodel.drawing.settings import LayeredDrawings, Levels
from ncmodel.published.folder import PublishedView
from ncmodel.published.scoring import filtered, strengths
from ncmodel.types import FILTERED_FAMILIES, Image, LineFamily


def layers_of(view: PublishedView) -> LayeredDrawings:
    """All layers of a view; contours and creases, which share a picture, are the layer that is always drawn."""
    levels = Levels()
    plain = {LineFamily.CONTOURS: view.base, LineFamily.BOUNDARIES: view.boundaries}
    ink = np.zeros((len(levels.layers), *view.base.shape), dtype=np.float32)
    for image, layer in zip(ink, levels.layers, strict=True):
        at = filtered_lines(view, [layer.threshold] * len(FILTERED_FAMILIES))
        for family in layer.families:
            lines = at[FILTERED_FAMILIES.index(family)] if family in FILTERED_FAMILIES else plain.get(family, image)
            np.maximum(image, lines, out=image)
    return LayeredDrawings(levels, ink)


def filtered_lines(view: PublishedView, thresholds: list[float]) -> Image:
    """(4, H, W) ink that thresholds in rtsc's units leave of each family, by the published filter."""
    parts = torch.from_numpy(view.lines), torch.from_numpy(strengths(view)), torch.from_numpy(view.n_dot_v)
    lines, strength, facing = (part.flatten(-2) for part in parts)
    left = filtered(lines, strength, facing, torch.tensor([thresholds]))[0]
    return np.asarray(left.reshape(view.lines.shape).numpy())
