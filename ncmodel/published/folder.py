"""The folder of pictures that the published scripts read, one a view.

suggestive_contour.png ridge.png valley.png apparent_ridge.png   lines at threshold 0, unfaded, black on white
*_feature.png    16 bit: sin(theta) DwKr, k1, -k1, q1 over their 90th percentile, clipped to 1; background 65535
*_info.txt       "p90 feature_size"
nv.png           16 bit: n.v
smooth_0..5.png  16 bit: shaded maps
depth.png        16 bit
base.png         contours and creases, black on white
boundaries.png   boundaries, black on white: ours alone, the scripts don't read it and it may be missing
"""

import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncmodel.errors import InputError
from ncmodel.images import png_ink, png_map, read_grey
from ncmodel.model.maps import LineMaps
from ncmodel.nets.presets import CURVATURE_MAPS, MAPS
from ncmodel.types import Floats, Image

WIDTH, HEIGHT = 1024, 768
"""Of the pictures that the published scripts take."""

NAMES = ("suggestive_contour", "ridge", "valley", "apparent_ridge")
"""In the order of t = (t_S, t_R, t_V, t_A)."""


@dataclass(frozen=True, eq=False)
class PublishedView:
    """One view, as the published code sees it.

    Attributes:
        lines: (4, H, W) ink of the families' visible lines at threshold 0, unfaded.
        features: (4, H, W) what filters them on the seen surface, over `p90` and clipped to [0, 1]; background 1.
        base: (H, W) ink of contours and creases.
        boundaries: (H, W) ink of boundaries, which the published code doesn't draw.
        n_dot_v: (H, W) in [0, 1], background 1.
        maps: (7, H, W) depth and six shaded maps, background 1.
        p90: (4,) the features' units.
        feature_size: What makes strengths dimensionless.
    """

    lines: Image
    features: Image
    base: Image
    boundaries: Image
    n_dot_v: Image
    maps: Image
    p90: Floats
    feature_size: float

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
        return self.base.shape[1], self.base.shape[0]

    def line_maps(self) -> LineMaps:
        """The lines as the paper's equations take them. What the pictures don't tell apart, creases, is contour."""
        on_lines = np.where(self.lines > 0, self.features, 0.0).astype(np.float32)
        return LineMaps(self.lines, on_lines, self.base, self.boundaries, self.p90)

    def network_maps(self, inputs: Sequence[str]) -> Image:
        """(K, H, W) the maps of these names."""
        known = dict(zip((*MAPS, *CURVATURE_MAPS), (*self.maps, *self.features), strict=True))
        return np.stack([known[name] for name in inputs])

    def files(self) -> dict[str, bytes]:
        """The pictures and texts of its folder."""
        files = {"base.png": png_ink(self.base), "nv.png": png_map(self.n_dot_v), "depth.png": png_map(self.maps[0])}
        files["boundaries.png"] = png_ink(self.boundaries)
        files |= {f"smooth_{level}.png": png_map(image) for level, image in enumerate(self.maps[1:])}
        for index, name in enumerate(NAMES):
            files[f"{name}.png"] = png_ink(self.lines[index])
            files[f"{name}_feature.png"] = png_map(self.features[index])
            files[f"{name}_info.txt"] = f"{float(self.p90[index])!r} {self.feature_size!r}\n".encode()
        return files

    def arrays(self) -> dict[str, NDArray[Any]]:
        """What an .npz file of it holds: our maps under the names of `LineMaps`, and what else there is."""
        lines = self.line_maps()
        return {
            "lines": lines.lines,
            "features": lines.features,
            "feature_maps": self.features,
            "contours": lines.contours,
            "boundaries": lines.boundaries,
            "p90": lines.p90,
            "maps": self.maps,
            "n_dot_v": self.n_dot_v,
            "feature_size": np.array(self.feature_size),
        }


def read_maps(path: str | Path) -> PublishedView:
    """Read a folder in the published layout, or the .npz file that `ncontours dataset import` makes of one.

    Raises:
        InputError: As `read_folder` does, or the file isn't such a one.
    """
    if Path(path).suffix.lower() != ".npz":
        return read_folder(path)
    expected = "an .npz file that `ncontours dataset import` wrote"
    try:
        with np.load(path) as file:
            arrays = {key: file[key] for key in file.files}
        return PublishedView(
            lines=arrays["lines"],
            features=arrays["feature_maps"],
            base=arrays["contours"],
            boundaries=arrays["boundaries"],
            n_dot_v=arrays["n_dot_v"],
            maps=arrays["maps"],
            p90=arrays["p90"],
            feature_size=float(arrays["feature_size"]),
        )
    except OSError as error:
        raise InputError(path, f"can't be read ({error.strerror or error})", expected) from error
    except (ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
        raise InputError(path, f"damaged or of another kind ({error})", expected) from error


def read_folder(folder: str | Path) -> PublishedView:
    """Read a folder in the published layout, of any size.

    Raises:
        InputError: A file is missing or damaged, or the pictures differ in size.
    """
    root = Path(folder)
    if not root.is_dir():
        raise InputError(root, "no such folder", "a folder of maps, as `ncontours dataset export` writes it")
    maps = np.stack(_alike(root, ("depth.png", *(f"smooth_{level}.png" for level in range(6)))))
    lines = [_ink(image) for image in _alike(root, [f"{name}.png" for name in NAMES])]
    features = _alike(root, [f"{name}_feature.png" for name in NAMES])
    base, n_dot_v = _alike(root, ("base.png", "nv.png"))
    boundaries = root / "boundaries.png"
    bounds = read_grey(boundaries) if boundaries.exists() else np.ones_like(base)
    shapes = {image.shape for image in (*maps, *lines, *features, base, n_dot_v, bounds)}
    if len(shapes) > 1:
        raise InputError(root, f"pictures of the sizes {sorted(shapes)}", "one size")
    infos = [_info(root / f"{name}_info.txt") for name in NAMES]
    p90 = np.array([unit for unit, _ in infos])
    # The published scripts take the feature size from the first of the four.
    size = infos[0][1]
    return PublishedView(np.stack(lines), np.stack(features), _ink(base), _ink(bounds), n_dot_v, maps, p90, size)


def _alike(root: Path, names: Sequence[str]) -> list[Image]:
    """(H, W) brightness of each picture."""
    return [read_grey(root / name) for name in names]


def _ink(image: Image) -> Image:
    """(H, W) ink of an 8-bit picture with black lines, rounded once."""
    return (1.0 - np.rint(image.astype(np.float64) * 255.0) / 255.0).astype(np.float32)


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
