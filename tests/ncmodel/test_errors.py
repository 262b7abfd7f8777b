"""Errors survive the way from a worker process."""

import pickle

import pytest

from ncmodel.errors import BatchError, InputError, MeshError, UsageError


@pytest.mark.parametrize(
    "error",
    [InputError("a.obj", "two\nlines", "one line"), MeshError("a.obj", "x", "y"), UsageError("no"), BatchError("1")],
)
def test_an_error_is_the_same_after_pickling(error: Exception) -> None:
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is type(error)
    assert str(copy) == str(error)
    assert vars(copy) == vars(error)
