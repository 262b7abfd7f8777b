"""Numbers in text files."""

import warnings

import numpy as np

from ncmodel.types import Floats


def numbers(text: bytes) -> Floats:
    """All numbers of a text that holds nothing but numbers and white space.

    Raises:
        ValueError: Something in it isn't a number.
    """
    if not text.strip():
        return np.zeros(0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return np.fromstring(text, sep=" ")
        except (DeprecationWarning, ValueError) as error:  # numpy before and from 2.3
            raise ValueError(f"{_stranger(text)!r} among the numbers") from error


def _stranger(text: bytes) -> str:
    """The first word that isn't a number, abridged."""
    for word in text.split():
        try:
            float(word)
        except ValueError:
            return word[:40].decode("utf-8", "replace")
    return "something"
