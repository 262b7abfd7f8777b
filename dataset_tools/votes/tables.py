"""Tables (CSV) as people hand them on: what a spreadsheet makes of one when it saves it is read as well."""

import csv
import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

from ncmodel.errors import InputError

MAX_FIELD = 256 * 1024 * 1024
"""Characters in one field; embedded pictures make long ones."""

BYTE_ORDER_MARK = "\ufeff"

_SEPARATORS = (",", ";", "\t", "|")
_SEPARATOR_LINE = re.compile(r'"?sep=(.)"?[,;\t]*', re.IGNORECASE)
"""A first line by which spreadsheets are told the separator; they don't show it as a row."""

_NUMBER_OR_ERROR = re.compile(r"[+-]?\d([.,]\d+)?E[+-]?\d+|\d{10,}|#\S+|Err:\d+")
"""A number that was a text of many digits, and errors as different programs and languages write them."""

_SPREADSHEETS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
"""How files of .xlsx and .ods, and of .xls, begin."""


@contextmanager
def open_table(path: Path, columns: Sequence[str], errors: str = "strict") -> Iterator[Iterator[list[str]]]:
    """The rows of a table, streamed, the header first.

    Encoding (UTF-8, UTF-16) and separator (comma, semicolon, tab, bar) are told from the file's beginning.

    Args:
        path: The file.
        columns: Names in its header, by which the separator is known.
        errors: What to do with bytes that are no text, as `open` takes it.

    Raises:
        InputError: It is a spreadsheet program's own file.
        OSError: It can't be read.
    """
    csv.field_size_limit(min(MAX_FIELD, sys.maxsize))
    with path.open(encoding=_encoding(path), errors=errors, newline="") as file:
        separator = _separator(file, columns)
        yield csv.reader(file, delimiter=separator)


def is_separator_row(cells: Sequence[str]) -> bool:
    """Whether a row is the line that tells the separator, of another file that was put behind the first one."""
    return cells[0].strip('" ').lower() == "sep=" and not any(cell.strip('" ') for cell in cells[1:])


def looks_mangled(cell: str) -> bool:
    """Whether a cell is a number or an error that a spreadsheet made of a text which looked like a number."""
    return _NUMBER_OR_ERROR.fullmatch(cell) is not None


def _encoding(path: Path) -> str:
    with path.open("rb") as file:
        head = file.read(64)
    if head.startswith(_SPREADSHEETS):
        raise InputError(path, "a spreadsheet program's own file", "a table saved as CSV")
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    # Text in Latin letters has a zero in every pair of bytes.
    if len(head) >= 4 and not any(head[1::2]):
        return "utf-16-le"
    if len(head) >= 4 and not any(head[0::2]):
        return "utf-16-be"
    return "utf-8-sig"


def _separator(file: TextIO, columns: Sequence[str]) -> str:
    """The separator; the file is left where its header begins."""
    first = file.readline()
    while first and not first.strip():
        first = file.readline()
    told = _SEPARATOR_LINE.fullmatch(first.rstrip("\r\n"))
    if told:
        return told[1]
    file.seek(0)
    for separator in _SEPARATORS:
        cells = next(csv.reader([first], delimiter=separator), [])
        if set(columns) <= {cell.strip() for cell in cells}:
            return separator
    return ","
