"""The networks against the paper's tables, and the losses against their formulas."""

import itertools
import math
from dataclasses import replace

import pytest
import torch
from torch import Tensor, nn

from ncmodel.errors import UsageError
from ncmodel.nets.blocks import ResidualBlock, Standardise, initialise
from ncmodel.nets.checkpoints import build_network
from ncmodel.nets.losses import cross_entropy, pair_accuracy, ranking_loss
from ncmodel.nets.presets import MAPS, PRESETS, Preset, RankingDims, StatisticsDims, TranslationDims, preset_named
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.translation import TranslationBranch

TRANSLATION_TABLE = [
    (768, 64),
    (384, 128),
    (192, 256),
    (96, 512),
    (48, 1024),
    (48, 1024),
    (96, 512),
    (192, 256),
    (384, 128),
    (768, 64),
    (768, 1),
]
"""(side, channels) of the rows below "Input" in the appendix's table of the image translation branch."""

RANKING_TABLE = [(192, 64), (96, 128), (48, 256), (24, 512), (12, 1024)]
"""The same for the rows "ResBlock" of the ranking module's table."""


def activations(module: nn.Module, layers: nn.ModuleList, *inputs: Tensor) -> list[tuple[int, int]]:
    """(side, channels) of every layer's output, side checked to be square."""
    seen: list[tuple[int, int]] = []

    def record(layer: nn.Module, arguments: tuple[Tensor, ...], output: Tensor) -> None:
        assert output.shape[2] == output.shape[3]
        seen.append((output.shape[2], output.shape[1]))

    handles = [layer.register_forward_hook(record) for layer in layers]
    module(*inputs)
    for handle in handles:
        handle.remove()
    return seen


def gradient(loss: Tensor, *inputs: Tensor) -> tuple[Tensor, ...]:
    return torch.autograd.grad(loss, inputs)


def parameters(module: nn.Module) -> int:
    return sum(parameter.numel() for parameter in module.parameters())


def convolution(kernel: int, inputs: int, outputs: int) -> int:
    """Weights of a convolution and of the batch norm after it."""
    return kernel * kernel * inputs * outputs + 2 * outputs


def test_translation_branch_has_the_papers_activation_sizes() -> None:
    with torch.device("meta"):
        branch = TranslationBranch(PRESETS["paper"].translation)
        seen = activations(branch, branch.layers, torch.empty(1, 7, 768, 768))
    assert seen == TRANSLATION_TABLE


def test_ranking_module_has_the_papers_activation_sizes() -> None:
    with torch.device("meta"):
        module = RankingModule(PRESETS["paper"].ranking)
        embedded = module.embed(torch.empty(1, 7, 768, 768))
        seen = activations(module, module.stages, torch.empty(1, 1, 768, 768), torch.empty(1, 7, 768, 768))
    assert embedded.shape == (1, 64, 384, 384)
    assert seen == RANKING_TABLE
    assert module.head.in_features == 1024


def test_parameter_counts_follow_from_the_papers_tables() -> None:
    with torch.device("meta"):
        branch = TranslationBranch(PRESETS["paper"].translation)
        module = RankingModule(PRESETS["paper"].ranking)
    widths = [64, 128, 256, 512, 1024]
    steps = list(itertools.pairwise(widths))
    expected = convolution(7, 7, 64) + sum(convolution(3, a, b) + convolution(3, b, a) for a, b in steps)
    biases = sum(widths) + 18 * 1024 + sum(widths[:-1])
    assert parameters(branch) == expected + 18 * convolution(3, 1024, 1024) + 7 * 7 * 64 + 1 + biases
    assert parameters(branch) == 182_492_289

    expected = convolution(7, 8, 64) + sum(convolution(3, a, b) + convolution(1, a, b) for a, b in steps)
    inner = zip(widths, [6, 7, 11, 5, 5], strict=True)
    assert parameters(module) == expected + sum(n * convolution(3, c, c) for c, n in inner) + 1024 + 1


def test_pix2pixhd_s_blocks_add_without_relu_and_reflect_at_the_rim() -> None:
    torch.manual_seed(0)
    block, image = ResidualBlock(3, 3, style="pix2pixhd").eval(), torch.randn(1, 3, 5, 6)
    for layers in (block.first, block.second):
        nn.init.normal_(layers[1].weight)  # type: ignore[arg-type]
        layers[1].running_mean.normal_()  # type: ignore[operator]

    def layer(layers: nn.Sequential, x: Tensor) -> Tensor:
        convolution, norm = layers
        padded = nn.functional.pad(x, (1, 1, 1, 1), mode="reflect")
        filtered = nn.functional.conv2d(padded, convolution.weight, convolution.bias)  # type: ignore[arg-type]
        return torch.as_tensor(norm(filtered))

    expected = image + layer(block.second, torch.relu(layer(block.first, image)))
    assert expected.min() < 0
    torch.testing.assert_close(block(image), expected)


def test_presets_written_before_styles_and_inputs_are_read_as_they_were() -> None:
    record = PRESETS["paper"].to_record()
    for part in ("translation", "ranking"):
        record[part] = {key: value for key, value in record[part].items() if key not in ("style", "inputs")}
    old = Preset.from_record({key: value for key, value in record.items() if key not in ("percentile", "published")})
    assert (old.translation.style, old.inputs, old.percentile) == ("resnet", MAPS, "view")


def test_networks_pick_what_they_read_of_the_maps_they_are_handed() -> None:
    dims = TranslationDims(size=16, width=2, levels=1, blocks=1, inputs=("apparent", "depth"))
    preset = replace(PRESETS["tiny"], translation=dims, ranking=RankingDims(size=16, width=2, blocks=(1,)))
    assert preset.inputs == (*MAPS, "apparent")
    branch, alone = build_network("translator", preset).eval(), TranslationBranch(dims).eval()
    alone.load_state_dict(branch.state_dict())
    maps = torch.rand(1, 8, 16, 16)
    torch.testing.assert_close(branch(maps), alone(maps[:, [7, 0]]))
    assert Preset.from_record(preset.to_record()) == preset


@pytest.mark.parametrize("preset", PRESETS.values(), ids=PRESETS.keys())
def test_presets_end_in_about_as_many_cells_as_the_paper(preset: Preset) -> None:
    paper, translation, ranking = PRESETS["paper"], preset.translation, preset.ranking
    assert 48 <= translation.size / 2**translation.levels <= 64
    assert 8 <= ranking.size / (4 * 2 ** (len(ranking.blocks) - 1)) <= 12
    assert translation.blocks == paper.translation.blocks
    assert ranking.blocks == paper.ranking.blocks[: len(ranking.blocks)]
    assert Preset.from_record(preset.to_record()) == preset


def test_paper_preset_trains_at_the_papers_rates() -> None:
    paper = preset_named("paper")
    assert (paper.ranker.learning_rate, paper.ranker.batch) == (2e-5, 32)
    assert (paper.translator.learning_rate, paper.translator.batch) == (2e-4, 2)


def test_unknown_preset_is_named() -> None:
    with pytest.raises(UsageError, match=r"'huge', expected one of paper, small, tiny"):
        preset_named("huge")


def test_impossible_dims_are_refused() -> None:
    with pytest.raises(ValueError, match="divisible by 16"):
        TranslationDims(size=100)
    with pytest.raises(ValueError, match="expected different ones of depth, shaded_0"):
        TranslationDims(inputs=("depth", "colour"))
    with pytest.raises(ValueError, match="expected different ones"):
        RankingDims(inputs=("depth", "depth"))
    with pytest.raises(ValueError, match="resnet or pix2pixhd"):
        TranslationDims(style="unet")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="view or mesh"):
        replace(PRESETS["tiny"], percentile="picture")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="positive"):
        RankingDims(width=0)
    with pytest.raises(ValueError, match="networks is 1000000000, expected at most 256"):
        StatisticsDims(networks=10**9)
    with pytest.raises(ValueError, match=r"channels is .* expected at most"):
        RankingDims(blocks=(1,) * 40)
    with pytest.raises(ValueError, match="sizes 256 and 96"):
        replace(PRESETS["tiny"], ranking=RankingDims(size=96))


def test_scoring_with_embedded_maps_equals_one_convolution_over_all_channels() -> None:
    torch.manual_seed(1)
    module = RankingModule(RankingDims(size=64, width=4)).double()
    drawings, maps = torch.rand(3, 1, 64, 64).double(), torch.rand(3, 7, 64, 64).double()
    both = torch.cat([module.standardise_drawing(drawings), module.standardise_maps(maps)], dim=1)
    whole = module.stem(both)
    weight = module.stem.weight[:, :1]
    drawn = nn.functional.conv2d(module.standardise_drawing(drawings), weight, stride=2, padding=3)
    torch.testing.assert_close(drawn + module.embed(maps), whole)
    torch.testing.assert_close(module(drawings, maps), module.score(drawings, module.embed(maps)))


def test_one_views_maps_serve_many_drawings() -> None:
    module = RankingModule(RankingDims(size=32, width=4)).eval()
    drawings, maps = torch.rand(5, 1, 32, 32), torch.rand(1, 7, 32, 32)
    together = module.score(drawings, module.embed(maps))
    apart = torch.cat([module(drawing[None], maps) for drawing in drawings])
    torch.testing.assert_close(together, apart)


def test_translation_gives_probabilities_and_logits_that_agree() -> None:
    branch = TranslationBranch(TranslationDims(size=32, width=4)).eval()
    maps = torch.rand(2, 7, 32, 32)
    probability = branch(maps)
    assert probability.shape == (2, 1, 32, 32)
    assert 0 <= probability.min() <= probability.max() <= 1
    torch.testing.assert_close(probability, torch.sigmoid(branch.logits(maps)))


@pytest.mark.parametrize("share", [0.0, 0.04, 1.0])
def test_untrained_branch_expects_the_given_share_of_ink(share: float) -> None:
    branch = TranslationBranch(TranslationDims(size=32, width=4)).eval()
    branch.expect_ink(share)
    with torch.no_grad():
        branch.layers[-1].weight.zero_()  # type: ignore[operator]
    assert branch(torch.rand(1, 7, 32, 32)).mean().item() == pytest.approx(share, abs=2e-3)


def test_residual_blocks_start_as_the_identity_of_what_is_positive() -> None:
    network = nn.Sequential(ResidualBlock(4, 4), ResidualBlock(4, 4)).eval()
    initialise(network, torch.Generator().manual_seed(0))
    x = torch.rand(1, 4, 8, 8)
    torch.testing.assert_close(network(x), x)


def test_initialisation_depends_on_the_generator_alone() -> None:
    def weights(seed: int) -> Tensor:
        module = RankingModule(RankingDims(size=32, width=4))
        initialise(module, torch.Generator().manual_seed(seed))
        return torch.cat([p.flatten() for p in module.parameters()])

    assert torch.equal(weights(5), weights(5))
    assert not torch.equal(weights(5), weights(6))


def test_standardise_maps_background_to_zero_and_keeps_constant_channels_finite() -> None:
    layer = Standardise([1.0, 0.0])
    layer.fit(torch.stack([torch.tensor([[0.75, 1.25]]), torch.zeros(1, 2)])[None])
    out = layer(torch.tensor([1.5, 0.5]).reshape(1, 2, 1, 1))
    assert out.flatten().tolist() == [2.0, 0.5]


def test_strided_shortcut_equals_a_strided_convolution() -> None:
    block = ResidualBlock(3, 5, stride=2)
    x = torch.rand(2, 3, 7, 7)
    convolve = nn.Conv2d(3, 5, 1, bias=False)
    convolve.load_state_dict(block.shortcut[0].state_dict())  # type: ignore[index]
    expected = nn.functional.conv2d(x, convolve.weight, stride=2)
    torch.testing.assert_close(convolve(x[:, :, ::2, ::2]), expected)


def test_ranking_loss_is_the_mean_hinge() -> None:
    better, worse = torch.tensor([3.0, 0.5, -1.0, 0.0]), torch.tensor([1.0, 0.0, 1.0, 0.0])
    expected = (0.0 + 0.5 + 3.0 + 1.0) / 4
    assert ranking_loss(better, worse).item() == pytest.approx(expected)


def test_ranking_loss_stays_finite_and_defined_at_its_ends() -> None:
    empty = torch.zeros(0, requires_grad=True)
    assert gradient(ranking_loss(empty, empty), empty)[0].shape == (0,)
    assert ranking_loss(empty, empty).item() == 0.0
    far = torch.tensor([1e30], requires_grad=True)
    assert gradient(ranking_loss(far, -far), far)[0].item() == 0.0
    with pytest.raises(ValueError, match=r"\(2,\) and \(3,\)"):
        ranking_loss(torch.zeros(2), torch.zeros(3))


def test_losses_have_the_gradients_of_finite_differences() -> None:
    generator = torch.Generator().manual_seed(0)
    better = torch.randn(6, generator=generator, dtype=torch.float64, requires_grad=True)
    worse = torch.randn(6, generator=generator, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(ranking_loss, (better, worse))
    target = torch.rand(1, 1, 2, 3, generator=generator, dtype=torch.float64)
    logits = torch.randn(1, 1, 2, 3, generator=generator, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lambda x: cross_entropy(x, target), (logits,))


def test_pair_accuracy_counts_ties_as_half() -> None:
    better, worse = torch.tensor([1.0, 1.0, 1.0, 0.0]), torch.tensor([0.0, 1.0, 1.0, 1.0])
    assert pair_accuracy(better, worse) == pytest.approx((1 + 0.5 + 0.5) / 4)
    assert math.isnan(pair_accuracy(torch.zeros(0), torch.zeros(0)))


def test_cross_entropy_is_the_papers_formula_over_the_number_of_pixels() -> None:
    logits, target = torch.tensor([[[[0.3, -2.0], [1.5, 0.0]]]]), torch.tensor([[[[1.0, 0.0], [0.25, 0.5]]]])
    p = torch.sigmoid(logits)
    expected = -(target * p.log() + (1 - target) * (1 - p).log()).sum() / 4
    torch.testing.assert_close(cross_entropy(logits, target), expected)


@pytest.mark.parametrize("size", [1e3, 1e30])
def test_cross_entropy_is_finite_where_the_probability_rounds_to_an_end(size: float) -> None:
    logits = torch.tensor([[[[size, -size, size, -size]]]], requires_grad=True)
    loss = cross_entropy(logits, torch.tensor([[[[0.0, 1.0, 1.0, 0.0]]]]))
    assert loss.isfinite()
    assert torch.allclose(gradient(loss, logits)[0], torch.tensor([0.25, -0.25, 0.0, 0.0]))


@pytest.mark.parametrize("side", [33, 48, 64, 192])
@pytest.mark.parametrize("batch", [1, 3, 32])
def test_ranking_gradients_survive_channels_last(side: int, batch: int) -> None:
    """The layout that training uses; torch's strided 1x1 kernel used to corrupt memory at some of these sizes."""
    torch.manual_seed(0)
    module = RankingModule(RankingDims(size=side, width=8, blocks=(1, 1))).double()
    drawings, maps = torch.rand(batch, 1, side, side).double(), torch.rand(1, 7, side, side).double()
    exact = gradient(module.score(drawings, module.embed(maps)).sum(), *module.parameters())
    module = module.float().to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    found = gradient(module.score(drawings.float(), module.embed(maps.float())).sum(), *module.parameters())
    for a, b in zip(found, exact, strict=True):
        torch.testing.assert_close(a.double(), b, rtol=2e-2, atol=2e-2 * float(b.abs().max()))
