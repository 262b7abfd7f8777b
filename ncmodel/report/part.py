"""What one part of the project measured, for reports that gather several."""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Part:
    """Numbers, as a table for people and a record for programs.

    Attributes:
        name: Its key in the record of a report.
        title: Its heading.
        text: What the numbers are.
        rows: The table, its head first.
        record: All numbers.
    """

    name: str
    title: str
    text: str
    rows: Sequence[Sequence[str]]
    record: object
