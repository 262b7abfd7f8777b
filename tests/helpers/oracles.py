"""Brute-force versions of what the project computes cleverly: slow, obvious, for small inputs."""

import numpy as np

from ncmodel.types import Floats, Ints, Mask


def pixel_distances(a: Mask, b: Mask) -> Floats:
    """(|A|, |B|) Euclidean distances between the pixels of two masks."""
    difference = np.argwhere(a)[:, None, :] - np.argwhere(b)[None, :, :]
    distances: Floats = np.sqrt((difference.astype(np.float64) ** 2).sum(axis=2))
    return distances


def drawing_measures(a: Mask, b: Mask, tolerance: float) -> dict[str, float]:
    """Precision, recall, IoU and Chamfer of mask A against B, from all pairs of pixels; neither may be empty."""
    distances = pixel_distances(a, b)
    near_a = int((distances.min(axis=1) <= tolerance).sum())
    near_b = int((distances.min(axis=0) <= tolerance).sum())
    return {
        "precision": near_a / int(a.sum()),
        "recall": near_b / int(b.sum()),
        "iou": (near_a + near_b) / int(a.sum() + b.sum()),
        "chamfer": (distances.min(axis=1).mean() + distances.min(axis=0).mean()) / 2.0,
    }


def traced(vertices: Floats, faces: Ints, origin: Floats, direction: Floats) -> tuple[float, int]:
    """The nearest of all triangles along a ray, by Cramer's rule; its distance and index."""
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    columns = np.stack([b - a, c - a, np.broadcast_to(-direction, a.shape)], axis=2)
    with np.errstate(all="ignore"):
        u, v, t = np.linalg.solve(columns, (origin - a)[..., None])[..., 0].T
    t = np.where((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0), t, np.inf)
    return float(t.min()), int(t.argmin()) if np.isfinite(t.min()) else -1
