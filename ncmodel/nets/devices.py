"""Where networks compute, and in which numbers: bfloat16 where the device multiplies it in hardware, else float32.

What a machine does is decided by what it is and not by a stopwatch, so that the same machine gives the same bytes.
"""

import copy
import itertools
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TypeVar

import torch
from torch import nn
from torch.nn.utils.fusion import fuse_conv_bn_eval

from ncmodel.errors import ArgumentError

N = TypeVar("N", bound=nn.Module)


def device_named(name: str | torch.device) -> torch.device:
    """One of torch's devices that this machine has.

    Raises:
        UsageError: It has none of that name.
    """
    try:
        return torch.zeros(1, device=name).device
    except (RuntimeError, AssertionError) as error:
        # torch's message may go on for many lines; the first one tells.
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        found = f"{str(name)!r}, which torch can't use ({reason})"
        raise ArgumentError("device", found, "cpu, cuda or another device of this machine") from error


def device_of(network: nn.Module) -> torch.device:
    """Where a network's weights are."""
    return next(network.parameters()).device


def is_fast_in_bfloat16(device: torch.device) -> bool:
    """Whether the device multiplies bfloat16 numbers faster than float32.

    CPUs do with AVX512-BF16 or AMX. Without, torch emulates: a score of the paper's ranking module took 20 s of CPU
    time in place of 4 s on cores that have AVX2 alone.
    """
    if device.type == "cuda":
        return torch.cuda.get_device_capability(device) >= (8, 0)
    return device.type == "cpu" and (torch.cpu._is_avx512_bf16_supported() or torch.cpu._is_amx_tile_supported())


def prepared(network: N) -> N:
    """A network for `numbers` that are rough; itself where these are float32.

    It has less to do at each call: batch norms are folded into the convolutions before them, and weights are in
    bfloat16 already, which else are made so at every call.
    """
    if not is_fast_in_bfloat16(device_of(network)):
        return network
    ready = copy.deepcopy(network)
    for block in ready.modules():
        if isinstance(block, nn.Sequential):
            for place, (layer, after) in enumerate(itertools.pairwise(block)):
                if isinstance(layer, nn.Conv2d) and isinstance(after, nn.BatchNorm2d):
                    block[place], block[place + 1] = fuse_conv_bn_eval(layer, after), nn.Identity()
    for layer in ready.modules():
        if isinstance(layer, nn.Conv2d):
            layer.to(torch.bfloat16)
            layer.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    return ready


@contextmanager
def numbers(device: torch.device, rough: bool) -> Iterator[None]:
    """Networks compute in float32 in the block; or, if `rough` will do and the device does that fast, in bfloat16.

    Float32 is what the CPU has too, not CUDA's TF32: a drawing shouldn't depend on where it was made.
    """
    half = rough and is_fast_in_bfloat16(device)
    with (
        torch.autocast(device.type, torch.bfloat16, enabled=half),
        torch.backends.cudnn.flags(enabled=True, deterministic=True, allow_tf32=False),
    ):
        yield


def full_numbers(device: torch.device) -> AbstractContextManager[object]:
    """Nothing is rounded to bfloat16 in the block, within `numbers` either."""
    known = torch.amp.is_autocast_available(device.type)
    return torch.autocast(device.type, enabled=False) if known else nullcontext()
