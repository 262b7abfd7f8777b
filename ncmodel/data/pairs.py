"""Ranking pairs: what participants' votes come to, what the model learns from, and the file between them."""

import json
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from ncmodel.data.item import DRAWINGS, Item
from ncmodel.errors import InputError
from ncmodel.files import write_text
from ncmodel.parsing import parse_json

Split = Literal["train", "validation"]

_REQUIRED = ("shape", "view", "better", "worse", "split")


@dataclass(frozen=True)
class Pair:
    """Participants found drawing `better` of an item better than drawing `worse`.

    Attributes:
        item: The item.
        better: Index 0..7 of the drawing.
        worse: Index 0..7 of the other one.
        split: "train" or "validation".
        votes_for: Votes for `better`; None if unknown.
        votes: Votes on the item that count; None if unknown.
        source: Where the item's votes came from, several joined by "+"; "" if unknown.
    """

    item: Item
    better: int
    worse: int
    split: Split
    votes_for: int | None = None
    votes: int | None = None
    source: str = ""

    def to_record(self) -> dict[str, object]:
        """The pair as one JSON object; what is unknown is left out."""
        record = {
            **self.item.record,
            "better": self.better,
            "worse": self.worse,
            "votes_for": self.votes_for,
            "votes": self.votes,
            "split": self.split,
            "source": self.source or None,
        }
        return {key: value for key, value in record.items() if value is not None}


def write_pairs(path: Path, pairs: Iterable[Pair]) -> None:
    """Write a pairs.jsonl: one JSON object a line."""
    write_text(path, "".join(json.dumps(pair.to_record()) + "\n" for pair in pairs))


def read_pairs(path: str | Path) -> list[Pair]:
    """Read a pairs.jsonl; `votes_for`, `votes` and `source` may be missing in it.

    Raises:
        InputError: The file can't be read, a line isn't a pair, or a shape is in both splits.
    """
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(path, f"can't be read ({error.strerror})", "a file of ranking pairs") from error
    except UnicodeDecodeError as error:
        raise InputError(path, f"not UTF-8 text ({error.reason})", "a file of ranking pairs") from error
    pairs = [_pair(f"{path}:{row}", line) for row, line in enumerate(text.splitlines(), 1) if line.strip()]
    both = {p.item.shape for p in pairs if p.split == "train"} & {p.item.shape for p in pairs if p.split != "train"}
    if both:
        raise InputError(path, f"shape {min(both)!r} is in both splits", "each shape trained on or held out")
    return pairs


def _pair(where: str, line: str) -> Pair:
    """One line of a pairs.jsonl."""
    expected = f"an object with {', '.join(_REQUIRED)}"
    try:
        record = parse_json(line)
    except ValueError as error:
        raise InputError(where, f"not JSON ({error})", expected) from error
    if not isinstance(record, dict) or not set(_REQUIRED) <= set(record):
        raise InputError(where, f"found {line[:80]}", expected)
    item = Item(_name(where, "shape", record["shape"]), _name(where, "view", record["view"]))
    better, worse = (_index(where, key, record[key]) for key in ("better", "worse"))
    if better == worse:
        raise InputError(where, f"better and worse are both {better}", "two different drawings")
    if record["split"] not in ("train", "validation"):
        raise InputError(where, f"split is {record['split']!r}", '"train" or "validation"')
    votes_for, votes = (_count(where, key, record.get(key)) for key in ("votes_for", "votes"))
    source = record.get("source", "")
    if not isinstance(source, str):
        raise InputError(where, f"source is {source!r}", "text")
    return Pair(item, better, worse, record["split"], votes_for, votes, source)


def _name(where: str, key: str, value: Any) -> str:
    """A part of a folder name, which must not lead out of the folder."""
    text = str(value) if isinstance(value, int | str) and not isinstance(value, bool) else ""
    if not text or "/" in text or "\\" in text or "\0" in text:
        raise InputError(where, f"{key} is {value!r}", "a name or a number")
    return text


def _index(where: str, key: str, value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < DRAWINGS:
        raise InputError(where, f"{key} is {value!r}", f"a drawing 0..{DRAWINGS - 1}")
    return value


def _count(where: str, key: str, value: Any) -> int | None:
    if value is not None and (not isinstance(value, int) or isinstance(value, bool) or value < 0):
        raise InputError(where, f"{key} is {value!r}", "a number of votes")
    return value


def best_drawings(pairs: Sequence[Pair]) -> dict[Item, int]:
    """Each item's best drawing: the one that wins most pairs and, among several, has the lowest index."""
    wins = Counter((pair.item, pair.better) for pair in pairs)
    best: dict[Item, int] = {}
    for (item, drawing), _ in sorted(wins.items(), key=lambda entry: (-entry[1], entry[0])):
        best.setdefault(item, drawing)
    return best
