"""Files that are nested without end are told like any others that can't be read."""

from collections.abc import Callable
from pathlib import Path

import pytest

from dataset_tools.build.manifest import read_manifest
from dataset_tools.questionnaires.questionnaire import read_key
from ncmodel.camera import Camera
from ncmodel.config import read_config
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.data.pairs import read_pairs
from ncmodel.errors import InputError
from ncmodel.nets.preset_settings import with_settings
from ncmodel.nets.presets import PRESETS, Variation
from ncmodel.parsing import parse_json, parse_toml

DEPTH = 100_000


@pytest.mark.parametrize("text", ["[" * DEPTH, '{"a":' * DEPTH, "[" * DEPTH + "]" * DEPTH])
def test_endless_json_is_a_value_error(text: str) -> None:
    with pytest.raises(ValueError, match="nested too deeply"):
        parse_json(text)


@pytest.mark.parametrize("text", ["a = " + "[" * DEPTH, "a = " + "{a = " * DEPTH])
def test_endless_toml_is_a_value_error(text: str) -> None:
    with pytest.raises(ValueError, match="nested too deeply"):
        parse_toml(text)


@pytest.mark.parametrize(
    ("name", "read"),
    [
        ("pairs.jsonl", read_pairs),
        ("camera.json", Camera.load),
        ("key.json", lambda path: read_key(path.parent)),
        ("config.toml", lambda path: read_config(Variation, path)),
        ("training.toml", lambda path: with_settings(PRESETS["tiny"], path)),
        ("selection.json", lambda path: DataFolder(path.parents[2]).medoids(Item("a", "0"))),
    ],
)
def test_files_nested_without_end_are_one_line(tmp_path: Path, name: str, read: Callable[[Path], object]) -> None:
    path = tmp_path / ("views/a_0/selection.json" if name == "selection.json" else name)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(("a = " if path.suffix == ".toml" else "") + "[" * DEPTH, encoding="utf-8")
    with pytest.raises(InputError, match=rf"{name}.*(nested too deeply|ValueError)") as raised:
        read(path)
    assert "\n" not in str(raised.value)


def test_a_manifest_nested_without_end_is_none(tmp_path: Path) -> None:
    (tmp_path / "manifest.json").write_text('{"files":' * DEPTH, encoding="utf-8")
    assert read_manifest(tmp_path) is None
