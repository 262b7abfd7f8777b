"""Settings of one's own in a TOML file: rates, batches, passes, how views are varied, the averaging of weights.

averaging = 0.98

[ranker]            # or translator, finetune, statistics
learning_rate = 1e-3
batch = 32
epochs = 48

[variation]
mirror = true
quarter_turns = true
shift = 0.04
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from ncmodel.errors import InputError
from ncmodel.nets.presets import Preset, Rates, Variation
from ncmodel.parsing import parse_toml

STAGES = {"ranker": "ranker", "translator": "translator", "finetune": "finetune", "statistics": "counting"}
"""Table -> what the preset calls it."""

_TABLES: dict[str, type] = {**dict.fromkeys(STAGES, Rates), "variation": Variation}
_VALUES: dict[str, tuple[type, Callable[[Any], bool], str]] = {
    "learning_rate": (float, lambda value: 0 < value < math.inf, "a positive number"),
    "batch": (int, lambda value: value >= 1, "a whole number of at least 1"),
    "epochs": (int, lambda value: value >= 1, "a whole number of at least 1"),
    "mirror": (bool, lambda _: True, "true or false"),
    "quarter_turns": (bool, lambda _: True, "true or false"),
    "shift": (float, lambda value: 0 <= value <= 0.5, "a share of the side, 0 to 0.5"),
    "averaging": (float, lambda value: 0 <= value < 1, "a number of at least 0 and below 1"),
}
"""Key -> type, what fits, and how that is said."""


def as_published(preset: Preset) -> Preset:
    """The preset without what the paper doesn't have: varied views, averaged weights, the ranker on numbers.

    Curvature is measured in its 90th percentile over the mesh, as the paper's text says.
    """
    variation = Variation(mirror=False, quarter_turns=False, shift=0.0)
    return replace(preset, variation=variation, averaging=0.0, statistics=None, percentile="mesh")


def with_settings(preset: Preset, path: str | Path) -> Preset:
    """The preset with what a TOML file says in place of its own numbers.

    Raises:
        InputError: The file can't be read, or has an unknown key or a value that makes no sense.
    """
    try:
        found = parse_toml(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(path, f"can't be read ({error.strerror})", "a TOML file of training settings") from error
    except ValueError as error:
        raise InputError(path, f"not TOML ({error})", "a TOML file of training settings") from error
    for key, value in found.items():
        if key == "averaging":
            preset = replace(preset, averaging=_checked(path, key, key, value))
        elif key in _TABLES:
            name = STAGES.get(key, key)
            known = [field.name for field in fields(_TABLES[key])]
            preset = replace(preset, **{name: replace(getattr(preset, name), **_table(path, key, value, known))})
        else:
            raise InputError(path, f"unknown key {key!r}", f"averaging, or a table: {', '.join(_TABLES)}")
    return preset


def _table(path: str | Path, table: str, found: Any, known: list[str]) -> dict[str, Any]:
    if not isinstance(found, Mapping):
        raise InputError(path, f"{table} is {found!r}", f"a table [{table}] with some of {', '.join(known)}")
    for key in found:
        if key not in known:
            raise InputError(path, f"unknown key {key!r} in [{table}]", f"some of {', '.join(known)}")
    return {key: _checked(path, f"{table}.{key}", key, value) for key, value in found.items()}


def _checked(path: str | Path, name: str, key: str, value: Any) -> Any:
    kind, fits, expected = _VALUES[key]
    if kind is float and type(value) is int:
        value = float(value)
    if type(value) is not kind or not fits(value):
        raise InputError(path, f"{name} is {value!r}", expected)
    return value
