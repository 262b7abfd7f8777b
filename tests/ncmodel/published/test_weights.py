"""The published state dicts are read, and other files are refused in one line."""

from pathlib import Path
from typing import Any

import pytest
import torch
from torch import nn

from ncmodel.errors import ArgumentError, InputError
from ncmodel.nets.checkpoints import build_network
from ncmodel.published.weights import PRESET, import_weights, ranker_names, translator_names
from tests.helpers import published_reference as reference
from tests.helpers.commands import complaint
from tests.helpers.published_weights import NARROW, narrow_networks, save_weights


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Ranking module and image branch."""
    return save_weights(tmp_path_factory.mktemp("weights"), narrow_networks())


def test_the_published_architectures_have_their_numbers_of_parameters_under_their_names() -> None:
    with torch.device("meta"):
        theirs: dict[str, nn.Module] = {"ranker": reference.Ranking(), "translator": reference.Translation()}
        ours = {name: build_network(name, PRESET) for name in theirs}
    names = {"ranker": ranker_names(PRESET.ranking), "translator": translator_names(PRESET.translation)}
    for name, count in (("ranker", 73_728_833), ("translator", 182_492_289)):
        assert sum(p.numel() for p in ours[name].parameters()) == count
        shapes = {key: value.shape for key, value in theirs[name].state_dict().items()}
        assert set(names[name].values()) == set(shapes)
        for key, other in names[name].items():
            assert ours[name].state_dict()[key].shape == shapes[other]


def test_one_file_alone_is_enough(files: tuple[Path, Path]) -> None:
    assert set(import_weights(ranker=files[0], preset=NARROW).networks) == {"ranker"}
    checkpoint = import_weights(translator=files[1], preset=NARROW)
    assert set(checkpoint.networks) == {"translator"}
    assert checkpoint.training == {"imported": {"translator": "image_translation_branch.pth"}}
    with pytest.raises(ArgumentError, match="ranker: found none, and no translator"):
        import_weights()


def test_old_files_and_those_of_several_gpus_are_read(files: tuple[Path, Path], tmp_path: Path) -> None:
    state = torch.load(files[0], weights_only=True)
    old = {f"module.{key}": value for key, value in state.items() if "num_batches" not in key}
    torch.save(old, tmp_path / "old.pth", _use_new_zipfile_serialization=False)
    expected, found = (import_weights(path, preset=NARROW).ranker for path in (files[0], tmp_path / "old.pth"))
    assert expected is not None
    assert found is not None
    for key, value in expected.state_dict().items():
        assert torch.equal(found.state_dict()[key], value)


class Harmful:
    """What a pickle may do."""

    def __reduce__(self) -> tuple[Any, tuple[str]]:
        return print, ("harm",)


def test_wrong_swapped_and_broken_files_are_told_in_a_line(
    files: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def refusal(**given: Path) -> str:
        with pytest.raises(InputError) as caught:
            import_weights(**given, preset=NARROW)
        assert "\n" not in str(caught.value)
        return str(caught.value)

    ranker, translator = files
    assert "holds the image branch's weights; expected the ranking module's" in refusal(ranker=translator)
    assert "holds the ranking module's weights; expected the image branch's" in refusal(translator=ranker)
    assert "no such file" in refusal(ranker=tmp_path / "none.pth")
    state = torch.load(ranker, weights_only=True)
    contents: dict[str, Any] = {
        "no state dict": b"hello there",
        "no state dict of PyTorch (PytorchStreamReader failed reading zip archive: failed finding central directory)": (
            ranker.read_bytes()[: ranker.stat().st_size // 2]
        ),
        "tensor 'fc.weight' is missing": {key: value for key, value in state.items() if key != "fc.weight"},
        "tensor 'fc.bias' is (2,)": {**state, "fc.bias": torch.zeros(2)},
        "tensor 'bn1.weight' has numbers that aren't finite": {**state, "bn1.weight": torch.full((4,), torch.nan)},
        "tensor 'extra' is of another network": {**state, "extra": torch.zeros(1)},
        "holds a list of other things": [1, 2],
        "(Weights only load failed": {"conv1.weight": Harmful()},
    }
    for told, content in contents.items():
        path = tmp_path / "wrong.pth"
        path.write_bytes(content) if isinstance(content, bytes) else torch.save(content, path)
        said = refusal(ranker=path)
        assert told in said
        assert "wrong.pth: " in said
    assert "harm" not in capsys.readouterr().out


def test_the_command_tells_what_is_wrong(
    files: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "official.safetensors"
    assert "--ranker: found none, and no translator" in complaint(capsys, "import-weights", "-o", out)
    said = complaint(capsys, "import-weights", "--ranker", files[0], "-o", out)  # narrower than the published network
    assert "tensor 'conv1.weight' is (4, 3, 7, 7); expected (64, 3, 7, 7)" in said
    assert not out.exists()
