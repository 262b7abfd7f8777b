"""Pen travel: the order in which strokes are drawn."""

import itertools

import numpy as np
import pytest

from ncmodel.export.linesort import BRANCHES, pen_order
from ncmodel.types import Floats, Stroke
from tests.helpers.strokes import pen_reversed


def lines(ends: Floats) -> list[Stroke]:
    return [Stroke("ridges", pair, np.ones(2)) for pair in ends]


def nearest_first(ends: Floats) -> Floats:
    """The greedy tour, by looking at every end that is left."""
    at, left, path = np.zeros(2), list(range(len(ends))), []
    while left:
        off = np.linalg.norm(ends[left] - at, axis=2)
        n, back = np.unravel_index(off.argmin(), off.shape)
        stroke = ends[left.pop(int(n))]
        path.append(stroke[::-1] if back else stroke)
        at = path[-1][1]
    return np.array(path)


@pytest.mark.parametrize("count", [1, 2, BRANCHES // 2, BRANCHES // 2 + 1, 100, 513])
@pytest.mark.parametrize("spread", ["even", "clustered", "on a line", "at one point"])
def test_the_nearest_end_is_next(count: int, spread: str) -> None:
    rng = np.random.default_rng(count)
    centres = rng.uniform(0, 768, (count, 1, 2))
    if spread == "clustered":
        centres[: count // 2] = 300 + 1e-3 * centres[: count // 2]
        centres[-1] = 1e6
    ends = centres + rng.normal(0, 5, (count, 2, 2))
    ends *= np.array({"on a line": [1.0, 0.0], "at one point": [0.0, 0.0]}.get(spread, [1.0, 1.0]))
    drawn = np.array([stroke.points for stroke in pen_order(lines(ends))])
    np.testing.assert_array_equal(drawn, nearest_first(ends))


def test_no_strokes() -> None:
    assert pen_order([]) == ()


def test_pen_order_draws_the_same_with_less_travel() -> None:
    rng = np.random.default_rng(6)
    made = []
    for centre in rng.uniform(0, 768, (80, 2)):
        points = centre + rng.normal(0, 20, (3, 2))
        made.append(Stroke("ridges", points, rng.random(3)))
    ordered = pen_order(made)

    def travel(items: list[Stroke] | tuple[Stroke, ...]) -> float:
        return sum(float(np.linalg.norm(b.points[0] - a.points[-1])) for a, b in itertools.pairwise(items))

    def key(stroke: Stroke) -> bytes:
        forwards, back = stroke.points.tobytes() + stroke.alpha.tobytes(), pen_reversed(stroke)
        return min(forwards, back.points.tobytes() + back.alpha.tobytes())

    assert sorted(map(key, ordered)) == sorted(map(key, made))
    assert travel(ordered) < 0.35 * travel(made)
