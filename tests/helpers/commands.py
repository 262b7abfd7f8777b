"""Commands called in this process, and what they say."""

import json
from typing import Any

import pytest

from ncmodel.cli.main import main


def printed(capsys: pytest.CaptureFixture[str], *arguments: object) -> dict[str, Any]:
    """The object that a command prints with --json."""
    capsys.readouterr()
    assert main([*map(str, arguments), "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert isinstance(record, dict)
    return record


def complaint(capsys: pytest.CaptureFixture[str], *arguments: object, status: int = 2) -> str:
    """The one line that a command refuses its input with; with status 1, the last one, after those of progress."""
    capsys.readouterr()
    assert main([*map(str, arguments)]) == status
    said = capsys.readouterr().err.splitlines()
    assert said[-1].startswith("ncontours: ")
    assert status == 1 or len(said) == 1, said
    return said[-1]
