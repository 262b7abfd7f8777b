"""What views' records say of a ranking module."""

import numpy as np
import pytest

from eval.comparison.candidates import rank_correlation
from eval.comparison.rankers import judge_rankers
from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair


def view(shape: str, scores: list[float], correlation: float | None) -> dict[str, object]:
    return {"shape": shape, "view": "0", "rankers": {"m": {"scores": scores, "rank_correlation": correlation}}}


def pairs_of(shape: str, split: str = "validation") -> list[Pair]:
    return [Pair(Item(shape, "0"), 0, worse, split, votes_for=3, votes=4) for worse in (1, 2)]  # type: ignore[arg-type]


def test_pairs_correlations_and_probabilities_of_the_compared_views_count() -> None:
    records = [view("cow", [3.0, 1.0, 2.0], 0.5), view("fox", [1.0, 2.0, 0.0], 0.1), view("owl", [0.0] * 3, None)]
    found = judge_rankers(records, [*pairs_of("cow"), *pairs_of("fox"), *pairs_of("elk", "train")])["m"]
    assert found.accuracy is not None
    assert (found.accuracy.accuracy, found.accuracy.pairs, found.accuracy.shapes) == (0.75, 4, 2)
    assert found.correlation.value == pytest.approx(0.3)
    assert found.correlation.views == 2
    assert found.preference is not None
    assert found.reliability is not None
    assert 0.0 <= found.reliability.error <= 1.0


def test_without_votes_on_the_views_only_the_order_is_judged() -> None:
    found = judge_rankers([view("cow", [1.0, 0.0], None)], pairs_of("fox"))["m"]
    assert (found.accuracy, found.preference, found.reliability, found.correlation.value) == (None, None, None, None)


def test_rank_correlation_is_spearmans() -> None:
    f1 = np.array([0.1, 0.4, 0.2, 0.9])
    assert rank_correlation(np.array([1.0, 30.0, 2.0, 31.0]), f1) == pytest.approx(1.0)
    assert rank_correlation(np.array([4.0, 2.0, 3.0, 1.0]), f1) == pytest.approx(-1.0)
    # 1 - 6 (1 + 1) / (4 * 15): two neighbours in the wrong order.
    assert rank_correlation(np.array([2.0, 3.0, 1.0, 4.0]), f1) == pytest.approx(0.8)
    assert rank_correlation(np.ones(4), f1) is None
