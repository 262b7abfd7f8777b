"""The stored numbers of one small mesh: `python -m tests.helpers.golden_features` writes them anew.

They hold today's results fast where no reference material is at hand; a change in them needs a reason.
"""

from pathlib import Path

import numpy as np

from ncmodel.camera import Camera
from ncmodel.mesh.load import make_mesh
from ncmodel.scene.feature_arrays import features
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from tests.helpers import analytic

GOLDEN = Path(__file__).parents[1] / "golden" / "features.npz"


def golden_view() -> View:
    """A bumpy torus with a window: curvatures of both signs, every family of lines but intersections."""
    vertices, faces = analytic.torus(24, 14)
    vertices = vertices * (1 + 0.25 * np.sin(18 * vertices[:, :1]) * np.cos(11 * vertices[:, 2:]))
    surface = Surface(make_mesh(vertices, faces[28:], "golden"), sizing="sampled")
    return View(surface, Camera((1.3, 1.1, 2.4)), crease_angle=30.0)


if __name__ == "__main__":
    arrays = features(golden_view())
    small = {key: a.astype(np.float32 if a.dtype.kind == "f" else np.int32) for key, a in arrays.items()}
    np.savez_compressed(GOLDEN, **small)  # type: ignore[arg-type]
