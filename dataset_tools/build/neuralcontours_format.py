"""Exchange with the published Neural Contours code: the folder of pictures that its scripts read, one a view.

suggestive_contour.png ridge.png valley.png apparent_ridge.png   lines at threshold 0, unfaded, black on white
*_feature.png    16 bit: sin(theta) DwKr, k1, -k1, q1 over their 90th percentile, clipped to 1; background 65535
*_info.txt       "p90 feature_size"
nv.png           16 bit: n.v
smooth_0..5.png  16 bit: shaded maps
depth.png        16 bit
base.png         contours and creases, black on white
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncmodel.errors import InputError
from ncmodel.geometry.shading import interpolate
from ncmodel.images import png_ink, png_map, read_grey
from ncmodel.model.maps import LineMaps, network_maps, unfiltered
from ncmodel.scene.view import View
from ncmodel.types import FILTERED_FAMILIES, Floats, Image, LineFamily

DEFAULT_SIZE = (1024, 768)
"""(width, height) that the published scripts expect."""

NAMES = ("suggestive_contour", "ridge", "valley", "apparent_ridge")
"""In the order of t = (t_S, t_R, t_V, t_A)."""


@dataclass(frozen=True, eq=False)
class ExchangedView:
    """One view, as the published code sees it.

    Attributes:
        lines: (4, H, W) ink of the families' visible lines at threshold 0, unfaded.
        features: (4, H, W) what filters them on the seen surface, over `p90` and clipped to [0, 1]; background 1.
        base: (H, W) ink of contours and creases.
        n_dot_v: (H, W) in [0, 1], background 1.
        maps: (7, H, W) depth and six shaded maps, background 1.
        p90: (4,) the features' units.
        feature_size: What makes strengths dimensionless.
    """

    lines: Image
    features: Image
    base: Image
    n_dot_v: Image
    maps: Image
    p90: Floats
    feature_size: float

    def line_maps(self) -> LineMaps:
        """The lines as our model takes them. What the pictures don't tell apart, creases, counts as contour."""
        on_lines = np.where(self.lines > 0, self.features, 0.0).astype(np.float32)
        return LineMaps(self.lines, on_lines, self.base, np.zeros_like(self.base), self.p90)

    def files(self) -> dict[str, bytes]:
        """The pictures and texts of its folder."""
        files = {"base.png": png_ink(self.base), "nv.png": png_map(self.n_dot_v), "depth.png": png_map(self.maps[0])}
        files |= {f"smooth_{level}.png": png_map(image) for level, image in enumerate(self.maps[1:])}
        for index, name in enumerate(NAMES):
            files[f"{name}.png"] = png_ink(self.lines[index])
            files[f"{name}_feature.png"] = png_map(self.features[index])
            files[f"{name}_info.txt"] = f"{float(self.p90[index])!r} {self.feature_size!r}\n".encode()
        return files

    def arrays(self) -> dict[str, NDArray[Any]]:
        """What an .npz file of it holds: our maps, under the names of `LineMaps`, and `maps`."""
        lines = self.line_maps()
        return {
            "lines": lines.lines,
            "features": lines.features,
            "contours": lines.contours,
            "boundaries": lines.boundaries,
            "p90": lines.p90,
            "maps": self.maps,
            "n_dot_v": self.n_dot_v,
            "feature_size": np.array(self.feature_size),
        }


def exchanged(view: View) -> ExchangedView:
    """A view of ours in the terms of the published code."""
    hit, p90 = view.buffers.hit, np.array([view.feature_percentile(family) for family in FILTERED_FAMILIES])
    lines = np.stack([unfiltered(view, family)[0] for family in FILTERED_FAMILIES])
    features = np.stack([view.feature_map(f) / unit for f, unit in zip(FILTERED_FAMILIES, p90.tolist(), strict=True)])
    features = np.where(hit, np.clip(features, 0.0, 1.0), 1.0).astype(np.float32)
    facing = interpolate(view.buffers, view.surface.faces, view.n_dot_v)
    n_dot_v = np.where(hit, np.clip(facing, 0.0, 1.0), 1.0).astype(np.float32)
    base = np.maximum(*(unfiltered(view, family)[0] for family in (LineFamily.CONTOURS, LineFamily.CREASES)))
    return ExchangedView(lines, features, base, n_dot_v, network_maps(view), p90, float(view.surface.feature_size))


def read_exchanged(folder: str | Path) -> ExchangedView:
    """Read a folder in the published code's format, of any size.

    Raises:
        InputError: A file is missing or damaged, or the pictures differ in size.
    """
    root = Path(folder)
    maps = np.stack(_alike(root, ("depth.png", *(f"smooth_{level}.png" for level in range(6)))))
    lines = [1.0 - image for image in _alike(root, [f"{name}.png" for name in NAMES])]
    features = _alike(root, [f"{name}_feature.png" for name in NAMES])
    base, n_dot_v = _alike(root, ("base.png", "nv.png"))
    shapes = {image.shape for image in (*maps, *lines, *features, base, n_dot_v)}
    if len(shapes) > 1:
        raise InputError(root, f"pictures of the sizes {sorted(shapes)}", "one size")
    infos = [_info(root / f"{name}_info.txt") for name in NAMES]
    p90 = np.array([unit for unit, _ in infos])
    return ExchangedView(np.stack(lines), np.stack(features), 1.0 - base, n_dot_v, maps, p90, infos[0][1])


def _alike(root: Path, names: Sequence[str]) -> list[Image]:
    """(H, W) brightness of each picture."""
    return [read_grey(root / name) for name in names]


def _info(path: Path) -> tuple[float, float]:
    """The two numbers that an info file begins with; the published scripts read no further either."""
    expected = 'two numbers, "p90 feature_size"'
    try:
        p90, feature_size = (float(word) for word in path.read_text(encoding="utf-8").split("\n")[0].split()[:2])
    except OSError as error:
        raise InputError(path, f"can't be read ({error.strerror})", expected) from error
    except ValueError as error:
        raise InputError(path, f"found {path.read_bytes()[:60]!r}", expected) from error
    if not (np.isfinite(p90) and p90 > 0 and np.isfinite(feature_size)):
        raise InputError(path, f"found {p90} {feature_size}", expected)
    return p90, feature_size
