"""Choosing the most distinct drawings."""

import itertools
import sys
from pathlib import Path

import kmedoids
import numpy as np
import pytest

from dataset_tools.candidates.candidates import CandidateThresholds, draw_candidates
from dataset_tools.candidates.k_medoids import RESTARTS, select
from dataset_tools.candidates.viewpoints import camera_at, choose_azimuths
from dataset_tools.cleaning.repair import clean_file
from ncmodel.chamfer import chamfer_matrix
from ncmodel.errors import UsageError
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Floats


def distances_between(points: Floats) -> Floats:
    return np.asarray(np.linalg.norm(points[:, None] - points[None], axis=-1))


def loss_of(distances: Floats, medoids: tuple[int, ...]) -> float:
    return float(distances[:, list(medoids)].min(axis=1).sum())


@pytest.mark.parametrize("seed", range(5))
def test_the_best_of_all_choices_is_found(seed: int) -> None:
    distances = distances_between(np.random.default_rng(seed).random((14, 2)))
    best = min(itertools.combinations(range(14), 4), key=lambda medoids: loss_of(distances, medoids))
    selection = select(distances, count=4)
    assert selection.loss == pytest.approx(loss_of(distances, best))
    assert selection.medoids.tolist() == list(best)


def test_labels_and_loss_say_what_was_chosen() -> None:
    distances = distances_between(np.random.default_rng(1).random((40, 3)))
    selection = select(distances)
    nearest = distances[:, selection.medoids]
    assert (nearest[np.arange(40), selection.labels] == nearest.min(axis=1)).all()
    assert selection.loss == pytest.approx(nearest.min(axis=1).sum())
    assert selection.labels[selection.medoids].tolist() == list(range(8))
    assert selection.distinct == 40


def test_identical_drawings_are_never_chosen_twice() -> None:
    rng = np.random.default_rng(2)
    # 9 different drawings, most of them one and the same many times over.
    points = rng.random((9, 2))[np.concatenate([np.arange(9), np.zeros(200, dtype=int)])]
    order = rng.permutation(len(points))
    distances = distances_between(points[order])
    selection = select(distances)
    assert selection.distinct == 9
    chosen = distances[np.ix_(selection.medoids, selection.medoids)]
    assert (chosen[~np.eye(8, dtype=bool)] > 0).all()


def test_a_repeat_is_represented_by_its_first_occurrence() -> None:
    distances = distances_between(np.repeat(np.random.default_rng(3).random((10, 2)), 5, axis=0))
    assert (select(distances).medoids % 5 == 0).all()


@pytest.mark.parametrize(("different", "expected"), [(1, [0] * 8), (3, [0, 1, 2, 0, 1, 2, 0, 1]), (8, list(range(8)))])
def test_too_few_different_drawings_are_all_chosen_and_then_repeated(different: int, expected: list[int]) -> None:
    points = np.arange(20.0)[:, None] % different
    selection = select(distances_between(points))
    assert selection.medoids.tolist() == expected
    assert selection.distinct == different
    assert selection.loss == 0.0
    assert selection.labels.tolist() == [int(i % different) for i in range(20)]


def test_the_same_seed_chooses_the_same() -> None:
    distances = distances_between(np.random.default_rng(4).random((60, 2)))
    assert select(distances, seed=5).medoids.tolist() == select(distances, seed=5).medoids.tolist()


def test_no_random_start_of_a_hundred_does_better() -> None:
    distances = distances_between(np.random.default_rng(6).random((264, 2)))
    starts = (kmedoids.fasterpam(distances, 8, random_state=seed, n_cpu=1).loss for seed in range(100))
    assert select(distances).loss <= 1.001 * min(starts)
    assert RESTARTS < 100


@pytest.mark.parametrize("count", [0, 6])
def test_counts_that_make_no_sense_are_refused(count: int) -> None:
    with pytest.raises(UsageError, match=f"can't choose {count} of 5"):
        select(np.zeros((5, 5)), count=count)


@pytest.mark.slow
def test_no_random_start_of_a_hundred_does_better_on_twenty_real_views(
    shared: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ratios = []
    for path in sorted((shared / "meshes" / "clean").glob("*.obj"))[:10]:
        mesh, _ = clean_file(path)
        surface = Surface(mesh)
        for azimuth in choose_azimuths(mesh.name, 2):
            candidates = draw_candidates(View(surface, camera_at(mesh, azimuth, (768, 768))), CandidateThresholds())
            distances = chamfer_matrix(candidates.masks, candidates.members)
            best = min(kmedoids.fasterpam(distances, 8, random_state=seed, n_cpu=1).loss for seed in range(100))
            ratios.append(select(distances).loss / best)
    with capsys.disabled():
        above = sum(ratio > 1 for ratio in ratios)
        sys.stdout.write(
            f"\nloss over the best of 100 starts: worst {max(ratios):.6f}, {above} of {len(ratios)} above 1\n"
        )
    assert len(ratios) == 20
    assert max(ratios) <= 1.001
