"""JSON and TOML of anybody's making."""

import json
import tomllib
from typing import Any

_ENDLESS = "nested too deeply"


def parse_json(text: str | bytes, **options: Any) -> Any:
    """What a JSON text holds.

    Args:
        text: The text.
        options: As `json.loads` takes them.

    Raises:
        ValueError: It isn't JSON, or nested more deeply than can be read.
    """
    try:
        return json.loads(text, **options)
    except RecursionError as error:
        raise ValueError(_ENDLESS) from error


def parse_toml(text: str) -> dict[str, Any]:
    """What a TOML text holds.

    Raises:
        ValueError: It isn't TOML, or nested more deeply than can be read.
    """
    try:
        return tomllib.loads(text)
    except RecursionError as error:
        raise ValueError(_ENDLESS) from error
