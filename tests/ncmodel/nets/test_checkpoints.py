"""Checkpoints say what they hold, and bad ones are refused in one line."""

from pathlib import Path

import pytest
import safetensors.torch
import torch

from ncmodel.errors import InputError
from ncmodel.nets.checkpoints import (
    MODEL_KIND,
    Checkpoint,
    load_checkpoint,
    load_tensors,
    save_checkpoint,
    save_tensors,
)
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.translation import TranslationBranch
from tests.helpers.micro_training import MICRO, run

pytestmark = pytest.mark.usefixtures("one_thread")


def checkpoint(path: Path) -> Path:
    save_checkpoint(path, Checkpoint(MICRO, ranker=RankingModule(MICRO.ranking)))
    return path


def test_checkpoints_go_to_disk_and_back(tmp_path: Path) -> None:
    ranker, translator = RankingModule(MICRO.ranking), TranslationBranch(MICRO.translation)
    save_checkpoint(tmp_path / "m", Checkpoint(MICRO, ranker, translator, training={"seed": 3}))
    loaded = load_checkpoint(tmp_path / "m")
    assert loaded.training == {"seed": 3}
    assert loaded.ranker is not None
    assert not loaded.ranker.training
    for network, other in zip((ranker, translator), loaded.networks.values(), strict=True):
        for name, value in network.state_dict().items():
            assert torch.equal(other.state_dict()[name], value)


def test_files_that_are_no_checkpoints_are_refused_in_a_line(data: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file; expected a neural-contours model"):
        load_checkpoint(tmp_path / "none")
    for name, content in (
        ("empty", b""),
        ("text", b"hello there"),
        ("cut", checkpoint(tmp_path / "m").read_bytes()[:500]),
    ):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError, match=r"not a safetensors file .*; expected a neural-contours model"):
            load_checkpoint(tmp_path / name)
    safetensors.torch.save_file({"x": torch.zeros(2)}, tmp_path / "foreign")
    with pytest.raises(InputError, match="holds a file of some other program; expected a neural-contours model"):
        load_checkpoint(tmp_path / "foreign")
    run(data, tmp_path / "t", stages=("ranker",), epochs=1)
    with pytest.raises(InputError, match="holds a neural-contours training state; expected a neural-contours model"):
        load_checkpoint(tmp_path / "t.ranker.state")


def test_checkpoints_whose_tensors_do_not_fit_their_header(tmp_path: Path) -> None:
    tensors, header = load_tensors(checkpoint(tmp_path / "m"), MODEL_KIND)
    name = "ranker.stem.weight"
    wrong = {
        r"is \(2, 8, 5, 5\)": {**tensors, name: torch.zeros(2, 8, 5, 5)},
        r"is \(2, 8, 7, 7\) torch.float64": {**tensors, name: tensors[name].double()},
        "is missing": {key: value for key, value in tensors.items() if key != name},
        "numbers that aren't finite": {**tensors, name: torch.full_like(tensors[name], torch.nan)},
    }
    for complaint, changed in wrong.items():
        save_tensors(tmp_path / "wrong", MODEL_KIND, changed, header)
        with pytest.raises(InputError, match=f"tensor {name} .*{complaint}"):
            load_checkpoint(tmp_path / "wrong")
    save_tensors(tmp_path / "wrong", MODEL_KIND, {**tensors, "ranker.more": torch.zeros(1)}, header)
    with pytest.raises(InputError, match=r"tensor 'ranker.more' is of no network"):
        load_checkpoint(tmp_path / "wrong")


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"version": 99}, "format version 99; expected version 1"),
        ({"preset": {"name": "x"}}, "damaged header"),
        ({"networks": ["poet"]}, "networks are \\['poet'\\]"),
        ({"networks": []}, "networks are"),
    ],
)
def test_checkpoints_with_a_damaged_header(tmp_path: Path, change: dict[str, object], complaint: str) -> None:
    tensors, header = load_tensors(checkpoint(tmp_path / "m"), MODEL_KIND)
    save_tensors(tmp_path / "wrong", MODEL_KIND, tensors, {**header, **change})
    with pytest.raises(InputError, match=complaint):
        load_checkpoint(tmp_path / "wrong")


@pytest.mark.parametrize("part", ["translation", "ranking"])
@pytest.mark.parametrize("field", ["size", "width", "levels", "blocks"])
def test_a_header_of_huge_networks_is_one_line_before_they_are_built(tmp_path: Path, part: str, field: str) -> None:
    tensors, header = load_tensors(checkpoint(tmp_path / "m"), MODEL_KIND)
    dims = header["preset"][part]
    name = field if field in dims else "blocks"
    dims[name] = [10**9] if isinstance(dims[name], list) else 10**9
    save_tensors(tmp_path / "huge", MODEL_KIND, tensors, header)
    with pytest.raises(
        InputError, match=r"damaged header \((size|channels|levels|blocks) is \d+, expected at most \d+\)"
    ):
        load_checkpoint(tmp_path / "huge")


def test_a_header_nested_without_end_is_one_line(tmp_path: Path) -> None:
    safetensors.torch.save_file({"w": torch.zeros(1)}, tmp_path / "m", {"neural-contours": "[" * 100_000})
    with pytest.raises(InputError, match="nested too deeply"):
        load_checkpoint(tmp_path / "m")
