"""Chairs and sofas: legs turned or square, slats, spindles, cushions."""

import numpy as np

from dataset_tools.modelling.anatomy import SIDES, warped
from dataset_tools.modelling.fields import frame, ripples, smooth_curve
from dataset_tools.modelling.patches import (
    block,
    lathe,
    merged,
    moved,
    refined,
    rounded_profile,
    tube,
)
from dataset_tools.modelling.sculpting import Surface
from ncmodel.types import Floats


def box(
    low: tuple[float, float, float], high: tuple[float, float, float], rounding: float, divisions: int = 4
) -> Surface:
    """A block between two corners."""
    a, b = np.array(low), np.array(high)
    return moved(block((b - a) / 2, rounding, 2, divisions), (a + b) / 2)


def cushion(rng: np.random.Generator, half: Floats, divisions: int = 14) -> Surface:
    """A stuffed block: swollen, creased at its corners, buttoned sometimes."""
    vertices, faces = block(half, 0.45 * float(np.min(half)), 3, divisions)
    local = vertices / half
    thin = int(np.argmin(half))
    others = [k for k in range(3) if k != thin]
    swell = np.prod([np.clip(1 - local[:, k] ** 4, 0, 1) for k in others], axis=0)
    height = vertices[:, thin] * (1 + rng.uniform(0.1, 0.45) * swell)
    if rng.random() < 0.35:
        count = rng.integers(2, 5, 2)
        pattern = np.prod(
            [np.cos(0.5 * np.pi * n * local[:, k]) ** 2 for n, k in zip(count, others, strict=True)], axis=0
        )
        height = height * (1 - 0.25 * (1 - pattern) * swell)
    crumple = ripples(rng, 0.5 * float(np.max(half)), 6)
    height = height + 0.05 * float(np.min(half)) * crumple(vertices) * np.sign(vertices[:, thin])
    placed = vertices.copy()
    placed[:, thin] = height
    return placed, faces


def leg(rng: np.random.Generator, top: Floats, foot: Floats, thick: float, style: int, seed: int) -> Surface:
    """A leg from the floor up: square, tapered, turned, or bent; the same for a style and a seed."""
    same = np.random.default_rng(seed)
    t = np.linspace(0, 1, 22)
    path = foot + t[:, None] * (top - foot)
    if style == 0:
        angle = np.arange(4) * np.pi / 2 + np.pi / 4
        corners = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        cut = np.concatenate(
            [
                [0.88 * a + 0.12 * b, 0.12 * a + 0.88 * b]
                for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)
            ]
        )
        return tube(path[::3], thick * (0.75 + 0.6 * t[::3]), section=1.2 * cut)
    if style == 1:
        radii = thick * smooth_curve(np.concatenate([[0.7], same.uniform(0.5, 1.3, 7), [1.1]])[:, None], 4)[:, 0]
        path = foot + np.linspace(0, 1, len(radii))[:, None] * (top - foot)
        return tube(path, radii, 20)
    if style == 2:
        sweep = 0.35 * np.sin(np.pi * t)[:, None] * np.array([foot[0], 0.0, foot[2]]) * same.uniform(-0.5, 0.6)
        return tube(path + sweep, thick * (0.6 + 0.6 * t**2), 14)
    return tube(path, thick * (0.55 + 0.5 * t), 16)


def chair(rng: np.random.Generator) -> Surface:
    """A chair, armchair, stool or swivel chair: legs, stretchers, arms, back of slats, spindles or stuffed."""
    wide, deep, seat = rng.uniform(0.42, 0.56), rng.uniform(0.4, 0.54), rng.uniform(0.42, 0.5)
    thick, style, seed = rng.uniform(0.02, 0.034), int(rng.integers(4)), int(rng.integers(1 << 30))
    parts: list[Surface] = []
    swivel = rng.random() < 0.25
    flare = rng.uniform(0.0, 0.12)
    corners = [np.array([x * (wide / 2 - 0.04), seat, z * (deep / 2 - 0.04)]) for x in SIDES for z in SIDES]
    feet = [np.array([c[0] * (1 + flare), 0.0, c[2] * (1 + flare)]) for c in corners]
    if swivel:
        stem = [
            (0, 0.1),
            (0.05, 0.1),
            (0.05, 0.22),
            (0.03, 0.22),
            (0.03, seat - 0.06),
            (0.12, seat - 0.04),
            (0, seat - 0.03),
        ]
        parts.append(lathe(refined(rounded_profile(stem, 0.01), 0.03), 24))
        for k in range(5):
            axes = frame(2 * np.pi * k / 5 + 0.3)
            arm = smooth_curve(np.array([(0, 0.13, 0.02), (0, 0.12, 0.15), (0, 0.08, 0.3)]), 5)
            parts.append(moved(tube(arm, np.linspace(0.035, 0.02, len(arm)), 10), axes=axes))
            caster = lathe(rounded_profile([(0, -0.02), (0.035, -0.02), (0.035, 0.02), (0, 0.02)], 0.01), 18)
            lying = np.array([[0, 1.0, 0], [1.0, 0, 0], [0, 0, -1.0]]) @ frame(rng.uniform(0, 3))
            parts.append(moved(moved(caster, axes=lying), axes[2] * 0.3 + [0, 0.035, 0]))
    else:
        parts += [leg(rng, top, foot, thick, style, seed) for top, foot in zip(corners, feet, strict=True)]
        for a, b in ((0, 1), (2, 3), (0, 2))[: int(rng.integers(0, 4))]:
            low = rng.uniform(0.2, 0.5)
            ends = [feet[k] + low * (corners[k] - feet[k]) for k in (a, b)]
            parts.append(tube(np.linspace(ends[0], ends[1], 6), 0.55 * thick, 10))
    if swivel or rng.random() < 0.55:
        parts.append(moved(cushion(rng, np.array([wide / 2, rng.uniform(0.03, 0.06), deep / 2])), (0, seat + 0.03, 0)))
    parts.append(box((-wide / 2, seat - 0.03, -deep / 2), (wide / 2, seat, deep / 2), rng.uniform(0.004, 0.014), 8))
    if rng.random() < 0.9:
        parts += _chair_back(rng, wide, deep, seat, thick, swivel)
    if rng.random() < 0.4:
        rest = seat + rng.uniform(0.18, 0.26)
        for side in SIDES:
            x = side * (wide / 2 + 0.01)
            knots = np.array(
                [
                    (x, seat, 0.3 * deep),
                    (x * 1.05, rest, 0.35 * deep),
                    (x, rest + 0.01, 0),
                    (x * 0.98, rest, -0.45 * deep),
                ]
            )
            parts.append(tube(smooth_curve(knots, 7), 0.9 * thick, 12))
            parts.append(box((x - 0.03, rest, -0.35 * deep), (x + 0.03, rest + 0.03, 0.4 * deep), 0.012))
    return moved(merged(parts), axes=frame(rng.uniform(-1.0, 1.0)))


def _chair_back(
    rng: np.random.Generator, wide: float, deep: float, seat: float, thick: float, padded: bool
) -> list[Surface]:
    high, lean, bow = rng.uniform(0.35, 0.65), rng.uniform(0.03, 0.16), rng.uniform(0.0, 0.07)
    back = -deep / 2 + 0.03

    def at(x: float, t: float) -> Floats:
        return np.array([x * (wide / 2 - 0.03), seat + t * high, back - lean * t - bow * (1 - x * x) * t])

    parts = []
    if padded or rng.random() < 0.25:
        pad = cushion(rng, np.array([wide / 2 - 0.01, 0.38 * high, 0.04]))
        parts.append(moved(pad, at(0, 0.62), frame(0, -lean / high)))
        post = smooth_curve(
            np.stack([at(0, -0.05) + [0, 0, 0.1], at(0, 0.1) - [0, 0, 0.05], at(0, 0.6) - [0, 0, 0.03]]), 6
        )
        parts.append(tube(post, 0.028, 12))
        return parts
    for side in SIDES:
        parts.append(
            tube(np.stack([at(side, t) for t in np.linspace(-0.02, 1.03, 12)]), thick * np.linspace(1.1, 0.8, 12), 14)
        )
    levels = (0.95, 0.3) if rng.random() < 0.6 else tuple(np.linspace(0.25, 0.95, int(rng.integers(3, 6))))
    angle = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    flat = np.stack([0.4 * np.cos(angle), np.sin(angle)], axis=1)
    for t in levels:
        rail = np.stack([at(x, t + 0.05 * (1 - x * x)) for x in np.linspace(-1, 1, 14)])
        parts.append(tube(rail, rng.uniform(0.025, 0.05), section=flat[:, ::-1] if rng.random() < 0.5 else flat))
    if len(levels) == 2:
        for x in np.linspace(-0.8, 0.8, int(rng.integers(3, 9))):
            spindle = np.stack([at(x, t) for t in np.linspace(0.3, 0.97, 9)])
            parts.append(tube(spindle, 0.4 * thick * (1 + 0.5 * np.sin(np.linspace(0, np.pi, 9))), 10))
    return parts


def sofa(rng: np.random.Generator) -> Surface:
    """A sofa, armchair or bed: stuffed seat and back cushions, arms, feet, pillows thrown on it."""
    seats, wide, deep = int(rng.integers(1, 4)), rng.uniform(0.5, 0.65), rng.uniform(0.6, 0.8)
    arm, seat, foot = rng.uniform(0.08, 0.2), rng.uniform(0.2, 0.3), rng.uniform(0.04, 0.14)
    half = seats * wide / 2
    parts = [box((-half - arm, foot, -deep / 2), (half + arm, foot + seat, deep / 2), 0.03, 10)]
    high, lean = rng.uniform(0.4, 0.6), rng.uniform(0.05, 0.3)
    parts.append(
        moved(
            cushion(rng, np.array([half + arm, high / 2, 0.08])),
            (0, foot + seat + 0.35 * high, -deep / 2),
            frame(0, -lean * 0.5),
        )
    )
    for k in range(seats):
        x = -half + (k + 0.5) * wide
        parts.append(
            moved(cushion(rng, np.array([wide / 2 - 0.005, 0.075, deep / 2 - 0.06])), (x, foot + seat + 0.07, 0.06))
        )
        parts.append(
            moved(
                cushion(rng, np.array([wide / 2 - 0.02, 0.4 * high, 0.085])),
                (x, foot + seat + 0.1 + 0.4 * high, -deep / 2 + 0.16),
                frame(rng.uniform(-0.06, 0.06), -lean),
            )
        )
    rest = rng.uniform(0.12, 0.28)
    scroll = rng.random() < 0.5
    for side in SIDES:
        x = side * (half + arm / 2)
        parts.append(
            moved(
                cushion(rng, np.array([arm / 2 + 0.01, (seat + rest) / 2, deep / 2 + 0.01]), 10),
                (x, foot + (seat + rest) / 2, 0),
            )
        )
        if scroll:
            roll = tube(
                np.stack(
                    [
                        np.full(12, x + 0.03 * side),
                        np.full(12, foot + seat + rest),
                        np.linspace(-deep / 2, deep / 2 + 0.02, 12),
                    ],
                    1,
                ),
                0.65 * arm + 0.01,
                24,
            )
            parts.append(roll)
        for z in SIDES:
            shape = [(0, 0), (0.025, 0), (0.045, foot), (0, foot)]
            parts.append(
                moved(lathe(rounded_profile(shape, 0.008), 16), (side * (half + 0.4 * arm), 0, z * (deep / 2 - 0.06)))
            )
    for _ in range(int(rng.integers(0, 4))):
        size = rng.uniform(0.14, 0.22)
        pillow = cushion(rng, np.array([size, size * rng.uniform(0.6, 1), 0.06]))
        axes = frame(rng.uniform(-0.5, 0.5), -rng.uniform(0.3, 0.7), rng.uniform(-0.5, 0.5))
        parts.append(moved(pillow, (rng.uniform(-half, half) * 0.8, foot + seat + 0.15 + size, -0.1), axes))
    return warped(moved(merged(parts), axes=frame(rng.uniform(-0.7, 0.7))), rng, 0.008)
