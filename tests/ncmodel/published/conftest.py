"""A view in the published layout, of the published size, made of random strokes on a smooth ball."""

import numpy as np
import pytest
from scipy import ndimage

from ncmodel.published.folder import HEIGHT, WIDTH, PublishedView


@pytest.fixture(scope="session")
def published() -> PublishedView:
    """Lines with random features, maps of a ball with waves."""
    rng = np.random.default_rng(7)
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    reach = np.hypot(rows - HEIGHT / 2, columns - WIDTH / 2) / 330
    hit = reach < 1
    cosine = np.sqrt(np.clip(1 - reach**2, 0, 1)).astype(np.float32)

    def on(values: np.ndarray) -> np.ndarray:
        stored = np.rint(np.clip(values, 0, 1) * 65535) / 65535
        return np.where(hit, stored, 1.0).astype(np.float32)

    waves = 0.1 * np.sin(columns / 17) * np.cos(rows / 23)
    maps = np.stack([on(0.5 + 0.3 * reach), *(on(cosine + waves / (level + 1)) for level in range(6))])
    noise = [ndimage.gaussian_filter(rng.normal(size=(HEIGHT, WIDTH)), 9) * 30 for _ in range(5)]
    ink = [np.rint(np.clip(1.5 - 20 * np.abs(part), 0, 1) * 255) / 255 * hit for part in noise]
    features = np.stack([on(np.abs(np.roll(part, 40, axis=1))) for part in noise[:4]])
    base = ink[4].astype(np.float32)
    lines = np.stack(ink[:4]).astype(np.float32)
    boundaries, p90 = np.zeros_like(base), np.array([3000.0, 60.0, 45.0, 4000.0])
    return PublishedView(lines, features, base, boundaries, on(cosine), maps, p90, 0.02)
