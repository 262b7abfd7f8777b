"""The networks as ONNX files, for programs that have no PyTorch."""

import warnings
from pathlib import Path

import torch
from torch import Tensor, nn

from ncmodel.errors import UsageError
from ncmodel.files import atomic
from ncmodel.nets.checkpoints import Checkpoint

OPSET = 17
"""Of ONNX; any ONNX Runtime from 2022 on knows it."""


def export_onnx(checkpoint: Checkpoint, folder: str | Path) -> dict[str, Path]:
    """Write ranker.onnx and translator.onnx, as far as the checkpoint has them.

    `ranker.onnx` takes `drawings` (B, 1, S, S), ink, and `maps` (B, K, S, S), and gives `scores` (B,).
    `translator.onnx` takes `maps` (B, K, H, W) and gives `probability` (B, 1, H, W). Maps are
    `checkpoint.preset.inputs`, in that order. B is free, and H and W are, in steps of 2^levels.

    Args:
        checkpoint: The networks.
        folder: Where to; it is made unless it is there.

    Returns:
        Network -> its file.

    Raises:
        UsageError: The checkpoint has neither network.
    """
    root, written = Path(folder), dict[str, Path]()
    channels = len(checkpoint.preset.inputs)
    if checkpoint.ranker is None and checkpoint.translator is None:
        raise UsageError("this model has neither ranking module nor image branch; expected one to export")
    root.mkdir(parents=True, exist_ok=True)
    if checkpoint.ranker is not None:
        size = checkpoint.ranker.dims.size
        example = torch.zeros(1, 1, size, size), torch.zeros(1, channels, size, size)
        free = {"drawings": {0: "batch"}, "maps": {0: "batch"}, "scores": {0: "batch"}}
        written["ranker"] = _export(checkpoint.ranker, example, free, root / "ranker.onnx")
    if checkpoint.translator is not None:
        size = 4 * 2**checkpoint.translator.dims.levels
        pixels = {0: "batch", 2: "height", 3: "width"}
        maps = (torch.zeros(1, channels, size, size),)
        free = {"maps": pixels, "probability": pixels}
        written["translator"] = _export(checkpoint.translator, maps, free, root / "translator.onnx")
    return written


def _export(network: nn.Module, example: tuple[Tensor, ...], free: dict[str, dict[int, str]], path: Path) -> Path:
    """Write one network; all names but the last are of inputs."""
    names = list(free)
    with warnings.catch_warnings(), atomic(path) as aside:
        # The newer exporter needs packages that nothing else here does.
        warnings.simplefilter("ignore")
        torch.onnx.export(
            network.cpu().eval(),
            example,
            str(aside),
            dynamo=False,
            input_names=names[:-1],
            output_names=names[-1:],
            dynamic_axes=free,
            opset_version=OPSET,
        )
    return path
