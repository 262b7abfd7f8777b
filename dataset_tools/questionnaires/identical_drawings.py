"""Twins: drawings of a view that are one and the same picture.

A view whose candidates hold fewer than eight different drawings shows some of them twice. A vote for either of two
twins counts for both, and no ranking pair is made of them.
"""

import filecmp
from collections.abc import Mapping, Sequence
from pathlib import Path

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import DRAWINGS, Item
from ncmodel.errors import InputError

Twins = tuple[int, ...]
"""For each of the 8 drawings the first that is the same picture: itself, unless it is a twin of an earlier one."""

ALL_DIFFERENT: Twins = tuple(range(DRAWINGS))


def find_twins(pictures: Sequence[Path]) -> Twins:
    """Which picture files hold the same bytes: for each the first that does.

    Raises:
        InputError: One can't be read.
    """
    try:
        return tuple(
            next(j for j in range(i + 1) if j == i or filecmp.cmp(pictures[j], pictures[i], shallow=False))
            for i in range(len(pictures))
        )
    except OSError as error:
        raise InputError(error.filename, f"can't be read ({error.strerror})", "a drawing") from error


def item_twins(data: DataFolder, item: Item) -> Twins:
    """Which of an item's drawings are the same picture.

    Raises:
        InputError: One can't be read.
    """
    return find_twins(data.drawing_paths(item))


def items_to_ask_about(data: DataFolder) -> list[Item]:
    """The items whose drawings aren't all one and the same, in the data folder's order.

    Raises:
        InputError: There is none.
    """
    found = [item for item in data.items() if len(distinct(item_twins(data, item))) > 1]
    if not found:
        raise InputError(data.root, "the eight drawings of every view are one", "drawings to choose from")
    return found


def distinct(twins: Twins) -> list[int]:
    """The drawings without those that repeat an earlier one."""
    return sorted(set(twins))


def distinct_pictures(pictures: Sequence[Path]) -> list[Path]:
    """The picture files without those that repeat an earlier one.

    Raises:
        InputError: One can't be read.
    """
    return [pictures[index] for index in distinct(find_twins(pictures))]


def to_record(twins: Twins) -> dict[str, int]:
    """As JSON: only drawings that repeat an earlier one, with which."""
    return {str(index): first for index, first in enumerate(twins) if first != index}


def from_record(record: Mapping[str, int]) -> Twins:
    """From JSON.

    Raises:
        ValueError: A drawing doesn't repeat an earlier one that repeats none.
    """
    twins = list(ALL_DIFFERENT)
    for index, first in record.items():
        if str(first) in record or not (0 <= first < int(index) < DRAWINGS):
            raise ValueError(f"drawing {index} is said to repeat drawing {first}")
        twins[int(index)] = first
    return tuple(twins)


def to_text(twins: Twins) -> str:
    """As a cell, "4=0 5=1" where drawing 4 repeats drawing 0 and 5 repeats 1."""
    return " ".join(f"{index}={first}" for index, first in to_record(twins).items())


def from_text(text: str) -> Twins:
    """From a cell.

    Raises:
        ValueError: It is none.
    """
    parts = [part.partition("=") for part in text.split()]
    return from_record({index: int(first) for index, _, first in parts}) if parts else ALL_DIFFERENT
