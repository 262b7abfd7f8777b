"""How far a model is a judge: pairs in the right order, order of the 256 candidates, and its probabilities."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from eval.measures.bootstrap import PairAccuracy, pair_accuracy, percentile_interval, resampled_means
from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair
from ncmodel.model.preference import Preference, Reliability, Votes, cross_fitted, fit_preference, reliability
from ncmodel.report.intervals import Interval


@dataclass(frozen=True)
class RankCorrelation:
    """Spearman's correlation of scores with F1 over a view's 256 candidates, the mean over views.

    Attributes:
        value: The mean; None where no view has any.
        interval: Of the mean, over resampled shapes.
        views: How many views it is of: those whose candidates differ in both.
    """

    value: float | None
    interval: Interval | None
    views: int


@dataclass(frozen=True)
class RankerReport:
    """What was found out about one model, by all it goes by or by pictures alone.

    Attributes:
        accuracy: On pairs of the compared views; None without pairs.
        correlation: With F1 over the candidates.
        preference: The temperature that fits all these pairs; None without pairs.
        reliability: Of probabilities whose temperature was fitted on other shapes' votes; None without pairs.
    """

    accuracy: PairAccuracy | None
    correlation: RankCorrelation
    preference: Preference | None
    reliability: Reliability | None

    def to_record(self) -> dict[str, Any]:
        """JSON-ready values."""
        return asdict(self)


def judge_rankers(records: Sequence[Mapping[str, Any]], pairs: Sequence[Pair]) -> dict[str, RankerReport]:
    """What the records of views say of each model as a judge.

    Args:
        records: As `measure_view` wrote them.
        pairs: Ranking pairs, of any items.
    """
    found: dict[str, RankerReport] = {}
    for label in dict.fromkeys(label for record in records for label in record["rankers"]):
        of_view = {Item(r["shape"], r["view"]): r["rankers"][label] for r in records}
        scores = {item: said["scores"] for item, said in of_view.items()}
        mine = [pair for pair in pairs if _judged(scores.get(pair.item, ()), pair)]
        found[label] = RankerReport(_accuracy(mine, scores), _correlation(of_view), *_calibration(mine, scores))
    return found


def _judged(scores: Sequence[float | None], pair: Pair) -> bool:
    """Whether both drawings of a pair have a score."""
    return bool(scores) and scores[pair.better] is not None and scores[pair.worse] is not None


def _ends(pairs: Sequence[Pair], scores: Mapping[Item, Sequence[float]]) -> tuple[list[float], list[float]]:
    better, worse = ([scores[p.item][getattr(p, end)] for p in pairs] for end in ("better", "worse"))
    return better, worse


def _accuracy(pairs: Sequence[Pair], scores: Mapping[Item, Sequence[float]]) -> PairAccuracy | None:
    return pair_accuracy(*_ends(pairs, scores), [pair.item.shape for pair in pairs]) if pairs else None


def _correlation(of_view: Mapping[Item, Mapping[str, Any]]) -> RankCorrelation:
    known = {item: said["rank_correlation"] for item, said in of_view.items() if said["rank_correlation"] is not None}
    if not known:
        return RankCorrelation(None, None, 0)
    values = np.array(list(known.values()))[:, None]
    samples = resampled_means(values, [item.shape for item in known])[:, 0]
    return RankCorrelation(float(values.mean()), percentile_interval(samples), len(known))


def _calibration(
    pairs: Sequence[Pair], scores: Mapping[Item, Sequence[float]]
) -> tuple[Preference | None, Reliability | None]:
    """The temperature that fits all pairs, and how far probabilities are right on shapes that weren't fitted to."""
    if not pairs:
        return None, None
    votes = Votes.of(pairs, *_ends(pairs, scores))
    predicted = cross_fitted(votes, [pair.item.shape for pair in pairs])
    return fit_preference(votes), reliability(predicted, votes.wins, votes.losses)
