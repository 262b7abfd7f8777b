"""View vectors: from points of a surface towards where it is seen from.

A viewpoint is homogeneous, (x, y, z, w): with w = 1 it is an eye, with w = 0 a direction, the same for all points. The
view vector at p is (x, y, z) - w p in both cases, of any length.
"""

import numpy as np

from ncmodel.jit import kernel
from ncmodel.types import Floats


def view_vectors(viewpoint: Floats, points: Floats) -> Floats:
    """(..., 3) from (..., 3) points towards a viewpoint (4,)."""
    return np.asarray(viewpoint[:3] - viewpoint[3] * points)


@kernel
def toward(viewpoint: Floats, x: float, y: float, z: float) -> tuple[float, float, float]:
    """From one point towards a viewpoint (4,)."""
    w = viewpoint[3]
    return viewpoint[0] - w * x, viewpoint[1] - w * y, viewpoint[2] - w * z
