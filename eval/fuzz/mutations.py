"""Damage to files: what broken disks, cut transfers, bad exporters and enemies do to them."""

import re
from collections.abc import Callable, Sequence

import numpy as np

AGAIN = 0.4
"""How often a file that was changed is changed once more."""

HEADER = 2000
"""Bytes in which half of the changes are: what is said there decides how all else is read."""

_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_NUMBERS = (
    *(b"0", b"-1", b"1", b"3", b"-0.0", b"255", b"256", b"65536", b"2147483647", b"-2147483648", b"4294967296"),
    *(
        b"9223372036854775807",
        b"18446744073709551616",
        b"1e9",
        b"1e308",
        b"1e999",
        b"-1e999",
        b"1e-320",
        b"nan",
        b"inf",
    ),
    *(b"", b"x", b"1.5", b"1" * 400, b"9" * 5000, b"true", b"null", b"[]", b"{}", b'""', b"[" * 3000),
)
_RAW = (
    b"\x00" * 4,
    b"\xff" * 4,
    b"\xff\xff\xff\x7f",
    b"\x00\x00\x00\x80",
    b"\x00\x00\x80\x7f",
    b"\x00\x00\xc0\x7f",
    b"\x01\x00\x00\x00",
)

Damage = Callable[[bytes, bytes, np.random.Generator], bytes]


def _place(data: bytes, rng: np.random.Generator) -> int:
    return int(rng.integers(len(data) if rng.random() < 0.5 else min(len(data), HEADER)))


def flip_bits(data: bytes, other: bytes, rng: np.random.Generator) -> bytes:
    """Up to eight bits turned over."""
    array = np.frombuffer(data, np.uint8).copy()
    for _ in range(rng.integers(1, 9)):
        array[_place(data, rng)] ^= 1 << rng.integers(8)
    return array.tobytes()


def cut_off(data: bytes, other: bytes, rng: np.random.Generator) -> bytes:
    """The end lost, or the beginning."""
    place = _place(data, rng)
    return data[:place] if rng.random() < 0.8 else data[place:]


def splice(data: bytes, other: bytes, rng: np.random.Generator) -> bytes:
    """A stretch put in from another file, or from elsewhere in this one."""
    source = other if rng.random() < 0.5 else data
    begin, length = _place(source, rng), int(rng.integers(1, 200))
    place, lost = _place(data, rng), int(rng.integers(0, 200))
    return data[:place] + source[begin : begin + length] + data[place + lost :]


def repeat(data: bytes, other: bytes, rng: np.random.Generator) -> bytes:
    """A line, or a stretch, again and again."""
    begin, times = _place(data, rng), int(2 ** rng.integers(1, 10))
    end = data.find(b"\n", begin) + 1 or begin + int(rng.integers(1, 60))
    return data[:begin] + data[begin:end] * times + data[end:]


def replace_number(data: bytes, other: bytes, rng: np.random.Generator) -> bytes:
    """A number written out replaced by one that is rarely thought of."""
    found = list(_NUMBER.finditer(data, 0, HEADER if rng.random() < 0.5 else len(data)))
    if not found:
        return overwrite(data, other, rng)
    number = found[rng.integers(len(found))]
    return data[: number.start()] + _NUMBERS[rng.integers(len(_NUMBERS))] + data[number.end() :]


def overwrite(data: bytes, other: bytes, rng: np.random.Generator) -> bytes:
    """Four bytes replaced by those of a number at the edge of its type."""
    place = _place(data, rng)
    return data[:place] + _RAW[rng.integers(len(_RAW))] + data[place + 4 :]


_DAMAGE: tuple[Damage, ...] = (flip_bits, cut_off, splice, repeat, replace_number, replace_number, overwrite)


def damaged(samples: Sequence[bytes], rng: np.random.Generator) -> bytes:
    """One of some valid files after a few changes.

    Args:
        samples: At least one, none empty.
        rng: Decides which, and what is changed.
    """
    data, other = (samples[int(rng.integers(len(samples)))] for _ in range(2))
    for _ in range(rng.geometric(1.0 - AGAIN)):
        if data:
            data = _DAMAGE[int(rng.integers(len(_DAMAGE)))](data, other, rng)
    return data
