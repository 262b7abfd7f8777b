"""ONNX files say what the networks say."""

from pathlib import Path

import numpy as np
import onnxruntime
import pytest
import torch

from ncmodel.errors import UsageError
from ncmodel.nets.checkpoints import Checkpoint, build_network, save_checkpoint
from ncmodel.nets.onnx_export import export_onnx
from ncmodel.nets.ranking import RankingModule
from tests.helpers import published_reference as reference
from tests.helpers.commands import printed
from tests.helpers.micro_training import MICRO
from tests.helpers.published_weights import NARROW

pytestmark = pytest.mark.usefixtures("one_thread")


def run(path: Path, *inputs: torch.Tensor) -> torch.Tensor:
    """What ONNX Runtime computes."""
    session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    names = [given.name for given in session.get_inputs()]
    feed = {name: value.numpy() for name, value in zip(names, inputs, strict=True)}
    return torch.from_numpy(np.asarray(session.run(None, feed)[0]))


@pytest.mark.parametrize("preset", [MICRO, NARROW], ids=["ours", "published"])
def test_onnx_runtime_computes_the_same(preset: object, tmp_path: Path) -> None:
    assert isinstance(preset, type(MICRO))
    networks = {name: build_network(name, preset) for name in ("ranker", "translator")}
    for seed, network in enumerate(networks.values()):
        reference.randomise(network, seed)
    files = export_onnx(Checkpoint(preset, **networks), tmp_path / "out")  # type: ignore[arg-type]
    size, generator = preset.ranking.size, torch.Generator().manual_seed(3)
    drawings, maps = (torch.rand(2, channels, size, size, generator=generator) for channels in (1, 7))
    expected = networks["ranker"](drawings, maps)
    assert run(files["ranker"], drawings, maps).numpy() == pytest.approx(expected.numpy(), rel=1e-4, abs=1e-4)
    wide = torch.rand(1, 7, 64, 96, generator=generator)
    found = run(files["translator"], wide)
    assert (found - networks["translator"](wide)).abs().max() < 1e-4


def test_the_command_names_files_and_maps(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    save_checkpoint(tmp_path / "m.safetensors", Checkpoint(MICRO, ranker=RankingModule(MICRO.ranking)))
    record = printed(capsys, "export-onnx", tmp_path / "m.safetensors", "-o", tmp_path)
    assert record["files"] == {"ranker": str(tmp_path / "ranker.onnx")}
    assert record["maps"][:2] == ["depth", "shaded_0"]
    with pytest.raises(UsageError, match="neither ranking module nor image branch"):
        export_onnx(Checkpoint(MICRO), tmp_path)
