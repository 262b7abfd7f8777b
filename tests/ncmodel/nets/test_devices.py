"""Which device computes, and in which numbers."""

import pytest
import torch

from ncmodel.errors import UsageError
from ncmodel.nets.devices import device_named, device_of, is_fast_in_bfloat16, numbers

CPU = torch.device("cpu")


def hardware(monkeypatch: pytest.MonkeyPatch, avx512_bf16: bool, amx: bool) -> None:
    monkeypatch.setattr(torch.cpu, "_is_avx512_bf16_supported", lambda: avx512_bf16)
    monkeypatch.setattr(torch.cpu, "_is_amx_tile_supported", lambda: amx)


@pytest.mark.parametrize("name", ["cuda:99", "abacus"])
def test_devices_that_are_not_there_are_named(name: str) -> None:
    with pytest.raises(UsageError, match=rf"device: found '{name}', which torch can't use .*, expected cpu, cuda or"):
        device_named(name)


def test_a_network_is_where_its_weights_are() -> None:
    assert device_named("cpu") == CPU
    assert device_of(torch.nn.Linear(1, 1)) == CPU
    assert device_of(torch.nn.Linear(1, 1, device="meta")).type == "meta"


@pytest.mark.parametrize("found", [(True, False), (False, True), (True, True)])
def test_bfloat16_is_used_where_hardware_multiplies_it(
    monkeypatch: pytest.MonkeyPatch, found: tuple[bool, bool]
) -> None:
    hardware(monkeypatch, *found)
    assert is_fast_in_bfloat16(CPU)
    with numbers(CPU, rough=True):
        assert torch.nn.Linear(2, 2)(torch.ones(1, 2)).dtype == torch.bfloat16


def test_float32_is_used_where_bfloat16_is_emulated(monkeypatch: pytest.MonkeyPatch) -> None:
    hardware(monkeypatch, avx512_bf16=False, amx=False)
    assert not is_fast_in_bfloat16(CPU)
    with numbers(CPU, rough=True):
        assert torch.nn.Linear(2, 2)(torch.ones(1, 2)).dtype == torch.float32
    with numbers(CPU, rough=False):
        assert torch.nn.Linear(2, 2)(torch.ones(1, 2)).dtype == torch.float32
