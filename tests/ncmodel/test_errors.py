"""Errors survive the way from a worker process, and name what their reader knows: a parameter or an option."""

import ast
import pickle
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from ncmodel.errors import ArgumentError, BatchError, InputError, MeshError, UsageError


@pytest.mark.parametrize(
    "error",
    [
        InputError("a.obj", "two\nlines", "one line"),
        MeshError("a.obj", "x", "y"),
        UsageError("no"),
        ArgumentError("held_out", "2", "a share"),
        BatchError("1"),
    ],
)
def test_an_error_is_the_same_after_pickling(error: Exception) -> None:
    copy = pickle.loads(pickle.dumps(error))
    assert type(copy) is type(error)
    assert str(copy) == str(error)
    assert vars(copy) == vars(error)


def test_an_argument_is_a_parameter_in_python_and_an_option_at_the_command_line() -> None:
    error = ArgumentError("held_out", "2", "a share")
    assert str(error) == "held_out: found 2, expected a share"
    assert error.as_option == "--held-out: found 2, expected a share"


ROOT = Path(__file__).parents[2]


def test_the_library_does_not_speak_of_options() -> None:
    spoken = re.compile(r"--[a-z]+(-[a-z]+)*( |:|$)")
    library = [
        path for package in ("ncmodel", "dataset_tools", "eval") for path in sorted((ROOT / package).rglob("*.py"))
    ]
    said = {
        (str(path.relative_to(ROOT)), text)
        for path in library
        if "cli" not in path.parts
        for text in _said(ast.parse(path.read_text(encoding="utf-8")))
    }
    assert len(said) > 300
    assert [text for text in said if spoken.search(text[1])] == []


def _said(tree: ast.AST) -> Iterator[str]:
    """The constant parts of all texts that a module raises or appends to its notes."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Raise) or (isinstance(node, ast.Call) and ast.unparse(node.func).endswith(".append")):
            for part in ast.walk(node):
                if isinstance(part, ast.Constant) and isinstance(part.value, str):
                    yield part.value


def test_what_is_said_is_found() -> None:
    assert list(_said(ast.parse('raise UsageError(f"see --restart {x}")'))) == ["see --restart "]
