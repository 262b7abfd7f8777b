"""Distances of pixels to drawn ones."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra.numpy import array_shapes, arrays

from ncmodel.export.distance_transform import distance_to
from ncmodel.types import Mask
from tests.helpers.oracles import pixel_distances

masks = arrays(np.bool_, array_shapes(min_dims=2, max_dims=2, max_side=16))


@given(masks)
def test_distances_equal_brute_force(mask: Mask) -> None:
    if not mask.any():
        with pytest.raises(ValueError, match="empty"):
            distance_to(mask)
        return
    everywhere = np.ones_like(mask)
    expected = pixel_distances(everywhere, mask).min(axis=1).reshape(mask.shape)
    np.testing.assert_allclose(distance_to(mask), expected, rtol=1e-6)


def test_last_bits_do_not_depend_on_how_they_were_rounded(monkeypatch: pytest.MonkeyPatch) -> None:
    mask = np.zeros((500, 800), dtype=np.bool_)
    mask[3, 5] = True
    expected = distance_to(mask)
    rows, columns = np.indices(mask.shape)
    np.testing.assert_array_equal(expected, np.sqrt(((rows - 3) ** 2 + (columns - 5) ** 2).astype(np.float32)))
    transform = cv2.distanceTransform
    for toward in (np.float32(0), np.float32(np.inf)):
        monkeypatch.setattr(cv2, "distanceTransform", lambda *a, t=toward: np.nextafter(transform(*a), t))
        np.testing.assert_array_equal(distance_to(mask), expected)
