"""Chances that answers are even."""

import pytest
from scipy.stats import chisquare

from dataset_tools.votes.agreement import evenness


@pytest.mark.parametrize("counts", [(1, 2, 3, 4, 5, 6, 7, 8), (0, 0, 0, 9), (3, 3, 3), (1, 0), (40, 20, 20, 20)])
def test_evenness_is_pearsons_chi_square_test(counts: tuple[int, ...]) -> None:
    assert evenness(counts) == pytest.approx(chisquare(counts).pvalue, rel=1e-12)
