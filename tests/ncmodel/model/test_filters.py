"""Equations 1-5: against their formulas, their gradients against finite differences, and at their ends."""

import math

import numpy as np
import pytest
import torch
from torch import Tensor

from ncmodel.model.filters import SMALLEST_FEATURE, line_drawing

PIXELS = 12


def example(seed: int = 0, pixels: int = PIXELS) -> tuple[Tensor, Tensor, Tensor]:
    """Random lines, features and always-drawn ink, in float64, away from ties."""
    generator = torch.Generator().manual_seed(seed)
    lines = torch.rand(4, pixels, generator=generator, dtype=torch.float64)
    features = torch.rand(4, pixels, generator=generator, dtype=torch.float64) * 3 + 0.05
    always = 0.2 * torch.rand(pixels, generator=generator, dtype=torch.float64)
    return lines, features, always


def by_hand(lines: Tensor, features: Tensor, always: Tensor, t: list[float]) -> list[float]:
    """Equations 1-5, pixel by pixel."""
    drawn = []
    for x in range(lines.shape[1]):
        filtered = [float(lines[k, x]) * max(1 - t[k] / float(features[k, x]), 0.0) for k in range(4)]
        drawn.append(max(*filtered, float(always[x])))
    return drawn


@pytest.mark.parametrize("t", [[0.0, 0.0, 0.0, 0.0], [0.1, 0.5, 1.0, 2.0], [100.0, 0.0, 100.0, 0.3]])
def test_line_drawing_is_the_papers_formula(t: list[float]) -> None:
    lines, features, always = example()
    drawn = line_drawing(lines, features, always, torch.tensor([t], dtype=torch.float64))
    np.testing.assert_allclose(drawn[0].numpy(), by_hand(lines, features, always, t), rtol=1e-12)


def test_a_batch_is_its_drawings_one_by_one() -> None:
    lines, features, always = example()
    many = torch.rand(5, 4, dtype=torch.float64, generator=torch.Generator().manual_seed(3))
    together = line_drawing(lines, features, always, many)
    apart = torch.cat([line_drawing(lines, features, always, t[None]) for t in many])
    assert torch.equal(together, apart)


def test_threshold_zero_keeps_every_line_and_a_large_one_only_what_is_always_drawn() -> None:
    lines, features, always = example()
    ends = torch.tensor([[0.0] * 4, [1e9] * 4], dtype=torch.float64)
    everything, least = line_drawing(lines, features, always, ends)
    assert torch.equal(everything, torch.maximum(lines.amax(dim=0), always))
    assert torch.equal(least, always)


def test_ink_never_grows_with_a_threshold() -> None:
    lines, features, always = example(pixels=200)
    steps = torch.linspace(0, 4, 30, dtype=torch.float64)[:, None].expand(-1, 4)
    drawn = line_drawing(lines, features, always, steps)
    assert (drawn.diff(dim=0) <= 0).all()


def test_gradient_in_the_thresholds_is_that_of_finite_differences() -> None:
    lines, features, always = example()
    t = torch.tensor([[0.11, 0.23, 0.37, 0.53], [0.9, 0.07, 0.41, 1.3]], dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lambda x: line_drawing(lines, features, always, x), (t,))


def one_family(feature: float, t: Tensor) -> Tensor:
    """I_S(t) at one pixel of full ink."""
    lines, features = torch.zeros(4, 1, dtype=t.dtype), torch.ones(4, 1, dtype=t.dtype)
    lines[0], features[0] = 1.0, feature
    return line_drawing(lines, features, torch.zeros(1, dtype=t.dtype), t.expand(1, 4))[0, 0]


@pytest.mark.parametrize("feature", [0.5, 2.0])
def test_gradient_at_threshold_zero_is_minus_one_over_the_feature(feature: float) -> None:
    t = torch.zeros(1, dtype=torch.float64, requires_grad=True)
    (gradient,) = torch.autograd.grad(one_family(feature, t), t)
    assert gradient.item() == -1 / feature


@pytest.mark.parametrize("feature", [0.0, -1.0, 1e-45, -1e30, 1e30, math.inf])
@pytest.mark.parametrize("t", [0.0, 0.5, 1e30])
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_extremes_give_numbers_with_gradients_that_are_numbers(feature: float, t: float, dtype: torch.dtype) -> None:
    threshold = torch.full((1, 4), t, dtype=dtype, requires_grad=True)
    features = torch.full((4, 3), feature, dtype=dtype)
    drawn = line_drawing(torch.ones(4, 3, dtype=dtype), features, torch.zeros(3, dtype=dtype), threshold)
    (gradient,) = torch.autograd.grad(drawn.sum(), threshold)
    assert ((drawn >= 0) & (drawn <= 1)).all()
    assert gradient.isfinite().all()
    if t == 0:
        assert (drawn == 1).all()
    elif feature <= 0:
        assert (drawn == 0).all()


def test_features_below_the_smallest_count_as_the_smallest() -> None:
    quarter = torch.tensor([SMALLEST_FEATURE / 4], dtype=torch.float64)
    assert one_family(0.0, quarter).item() == pytest.approx(0.75)
    assert one_family(0.0, 4 * quarter).item() == pytest.approx(0.0, abs=1e-15)


def test_no_lines_at_all() -> None:
    t = torch.zeros(2, 4, requires_grad=True)
    drawn = line_drawing(torch.zeros(4, 0), torch.zeros(4, 0), torch.zeros(0), t)
    assert drawn.shape == (2, 0)


@pytest.mark.parametrize(
    ("lines", "features", "always", "t"),
    [((3, 5), (3, 5), (5,), (1, 4)), ((4, 5), (4, 6), (5,), (1, 4)), ((4, 5), (4, 5), (6,), (1, 4))]
    + [((4, 5), (4, 5), (5,), (4,)), ((4, 5), (4, 5), (5,), (1, 3))],
)
def test_shapes_that_do_not_fit_are_refused(
    lines: tuple[int, ...], features: tuple[int, ...], always: tuple[int, ...], t: tuple[int, ...]
) -> None:
    with pytest.raises(ValueError, match="expected"):
        line_drawing(torch.zeros(lines), torch.zeros(features), torch.zeros(always), torch.zeros(t))
