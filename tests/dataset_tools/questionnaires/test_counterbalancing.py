"""Items are dealt to the fewest questionnaires, and places and positions are balanced."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dataset_tools.questionnaires.counterbalancing import DrawingOrder, QuestionOrder, alternate_shapes, assign_items
from ncmodel.data.item import Item


def items(shapes: int, views: int = 2) -> list[Item]:
    return [Item(f"s{shape}", str(view)) for shape in range(shapes) for view in range(views)]


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 40), st.integers(1, 3), st.integers(1, 4), st.integers(1, 30), st.booleans(), st.integers(0, 99))
def test_every_item_gets_its_votes_from_the_fewest_questionnaires(
    shapes: int, views: int, votes: int, size: int, fill: bool, seed: int
) -> None:
    needs = dict.fromkeys(items(shapes, views), votes)
    blocks = assign_items(needs, size, np.random.default_rng(seed), fill)
    size = min(size, len(needs))
    asked = Counter(item for block in blocks for item in block)
    assert all(asked[item] >= votes for item in needs)
    assert len(blocks) == -(-len(needs) * votes // size)
    assert all(len(set(block)) == len(block) for block in blocks)
    assert len({len(block) for block in blocks}) == 1
    if fill:
        assert len(blocks[0]) == size
    else:
        assert sum(asked.values()) - len(needs) * votes < len(blocks)


@settings(max_examples=40, deadline=None)
@given(st.integers(2, 40), st.integers(1, 3), st.integers(1, 30), st.integers(0, 99))
def test_shapes_are_repeated_only_where_they_must_be(shapes: int, views: int, size: int, seed: int) -> None:
    needs = dict.fromkeys(items(shapes, views), 3)
    blocks = assign_items(needs, size, np.random.default_rng(seed), fill=False)
    spare = len(blocks) * len(blocks[0]) - 3 * len(needs)
    at_least = -(-3 * views // len(blocks))  # a shape's votes, spread evenly over the questionnaires
    for block in blocks:
        most = Counter(item.shape for item in block).most_common(1)[0][1]
        assert most <= at_least + (1 if spare else 0)


def test_uneven_needs_are_met_exactly_where_that_is_possible() -> None:
    needs = {Item(f"s{i}", "0"): 1 + i % 3 for i in range(12)}
    blocks = assign_items(needs, 8, np.random.default_rng(0), fill=False)
    asked = Counter(item for block in blocks for item in block)
    assert asked == needs
    assert len(blocks) == 3


def test_nothing_needed_gives_nothing() -> None:
    assert assign_items({Item("a", "0"): 0}, 5, np.random.default_rng(0)) == []


def test_items_stand_at_different_places_each_time() -> None:
    places = QuestionOrder(np.random.default_rng(0))
    names = [f"item {i}" for i in range(35)]
    stood: dict[str, list[int]] = {name: [] for name in names}
    for _ in range(3):
        for place, name in enumerate(places.order(names, names)):
            stood[name].append(place)
    assert all(len(set(found)) == 3 for found in stood.values())
    apart = [
        min(abs(a - b) for a, b in zip(sorted(found), sorted(found)[1:], strict=False)) for found in stood.values()
    ]
    assert np.mean(apart) > 8  # three places at random would be 4.4 apart on average
    assert min(apart) >= 3


def test_every_drawing_meets_every_position_once_in_eight_askings() -> None:
    positions = DrawingOrder(np.random.default_rng(0))
    rows = np.array([positions.order("item") for _ in range(8)])
    assert (np.sort(rows, axis=0) == np.arange(8)[:, None]).all()
    assert (np.sort(rows, axis=1) == np.arange(8)).all()


def test_positions_of_first_askings_are_uniform() -> None:
    positions = DrawingOrder(np.random.default_rng(1))
    counts = Counter(positions.order(number).index(0) for number in range(4000))
    assert max(counts.values()) < 1.2 * 500
    assert min(counts.values()) > 0.8 * 500


@pytest.mark.parametrize("views", [1, 3])
def test_varied_begins_with_all_shapes(views: int) -> None:
    ordered = alternate_shapes(items(7, views), np.random.default_rng(0))
    assert len({item.shape for item in ordered[:7]}) == 7
    assert sorted(ordered) == sorted(items(7, views))
