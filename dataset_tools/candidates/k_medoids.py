"""The most distinct drawings of a view: k-medoids on the matrix of their distances."""

from dataclasses import dataclass

import numpy as np

from ncmodel.chamfer import DEFINITION
from ncmodel.data.item import DRAWINGS
from ncmodel.errors import UsageError
from ncmodel.types import Floats, Ints

RESTARTS = 16
"""Random starts of FasterPAM; the best result counts. 6 ms each for 264 drawings."""


@dataclass(frozen=True, eq=False)
class Selection:
    """The drawings chosen to stand for all candidates of a view.

    Attributes:
        medoids: (k,) indices of the chosen candidates, ascending among the distinct ones.
        labels: (N,) position in `medoids` of the chosen candidate nearest to each candidate.
        loss: Sum over the candidates of the distance to the nearest chosen one, pixels.
        distinct: How many different drawings the candidates hold. Where they are fewer than k, all of them are chosen
            and the places left over repeat them in order.
    """

    medoids: Ints
    labels: Ints
    loss: float
    distinct: int

    def to_record(self) -> dict[str, object]:
        """What `selection.json` holds."""
        return {
            "medoids": self.medoids.tolist(),
            "labels": self.labels.tolist(),
            "loss": self.loss,
            "distinct": self.distinct,
            "distance": DEFINITION,
        }


def select(distances: Floats, count: int = DRAWINGS, seed: int = 0, restarts: int = RESTARTS) -> Selection:
    """Choose the `count` candidates that minimise the sum of distances to the nearest chosen one (FasterPAM).

    Identical drawings (distance 0) are chosen twice only when the candidates hold fewer than `count` different ones.

    Args:
        distances: (N, N) symmetric, zero diagonal.
        count: How many to choose.
        seed: Of the random starts.
        restarts: Number of random starts, besides the greedy one (BUILD).

    Raises:
        UsageError: `count` is not in 1..N.

    References:
        Schubert, Rousseeuw: Fast and Eager k-Medoids Clustering. Information Systems 101, 2021.
    """
    if not 1 <= count <= len(distances):
        raise UsageError(f"can't choose {count} of {len(distances)} drawings, expected 1..{len(distances)}")
    original = _first_identical(distances)
    distinct = np.unique(original)
    if len(distinct) <= count:
        medoids = np.resize(distinct, count)
    else:
        medoids = np.unique(original[_best_medoids(distances, count, seed, restarts)])
        medoids = _without_repeats(distances, distinct, medoids, count)
    nearest = distances[:, medoids]
    labels = np.argmin(nearest, axis=1)
    return Selection(medoids, labels.astype(np.int64), float(nearest.min(axis=1).sum()), len(distinct))


def _first_identical(distances: Floats) -> Ints:
    """(N,) index of the first drawing at distance 0 from each drawing."""
    return np.asarray(np.argmax(distances == 0.0, axis=1), dtype=np.int64)


def _best_medoids(distances: Floats, count: int, seed: int, restarts: int) -> Ints:
    import kmedoids  # which imports scikit-learn: over a second, for nothing where no view is made

    runs = [kmedoids.fasterpam(distances, count, init="build", n_cpu=1)]
    for start in np.random.default_rng(seed).integers(0, 2**31, restarts):
        runs.append(kmedoids.fasterpam(distances, count, init="random", random_state=int(start), n_cpu=1))
    return np.asarray(min(runs, key=lambda run: run.loss).medoids, dtype=np.int64)


def _without_repeats(distances: Floats, distinct: Ints, medoids: Ints, count: int) -> Ints:
    """Fill places lost to repeats with the distinct drawing farthest from the chosen ones.

    A local optimum has no repeats, since any drawing not chosen yet lowers the loss; an iteration limit could leave
    one.
    """
    while len(medoids) < count:
        farthest = distinct[np.argmax(distances[np.ix_(distinct, medoids)].min(axis=1))]
        medoids = np.sort(np.append(medoids, farthest))
    return medoids
