"""The file of ranking pairs: what is written is read again, and bad lines are named."""

import json
from pathlib import Path

import pytest

from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair, best_drawings, read_pairs, write_pairs
from ncmodel.errors import InputError

GOOD = {"shape": "s000", "view": 0, "better": 1, "worse": 2, "votes_for": 2, "votes": 3, "split": "train"}


def write(path: Path, *records: object) -> Path:
    lines = [record if isinstance(record, str) else json.dumps(record) for record in records]
    path.write_text("\n".join(lines))
    return path


def test_pairs_are_read_as_they_were_written(tmp_path: Path) -> None:
    pairs = [
        Pair(Item("cow", "0"), 1, 2, "train", votes_for=2, votes=3, source="mturk+site"),
        Pair(Item("gear_2", "front"), 7, 0, "validation"),
    ]
    write_pairs(tmp_path / "pairs.jsonl", pairs)
    assert read_pairs(tmp_path / "pairs.jsonl") == pairs
    first, second = (tmp_path / "pairs.jsonl").read_text().splitlines()
    assert first == (
        '{"shape": "cow", "view": 0, "better": 1, "worse": 2, "votes_for": 2, "votes": 3, "split": "train", '
        '"source": "mturk+site"}'
    )
    assert second == '{"shape": "gear_2", "view": "front", "better": 7, "worse": 0, "split": "validation"}'


def test_blank_lines_a_byte_order_mark_and_crlf_are_fine(tmp_path: Path) -> None:
    path = tmp_path / "pairs.jsonl"
    path.write_bytes(b"\xef\xbb\xbf" + json.dumps(GOOD).encode() + b"\r\n\r\n")
    assert read_pairs(path) == [Pair(Item("s000", "0"), 1, 2, "train", votes_for=2, votes=3)]


@pytest.mark.parametrize(
    ("record", "complaint"),
    [
        ("{", "not JSON"),
        ("[1, 2]", r"found \[1, 2\]"),
        ({"shape": "a"}, "found"),
        ({**GOOD, "better": 8}, "better is 8; expected a drawing 0..7"),
        ({**GOOD, "worse": True}, "worse is True"),
        ({**GOOD, "worse": 1.0}, "worse is 1.0"),
        ({**GOOD, "worse": 1}, "better and worse are both 1"),
        ({**GOOD, "split": "test"}, "split is 'test'"),
        ({**GOOD, "shape": "../../etc"}, "shape is '../../etc'"),
        ({**GOOD, "shape": ""}, "shape is ''"),
        ({**GOOD, "view": 1.5}, "view is 1.5"),
        ({**GOOD, "votes": "3"}, "votes is '3'; expected a number of votes"),
        ({**GOOD, "votes_for": -1}, "votes_for is -1"),
        ({**GOOD, "source": 1}, "source is 1"),
    ],
)
def test_bad_lines_are_named_with_their_number(tmp_path: Path, record: object, complaint: str) -> None:
    path = write(tmp_path / "pairs.jsonl", GOOD, record)
    with pytest.raises(InputError, match=f"pairs.jsonl:2: {complaint}"):
        read_pairs(path)


def test_files_that_are_no_pairs(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="can't be read"):
        read_pairs(tmp_path / "missing.jsonl")
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(InputError, match="not UTF-8"):
        read_pairs(tmp_path / "binary")
    with pytest.raises(InputError, match="'s000' is in both splits"):
        read_pairs(write(tmp_path / "both", GOOD, {**GOOD, "view": 1, "split": "validation"}))


def test_best_drawings_win_most_pairs() -> None:
    item, other = Item("a", "0"), Item("b", "0")
    pairs = [Pair(item, better, worse, "train") for better, worse in [(3, 1), (3, 2), (1, 2)]]
    pairs += [Pair(other, better, worse, "train") for better, worse in [(5, 1), (4, 2)]]
    assert best_drawings(pairs) == {item: 3, other: 4}
