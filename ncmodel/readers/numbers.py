"""Numbers in text files."""

import re
import warnings

import numpy as np

from ncmodel.types import Floats


def numbers(text: bytes) -> Floats:
    """All numbers of a text that holds nothing but numbers and white space.

    Fortran's exponents (1.5D+02) are read, and how Windows wrote what is no number (-1.#IND).

    Raises:
        ValueError: Something in it isn't a number.
    """
    if not text.strip():
        return np.zeros(0)
    try:
        return _plain(text)
    except (DeprecationWarning, ValueError):  # numpy before and from 2.3
        text = re.sub(rb"(?<=[\d.])[dD](?=[-+]?\d)", b"e", text)
        text = re.sub(rb"\b1\.#(?:IND|[QS]?NAN|INF)\d*", b"nan", text)
    try:
        return _plain(text)
    except (DeprecationWarning, ValueError) as error:
        raise ValueError(f"{_stranger(text)!r} among the numbers") from error


def _plain(text: bytes) -> Floats:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return np.fromstring(text, sep=" ")


def _stranger(text: bytes) -> str:
    """The first word that isn't a number, abridged."""
    for word in text.split():
        try:
            float(word)
        except ValueError:
            return word[:40].decode("utf-8", "replace")
    return "something"
