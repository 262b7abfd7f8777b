"""Cabinets, chests and bookcases: drawers, doors that stand open, knobs, books."""

import numpy as np

from dataset_tools.generators.seats import box, leg
from dataset_tools.modelling.anatomy import SIDES
from dataset_tools.modelling.fields import frame, smooth_curve
from dataset_tools.modelling.patches import (
    lathe,
    merged,
    moved,
    outwards,
    refined,
    rounded_profile,
    tube,
)
from dataset_tools.modelling.sculpting import Surface
from ncmodel.types import Floats


def cabinet(rng: np.random.Generator) -> Surface:
    """A chest, dresser, bookcase, desk or table: drawers and doors open a little, knobs, things on it."""
    wide, high, deep = rng.uniform(0.6, 1.4), rng.uniform(0.6, 1.5), rng.uniform(0.35, 0.6)
    foot, wall = rng.uniform(0.05, 0.3), rng.uniform(0.018, 0.035)
    thick, style, seed = 0.035, int(rng.integers(4)), int(rng.integers(1 << 30))
    parts = []
    for x in SIDES:
        for z in SIDES:
            top = np.array([x * (wide / 2 - 0.05), foot + 0.01, z * (deep / 2 - 0.05)])
            parts.append(leg(rng, top, top * [1.02, 0, 1.02], thick, style, seed))
    columns, rows = int(rng.integers(1, 4)), int(rng.integers(2, 6))
    parts.append(box((-wide / 2, foot, -deep / 2), (wide / 2, foot + wall, deep / 2), 0.004))
    parts.append(box((-wide / 2, foot, -deep / 2), (wide / 2, foot + high, -deep / 2 + wall), 0.004))
    for k in range(columns + 1):
        x = -wide / 2 + wide * k / columns
        parts.append(box((x - wall / 2, foot, -deep / 2), (x + wall / 2, foot + high, deep / 2), 0.004, 6))
    over = rng.uniform(0.0, 0.06)
    parts.append(
        box(
            (-wide / 2 - over, foot + high, -deep / 2),
            (wide / 2 + over, foot + high + 0.04, deep / 2 + over),
            rng.uniform(0.005, 0.018),
            8,
        )
    )
    knob = lathe(
        refined(
            rounded_profile([(0, 0), (0.012, 0), (0.01, 0.015), (0.024, 0.03), (0.015, 0.042), (0, 0.045)], 0.006), 0.01
        ),
        16,
    )
    outward = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])
    bar = rng.random() < 0.5
    for column in range(columns):
        left, right = (-wide / 2 + wide * (column + k) / columns for k in (0, 1))
        kind = int(rng.integers(3))
        for row in range(rows):
            low, upper = (foot + wall + (high - wall) * (row + k) / rows for k in (0, 1))
            parts.append(box((left, low - wall / 2, -deep / 2), (right, low + wall / 2, deep / 2 - 0.02), 0.003))
            if kind == 0:
                parts += _drawer(rng, (left, low, right, upper), deep, wall, knob, outward, bar)
            elif kind == 1:
                parts += _books(rng, (left, low, right, upper), deep)
        if kind == 2:
            hinge = rng.uniform(0.0, 1.2) if rng.random() < 0.6 else 0.0
            width = right - left - wall
            door = merged(
                [
                    box((0, 0.01, -wall), (width, high - 0.02, 0), 0.004, 6),
                    *(
                        box((a, b, 0), (c, d, 0.012), 0.005)
                        for a, b, c, d in (
                            (0, 0, 0.06, high),
                            (width - 0.06, 0, width, high),
                            (0, 0, width, 0.06),
                            (0, high - 0.07, width, high),
                            (0, 0.5 * high, width, 0.5 * high + 0.06),
                        )
                    ),
                    moved(knob, (width - 0.03, 0.55 * high, 0.01), outward),
                ]
            )
            parts.append(moved(door, (left + wall / 2, foot, deep / 2), frame(-hinge)))
    for _ in range(int(rng.integers(0, 3))):
        radius, tall = rng.uniform(0.04, 0.09), rng.uniform(0.1, 0.3)
        body = smooth_curve(
            np.array([(0.6 * radius, 0), (radius, 0.4 * tall), (0.4 * radius, 0.8 * tall), (0.6 * radius, tall)]), 7
        )
        pot = outwards(lathe(np.concatenate([body, (body - [0.012, 0])[::-2][:-2]]), 32))
        parts.append(moved(pot, (rng.uniform(-0.4, 0.4) * wide, foot + high + 0.04, rng.uniform(-0.2, 0.2) * deep)))
    return moved(merged(parts), axes=frame(rng.uniform(-0.6, 0.9)))


def _drawer(
    rng: np.random.Generator,
    front: tuple[float, float, float, float],
    deep: float,
    wall: float,
    knob: Surface,
    outward: Floats,
    bar: bool,
) -> list[Surface]:
    left, low, right, top = front
    out = float(rng.choice([0.0, 0.0, 0.0, rng.uniform(0.05, 0.25)]))
    z, gap = deep / 2 + out, 0.006 + wall / 2
    parts = [box((left + gap, low + gap, z - 0.02), (right - gap, top - gap, z + 0.015), 0.007, 6)]
    inset = 0.035
    if top - low > 0.15:
        parts.append(
            box((left + gap + inset, low + gap + inset, z), (right - gap - inset, top - gap - inset, z + 0.024), 0.008)
        )
    if out:
        for x in (left + 0.03, right - 0.05):
            parts.append(box((x, low + 0.03, z - out - 0.1), (x + 0.014, top - 0.05, z), 0.003))
        parts.append(box((left + 0.03, low + 0.03, z - out - 0.1), (right - 0.03, low + 0.045, z), 0.003))
    middle, level = (left + right) / 2, (low + top) / 2
    if bar:
        reach = 0.25 * (right - left)
        grip = np.array(
            [
                (middle - reach, level, z),
                (middle - reach, level, z + 0.05),
                (middle + reach, level, z + 0.05),
                (middle + reach, level, z),
            ]
        )
        return [*parts, tube(rounded_profile(refined(grip, 0.06), 0.015), 0.009, 10)]
    spots = (middle,) if right - left < 0.45 else (left + 0.25 * (right - left), right - 0.25 * (right - left))
    return parts + [moved(knob, (x, level, z + 0.02), outward) for x in spots]


def _books(rng: np.random.Generator, front: tuple[float, float, float, float], deep: float) -> list[Surface]:
    left, low, right, top = front
    parts, x = [], left + 0.03
    while x < right - 0.08 and rng.random() < 0.93:
        width, tall = rng.uniform(0.018, 0.05), (top - low) * rng.uniform(0.55, 0.88)
        book = box((0, 0, 0), (width, tall, 0.6 * deep), 0.004, 2)
        tilt = frame(0, 0, rng.uniform(0.1, 0.25)) if rng.random() < 0.1 else frame()
        parts.append(moved(book, (x, low + 0.012, deep * rng.uniform(-0.25, -0.15)), tilt))
        x += width + (0.06 if tilt[0, 1] else 0.003)
    return parts
