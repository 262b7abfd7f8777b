"""The sparse score of a drawing against the plain way: draw it whole, average it, ask the network."""

import numpy as np
import pytest
import torch
from torch import Tensor

from ncmodel.model.filters import Glance, line_drawing
from ncmodel.model.letterbox import Square
from ncmodel.model.maps import LineMaps
from ncmodel.model.score import CHUNK, DrawingScore
from ncmodel.nets.blocks import initialise
from ncmodel.nets.devices import prepared
from ncmodel.nets.presets import RankingDims
from ncmodel.nets.ranking import RankingModule
from ncmodel.types import Floats, Image

HEIGHT, WIDTH, SIZE = 60, 90, 32


def example(seed: int = 0) -> tuple[LineMaps, Image, Image]:
    """Line maps of scattered pixels, network maps, and an image branch's ink."""
    rng = np.random.default_rng(seed)
    shape = (HEIGHT, WIDTH)
    lines = np.where(rng.random((4, *shape)) < 0.1, rng.random((4, *shape)), 0.0).astype(np.float32)
    features = np.where(lines > 0, rng.gamma(2.0, 0.5, lines.shape), 0.0).astype(np.float32)
    contours, boundaries, image = (
        np.where(rng.random(shape) < 0.05, rng.random(shape), 0.0).astype(np.float32) for _ in range(3)
    )
    return LineMaps(lines, features, contours, boundaries, np.ones(4)), rng.random((7, *shape), np.float32), image


def ranker(seed: int = 0) -> RankingModule:
    network = RankingModule(RankingDims(size=SIZE, width=4, blocks=(1, 1)))
    initialise(network, torch.Generator().manual_seed(seed))
    return network.eval().requires_grad_(False)


def whole(lines: LineMaps, image: Image | None, thresholds: Tensor, boundaries: bool) -> Tensor:
    """(B, 1, S, S) drawings, from dense maps."""
    always = np.maximum(lines.contours, lines.boundaries) if boundaries else lines.contours
    always = always if image is None else np.maximum(always, image)
    flat = [torch.from_numpy(part.reshape(*part.shape[:-2], -1)) for part in (lines.lines, lines.features, always)]
    ink = line_drawing(flat[0], flat[1], flat[2], thresholds).reshape(-1, HEIGHT, WIDTH)
    return torch.from_numpy(Square(HEIGHT, WIDTH, SIZE).fit(ink.numpy(), 0.0))[:, None]


@pytest.mark.parametrize("boundaries", [False, True])
@pytest.mark.parametrize("with_image", [False, True])
def test_sparse_drawings_and_scores_equal_dense_ones(boundaries: bool, with_image: bool) -> None:
    lines, maps, image = example()
    network, branch = ranker(), image if with_image else None
    score = DrawingScore(network, maps, lines, branch)
    t = torch.rand(CHUNK + 3, 4, generator=torch.Generator().manual_seed(1)) * 2
    expected = whole(lines, branch, t, boundaries)
    torch.testing.assert_close(score.drawings(t, boundaries), expected, rtol=0, atol=2e-6)
    fitted = torch.from_numpy(Square(HEIGHT, WIDTH, SIZE).fit(maps, 1.0))[None].expand(len(t), -1, -1, -1)
    scores = score.scores(t.double().numpy(), boundaries)
    np.testing.assert_allclose(scores, network(expected, fitted).double().numpy(), atol=1e-4)


def test_the_mirror_image_counts_as_much_if_asked() -> None:
    lines, maps, _ = example()
    network, t = ranker(), np.random.default_rng(0).uniform(0, 1.5, (5, 4))
    score = DrawingScore(network, maps, lines, mirrored=True)
    drawings = score.drawings(torch.from_numpy(t).float(), True)
    seen = torch.from_numpy(Square(HEIGHT, WIDTH, SIZE).fit(maps, 1.0))[None].expand(len(t), -1, -1, -1)
    plain, flipped = network(drawings, seen), network(drawings.flip(-1), seen.flip(-1))
    assert (plain - flipped).abs().max() > 1e-3
    np.testing.assert_allclose(score.scores(t, True), ((plain + flipped) / 2).double().numpy(), atol=1e-4)
    assert score.slope(t[0], True)[0] == pytest.approx(score.scores(t, True)[0], abs=1e-4)


def test_slope_is_the_derivative_of_the_score() -> None:
    lines, maps, image = example()
    score = DrawingScore(ranker(), maps, lines, image)
    t = np.array([0.31, 0.52, 0.77, 1.1])
    here, slope = score.slope(t, True)
    assert here == pytest.approx(score.scores(t[None], True)[0], rel=1e-5)
    steps = 2e-3 * np.eye(4)
    ahead, behind = score.scores(t + steps, True), score.scores(t - steps, True)
    np.testing.assert_allclose(slope, (ahead - behind) / 4e-3, rtol=0.1, atol=0.05 * np.abs(slope).max())


def ink_left(lines: LineMaps, family: int, t: float) -> float:
    feature = np.maximum(lines.features[family].astype(np.float64), 1e-12)
    ink: Floats = lines.lines[family].astype(np.float64)
    return float((ink * np.maximum(1 - t / feature, 0)).sum() / ink.sum())


@pytest.mark.parametrize("family", range(4))
@pytest.mark.parametrize("share", [0.05, 0.25, 0.5, 0.9, 0.999])
def test_levels_leave_the_share_of_ink_asked_for(family: int, share: float) -> None:
    lines, maps, _ = example(seed=family)
    threshold = DrawingScore(ranker(), maps, lines).fading[family].threshold(share)
    assert ink_left(lines, family, threshold) == pytest.approx(share, abs=1e-6)


def test_levels_at_the_ends() -> None:
    lines, maps, _ = example()
    score = DrawingScore(ranker(), maps, lines)
    assert score.fading[2].threshold(1.0) == pytest.approx(0.0, abs=1e-9)
    assert score.fading[2].threshold(0.0) == pytest.approx(float(lines.features[2].max()))


def test_levels_of_lines_that_are_all_as_strong() -> None:
    lines, maps, _ = example()
    same = LineMaps(lines.lines, np.full_like(lines.features, 2.0), lines.contours, lines.boundaries, lines.p90)
    score = DrawingScore(ranker(), maps, same)
    assert [score.fading[0].threshold(share) for share in (1.0, 0.75, 0.5, 0.0)] == pytest.approx(
        [0.0, 0.5, 1.0, 2.0], abs=1e-6
    )


def test_presence_of_families_and_boundaries() -> None:
    lines, maps, _ = example()
    score = DrawingScore(ranker(), maps, lines)
    assert [fading.present for fading in score.fading] == [True] * 4
    assert score.has_boundaries
    empty = np.zeros_like(lines.lines)
    empty[1] = lines.lines[1]
    score = DrawingScore(ranker(), maps, LineMaps(empty, lines.features, lines.contours, empty[0], lines.p90))
    assert [fading.present for fading in score.fading] == [False, True, False, False]
    assert not score.has_boundaries


def test_a_view_without_a_line_has_a_score() -> None:
    lines, maps, _ = example()
    nothing = np.zeros((HEIGHT, WIDTH), np.float32)
    score = DrawingScore(ranker(), maps, LineMaps(0 * lines.lines, 0 * lines.features, nothing, nothing, lines.p90))
    assert np.isfinite(score.scores(np.zeros((1, 4)), boundaries=True)).all()
    here, slope = score.slope(np.zeros(4), boundaries=False)
    assert np.isfinite(here)
    assert slope.tolist() == [0.0] * 4


def test_drawings_look_from_afar_as_their_lines_do() -> None:
    lines, maps, _ = example()
    score, t = DrawingScore(ranker(), maps, lines), np.random.default_rng(0).uniform(0, 1.5, (5, 4))
    pixels = np.flatnonzero(lines.lines.any(axis=0))
    ink, feature = (torch.from_numpy(part.reshape(4, -1)[:, pixels]) for part in (lines.lines, lines.features))
    drawn = line_drawing(ink, feature, torch.from_numpy(lines.contours.ravel()[pixels]), torch.from_numpy(t).float())
    glance = Glance(pixels, ink.numpy().max(axis=0), (HEIGHT, WIDTH))
    np.testing.assert_allclose(score.glance(t), glance(drawn.numpy()[:, glance.pixels]), rtol=1e-5)


@pytest.mark.parametrize("fast", [False, True])
def test_rough_scores_and_slopes_are_close(monkeypatch: pytest.MonkeyPatch, fast: bool) -> None:
    """In bfloat16 where the hardware has it, the same numbers where it hasn't."""
    monkeypatch.setattr(torch.cpu, "_is_avx512_bf16_supported", lambda: fast)
    monkeypatch.setattr(torch.cpu, "_is_amx_tile_supported", lambda: False)
    lines, maps, image = example()
    network, t = ranker(), np.random.default_rng(0).random((8, 4))
    ready = prepared(network)
    assert (ready is network) != fast
    exact, rough = DrawingScore(network, maps, lines, image), DrawingScore(ready, maps, lines, image, rough=True)
    scores, close = exact.scores(t, True), rough.scores(t, True)
    assert close.dtype == np.float64
    assert (close == scores).all() != fast
    np.testing.assert_allclose(close, scores, atol=0.02 * max(1.0, float(np.abs(scores).max())))
    slope, near = exact.slope(t[0], True)[1], rough.slope(t[0], True)[1]
    np.testing.assert_allclose(near, slope, atol=0.1 * float(np.abs(slope).max()))
