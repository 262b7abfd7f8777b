"""A device beside the CPU; without a GPU, the CPU beside itself."""

import pytest
import torch

from eval.benchmark.devices import Comparison, compare, random_view
from ncmodel.errors import UsageError
from ncmodel.nets.blocks import WIDE
from ncmodel.nets.presets import RankingDims

pytestmark = pytest.mark.usefixtures("one_thread")

SMALL = RankingDims(size=48, width=WIDE, blocks=(1, 1))


def test_the_view_has_lines_of_all_families_on_a_shape() -> None:
    maps, lines = random_view()
    assert 0.3 < (maps[0] < 1).mean() < 0.7
    assert all(0.005 < family.mean() < 0.2 for family in lines.lines)
    assert (lines.lines.max(axis=0) <= (maps[0] < 1)).all()


def test_the_cpu_agrees_with_itself() -> None:
    found = compare("cpu", SMALL, "draft")
    assert found.cpu.score == found.other.score
    assert (found.score_difference, found.gradient_difference, found.ink_difference) == (0.0, 0.0, 0.0)
    assert found.search_difference == pytest.approx(0.0, abs=1e-6)  # the same drawing at two places of a batch
    assert found.cpu.gradient_seconds > 0.0
    assert any(abs(part) > 1e-6 for part in found.cpu.gradient)
    with pytest.raises(UsageError, match="device: found 'abacus'"):
        compare("abacus", SMALL, "draft")


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs cuda")
def test_a_gpu_finds_what_the_cpu_finds() -> None:
    found: Comparison = compare("cuda", SMALL, "balanced")
    assert found.score_difference < 1e-4
    assert found.gradient_difference < 1e-2
    assert abs(found.search_difference) < 0.02 * abs(found.cpu.search_score)
    assert found.other.peak_megabytes > 0.0
