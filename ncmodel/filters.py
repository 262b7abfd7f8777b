"""Line drawings as functions of thresholds: equations 1-5 of the paper, differentiable in t.

The equations hold for each pixel on its own, so the last dimension may list all pixels of a picture or only those that
carry lines; whoever works on whole pictures flattens them. Letters in shapes: B drawings, P pixels.
"""

import torch
from torch import Tensor

SMALLEST_FEATURE = 1e-6
"""Features below this count as this one: they fade within a threshold of a millionth of the 90th percentile, and the
gradient -1/feature stays a number that sums can hold."""


def fade(feature: Tensor, threshold: Tensor) -> Tensor:
    """max(1 - t/feature, 0): the common factor of equations 1-4.

    At t = 0 it's 1 for every feature: all lines are kept. From t = `SMALLEST_FEATURE` on it's 0 where the feature isn't
    positive. The gradient is that of the formula where the factor is above 0, else 0, and finite everywhere.

    Args:
        feature: The quantity that the threshold is compared with, in units of its 90th percentile.
        threshold: t >= 0, broadcast against `feature`.
    """
    return torch.relu(1.0 - threshold / feature.clamp(min=SMALLEST_FEATURE))


def line_drawing(lines: Tensor, features: Tensor, always: Tensor, thresholds: Tensor) -> Tensor:
    """I_G(t) of equation 5, for one or many t.

    Args:
        lines: (4, P) ink of suggestive contours S, ridges R, valleys V and apparent ridges A, unfiltered.
        features: (4, P) Dk, k1, k2 (valleys: positive where concave) and k_t, in units of their 90th percentiles.
        always: (P,) ink of what no threshold filters: the larger of contours I_C and boundaries I_B.
        thresholds: (B, 4) t = (t_S, t_R, t_V, t_A), each at least 0.

    Returns:
        (B, P) ink.

    Raises:
        ValueError: The shapes don't fit together.
    """
    if lines.shape != features.shape or lines.ndim != 2 or len(lines) != 4 or always.shape != lines.shape[1:]:
        shapes = [tuple(part.shape) for part in (lines, features, always)]
        raise ValueError(f"lines, features and always have shapes {shapes}, expected (4, P), (4, P) and (P,)")
    if thresholds.ndim != 2 or thresholds.shape[1] != 4:
        raise ValueError(f"thresholds have shape {tuple(thresholds.shape)}, expected (B, 4)")
    filtered = lines * fade(features, thresholds[:, :, None])
    return torch.maximum(filtered.amax(dim=1), always)
