"""How long training on the paper's whole set takes, computed from measured steps."""

from collections.abc import Sequence
from dataclasses import dataclass

from eval.throughput.training import Setup, Speed
from ncmodel.data.item import DRAWINGS
from ncmodel.nets.presets import PRESETS

ITEMS = 21_609
"""Views in the paper's set."""

PROCESSES = 8

EXCHANGE = 200e9
"""Bytes a second at which GPUs of one machine add up gradients; assumed, a third of what NVLink 4 gives on paper."""


@dataclass(frozen=True)
class Growth:
    """A stage on the paper's set.

    Attributes:
        setup: What it is computed from.
        passes: Over the data, as the preset has them.
        steps: In a pass.
        hours: Of all passes on one device.
        hours_on_many: On `PROCESSES` of them, each looking at its part of every step; 0 where that wasn't measured.
        views_needed: Views a second that must be read then, for all of them.
    """

    setup: Setup
    passes: int
    steps: int
    hours: float
    hours_on_many: float
    views_needed: float


def growth_of(speeds: Sequence[Speed]) -> list[Growth]:
    """The stages whose steps were measured whole; on many devices where the part of one was measured too."""
    parts = {(s.setup.preset, s.setup.stage): s for s in speeds if s.setup.batch is not None and s.steps}
    found = []
    for speed in speeds:
        if speed.steps and speed.setup.batch is None:
            part = parts.get((speed.setup.preset, speed.setup.stage))
            fits = part is not None and (part.setup.bfloat16, part.setup.workers) == (
                speed.setup.bfloat16,
                speed.setup.workers,
            )
            found.append(_growth(speed, part if fits else None))
    return found


def _growth(speed: Speed, part: Speed | None) -> Growth:
    setup = speed.setup
    rates = PRESETS[setup.preset].rates(setup.stage)
    examples = ITEMS if setup.stage == "translator" else ITEMS * (DRAWINGS - 1)
    steps = round(examples / rates.batch)
    hours = rates.epochs * steps * speed.seconds / 3600
    if part is None:
        return Growth(setup, rates.epochs, steps, hours, 0.0, speed.views)
    # Gradients travel twice round a ring, in float32. A part of more than its share of the step makes fewer steps.
    exchange = 2 * (PROCESSES - 1) / PROCESSES * 4 * part.parameters / EXCHANGE
    seconds = part.seconds + exchange
    steps_of_many = examples / (part.batch * PROCESSES)
    on_many = rates.epochs * steps_of_many * seconds / 3600
    return Growth(setup, rates.epochs, steps, hours, on_many, ITEMS * rates.epochs / (on_many * 3600))
