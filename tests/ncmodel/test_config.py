"""Settings go to TOML and back, and bad files get one clear line."""

from dataclasses import dataclass, field
from pathlib import Path

import pytest

from ncmodel.config import read_config, write_config
from ncmodel.errors import InputError


@dataclass(frozen=True)
class Inner:
    level: float = 0.5


@dataclass(frozen=True)
class Outer:
    size: tuple[int, int] = (768, 768)
    levels: tuple[float, ...] = (0.1, 1.0)
    name: str = "a"
    limit: int | None = None
    inner: Inner = field(default_factory=Inner)

    def __post_init__(self) -> None:
        if min(self.size) < 1:
            raise ValueError(f"size is {self.size}, expected positive sides")


def test_settings_survive_the_round_trip(tmp_path: Path) -> None:
    settings = Outer(size=(4, 5), levels=(1.0, 2.0, 3.0), limit=7, inner=Inner(0.25))
    path = tmp_path / "config.toml"
    path.write_text(write_config(settings), encoding="utf-8")
    assert read_config(Outer, path) == settings


def test_keys_left_out_keep_their_defaults_and_whole_numbers_become_floats(tmp_path: Path) -> None:
    path = tmp_path / "config.toml"
    path.write_text("levels = [1, 2]\n[inner]\nlevel = 3\n", encoding="utf-8")
    assert read_config(Outer, path) == Outer(levels=(1.0, 2.0), inner=Inner(3.0))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("sizes = [1, 2]", "unknown key 'sizes'"),
        ("[inner]\nlevels = 1", "unknown key 'levels'"),
        ("size = [1, 2, 3]", "size has 3 values"),
        ("size = [0, 2]", "size is"),
        ("name = 3", "name is 3"),
        ("limit = true", "limit is True"),
        ("size = ", "not TOML"),
    ],
)
def test_bad_files_are_named_with_what_was_found(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "config.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message) as caught:
        read_config(Outer, path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"absent\.toml: can't be read"):
        read_config(Outer, tmp_path / "absent.toml")
