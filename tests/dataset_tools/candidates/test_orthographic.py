"""Candidates and renderings of orthographic views are those of perspective ones from very far away."""

import numpy as np

from dataset_tools.candidates.candidates import CandidateThresholds, draw_candidates
from dataset_tools.candidates.renders import shaded_picture
from ncmodel.types import Mesh
from tests.helpers.views import bumpy, parallel_and_far

SIDE = 96


def test_candidates_agree_with_perspective_from_very_far() -> None:
    here, far = (draw_candidates(view, CandidateThresholds()) for view in parallel_and_far(Mesh(*bumpy()), SIDE))
    assert here.masks.any(axis=(1, 2)).sum() > 10
    assert np.mean(here.masks != far.masks) < 0.01 * np.mean(here.masks)


def test_renderings_agree_with_perspective_from_very_far() -> None:
    here, far = (shaded_picture(view.surface, view.camera) for view in parallel_and_far(Mesh(*bumpy()), SIDE))
    assert here.min() < 150
    assert np.abs(here.astype(int) - far).max() <= 2
