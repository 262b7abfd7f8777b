"""pix2pixHD's discriminators and losses."""

from itertools import pairwise

import pytest
import torch
from torch import Tensor, nn

from ncmodel.nets.discriminators import SCALES, MultiScaleDiscriminator, feature_matching, least_squares
from ncmodel.nets.presets import PRESETS
from tests.helpers.micro_training import MICRO


@pytest.fixture(scope="module")
def maps() -> Tensor:
    return torch.rand(2, len(MICRO.inputs), 64, 64, generator=torch.Generator().manual_seed(0))


def drawing(seed: int) -> Tensor:
    return torch.rand(2, 1, 64, 64, generator=torch.Generator().manual_seed(seed))


@pytest.fixture(scope="module")
def network() -> MultiScaleDiscriminator:
    torch.manual_seed(0)
    return MultiScaleDiscriminator(MICRO.translation, MICRO.inputs)


def test_the_paper_s_see_the_maps_too_and_are_as_wide_as_the_generator() -> None:
    with torch.device("meta"):
        network = MultiScaleDiscriminator(PRESETS["paper"].translation)
    assert len(network.scales) == SCALES == 3
    first = network.scales[0].layers[0][0]  # type: ignore[index]
    assert isinstance(first, nn.Conv2d)
    assert (first.in_channels, first.out_channels) == (8, 64)


def test_each_scale_sees_half_of_the_one_before(network: MultiScaleDiscriminator, maps: Tensor) -> None:
    said = network(maps, drawing(1))
    sides = [layers[0].shape[-1] for layers in said]
    assert all(abs(2 * after - before) <= 2 for before, after in pairwise(sides))
    assert all(layers[-1].shape[:2] == (2, 1) for layers in said)


def test_what_is_said_depends_on_the_maps(network: MultiScaleDiscriminator, maps: Tensor) -> None:
    one, other = (network(seen, drawing(1))[0][-1] for seen in (maps, maps.flip(-1)))
    assert (one - other).abs().max() > 1e-3


def test_least_squares_are_zero_where_all_is_as_wanted() -> None:
    said = [[torch.zeros(1), torch.ones(2, 1, 3, 3)], [torch.zeros(1), torch.full((2, 1, 2, 2), 0.5)]]
    assert least_squares(said, 1.0).item() == pytest.approx(0.25 / 2)
    assert least_squares(said, 0.0).item() == pytest.approx((1 + 0.25) / 2)


def test_features_of_real_drawings_are_targets_without_gradient() -> None:
    made, real = (torch.full((4,), value, requires_grad=True) for value in (1.0, 3.0))
    last = torch.zeros(1, requires_grad=True)
    loss = feature_matching([[made, last]], [[real, last + 7.0]])
    assert loss.item() == 2.0
    torch.autograd.backward(loss)
    assert real.grad is None
    assert last.grad is None
    assert made.grad is not None
    torch.testing.assert_close(made.grad, torch.full((4,), -0.25))
