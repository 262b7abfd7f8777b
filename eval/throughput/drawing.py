"""One drawing with the paper's networks on the CPU and on another device: times, and how far they agree."""

import copy
import time
from dataclasses import dataclass

import numpy as np
import torch

from ncmodel.nets.blocks import initialise
from ncmodel.nets.checkpoints import Checkpoint
from ncmodel.nets.devices import numbers
from ncmodel.nets.presets import PRESETS
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.translation import TranslationBranch
from ncmodel.types import FILTERED_FAMILIES

SIZE = 768
FACES = 20_000
INK = 0.02
"""Share of ink that the untrained image branch expects."""


@dataclass(frozen=True)
class Agreement:
    """A drawing on two devices, by networks with the same random weights.

    Attributes:
        budget: Of the search for thresholds.
        cpu_seconds: On the CPU, thresholds and lines and strokes; the second time, when kernels are compiled.
        device_seconds: On the device, likewise.
        score_error: By how much scores of the same drawings differ at most, over the range of these scores.
        probability_error: By how much the image branch's probabilities differ at most.
        thresholds: On the CPU, and on the device, in the families' order.
        ink_error: Share of inked pixels that are inked in one drawing only.
    """

    budget: str
    cpu_seconds: float
    device_seconds: float
    score_error: float
    probability_error: float
    thresholds: tuple[tuple[float | None, ...], tuple[float | None, ...]]
    ink_error: float


def compare_drawings(device: torch.device, preset: str = "paper", budget: str = "draft") -> Agreement:
    """Draw a bumpy torus on the CPU and on a device.

    Args:
        device: To compare with.
        preset: Of the networks.
        budget: Of the search.

    Raises:
        ImportError: A library that drawing needs isn't there (Embree).
    """
    from dataset_tools.simulation.shapes import bumpy_torus
    from ncmodel.camera import Camera
    from ncmodel.drawing.draw import draw_view
    from ncmodel.model.maps import network_maps
    from ncmodel.model.predictor import Model
    from ncmodel.model.score import PictureScore
    from ncmodel.scene.surface import Surface
    from ncmodel.scene.view import View

    torus = bumpy_torus(FACES)
    camera = Camera.orbit(torus.vertices, size=(SIZE, SIZE))
    checkpoint = _checkpoint(preset)
    plans, inks, seconds, probabilities, scores = [], [], [], [], []
    settings = np.random.default_rng(0).random((4, SIZE, SIZE))
    cpu = torch.device("cpu")
    for place in (cpu, cpu, device, device):
        model = Model(copy.deepcopy(checkpoint), place)
        view = View(Surface(torus), camera)
        begin = time.monotonic()
        plan = model.choose(view, budget=budget)
        ink = draw_view(view, plan).ink()
        seconds.append(time.monotonic() - begin)
        plans.append(plan)
        inks.append(ink > 0.5)
        maps = network_maps(view, model.checkpoint.preset.inputs)
        probabilities.append(model.probability(maps))
        assert model.checkpoint.ranker is not None
        # The drawing with more and more of it rubbed out.
        rubbed = [np.where(noise < number / len(settings), 0.0, inks[0]) for number, noise in enumerate(settings)]
        with numbers(place, rough=False):
            found = PictureScore(model.checkpoint.ranker, maps).scores(r.astype(np.float32) for r in rubbed)
        scores.append(found)
    either, both = (inks[0] | inks[-1]).sum(), (inks[0] & inks[-1]).sum()
    chosen = [tuple(plan.thresholds.value(family) for family in FILTERED_FAMILIES) for plan in (plans[0], plans[-1])]
    return Agreement(
        budget,
        seconds[1],
        seconds[-1],
        score_error=float(np.abs(scores[0] - scores[-1]).max() / max(np.ptp(scores[0]), 1e-9)),
        probability_error=float(np.abs(probabilities[0] - probabilities[-1]).max()),
        thresholds=(chosen[0], chosen[1]),
        ink_error=float(1 - both / max(either, 1)),
    )


def _checkpoint(name: str) -> Checkpoint:
    """Networks of a preset with random weights, every residual branch alive and batch norms as after some training."""
    preset = PRESETS[name]
    ranker, translator = (
        RankingModule(preset.ranking, preset.inputs),
        TranslationBranch(preset.translation, preset.inputs),
    )
    generator = torch.Generator().manual_seed(0)
    for network in (ranker, translator):
        initialise(network, generator)
        for layer in network.modules():
            if isinstance(layer, torch.nn.BatchNorm2d):
                torch.nn.init.uniform_(layer.weight, 0.2, 0.6, generator=generator)
        network.eval().requires_grad_(False)
    translator.expect_ink(INK)
    return Checkpoint(preset, ranker, translator)
