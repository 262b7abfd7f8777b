"""Settings as frozen dataclasses, read from and written to TOML."""

import dataclasses
import types
import typing
from pathlib import Path
from typing import Any, TypeVar

from ncmodel.errors import InputError
from ncmodel.parsing import parse_toml

C = TypeVar("C")


def read_config(kind: type[C], path: str | Path) -> C:
    """Read settings from a TOML file; keys that are left out keep their defaults.

    Args:
        kind: A frozen dataclass of numbers, strings, booleans, tuples of these, and nested dataclasses.
        path: The TOML file; a nested dataclass is a table.

    Raises:
        InputError: The file is missing, isn't TOML, has an unknown key, or a value of the wrong type.
    """
    expected = f"TOML with some of the keys {', '.join(field.name for field in dataclasses.fields(_checked(kind)))}"
    try:
        table = parse_toml(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(path, f"can't be read ({error.strerror})", expected) from error
    except ValueError as error:
        raise InputError(path, f"not TOML ({error})", expected) from error
    return _from_table(kind, table, path)


def write_config(config: Any) -> str:
    """The settings as TOML text, all keys resolved, `None` values left out."""
    import tomli_w

    return tomli_w.dumps(_to_table(config))


def _checked(kind: type[Any]) -> type[Any]:
    if not dataclasses.is_dataclass(kind):
        raise TypeError(f"{kind} is not a dataclass")
    return kind


def _from_table(kind: type[C], table: dict[str, Any], path: str | Path) -> C:
    hints = typing.get_type_hints(kind)
    fields = {field.name for field in dataclasses.fields(_checked(kind))}
    unknown = sorted(set(table) - fields)
    if unknown:
        raise InputError(path, f"unknown key {unknown[0]!r}", f"some of {', '.join(sorted(fields))}")
    values = {key: _convert(hints[key], value, key, path) for key, value in table.items()}
    try:
        return kind(**values)
    except ValueError as error:
        raise InputError(path, str(error), "settings that make sense") from error


def _convert(hint: Any, value: Any, key: str, path: str | Path) -> Any:
    if dataclasses.is_dataclass(hint) and isinstance(value, dict):
        return _from_table(hint, value, path)  # type: ignore[arg-type]
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        (inner,) = [argument for argument in arguments if argument is not type(None)]
        return _convert(inner, value, key, path)
    if origin is tuple and isinstance(value, list):
        inner = arguments[0]
        if arguments[-1] is not Ellipsis and len(value) != len(arguments):
            raise InputError(path, f"{key} has {len(value)} values", f"{len(arguments)}")
        return tuple(_convert(inner, item, key, path) for item in value)
    if hint is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    wanted = hint if isinstance(hint, type) else origin
    if not isinstance(value, wanted) or (isinstance(value, bool) and wanted is not bool):
        raise InputError(path, f"{key} is {value!r}", f"a value of type {getattr(wanted, '__name__', wanted)}")
    return value


def _to_table(config: Any) -> dict[str, Any]:
    table: dict[str, Any] = {}
    for field in dataclasses.fields(config):
        value = getattr(config, field.name)
        if value is not None:
            table[field.name] = _plain(value)
    return table


def _plain(value: Any) -> Any:
    if dataclasses.is_dataclass(value):
        return _to_table(value)
    if isinstance(value, tuple | list):
        return [_plain(item) for item in value]
    return value
