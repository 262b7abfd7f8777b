"""Cars, vans and pick-ups: a sculpted body with arches, panes, doors and lamps, on wheels with tread and spokes."""

import itertools

import numpy as np

from dataset_tools.modelling.anatomy import SIDES, face_budget, groove
from dataset_tools.modelling.fields import common, drum, ellipsoid, frame, limb, prism, slab
from dataset_tools.modelling.patches import (
    block,
    lathe,
    merged,
    moved,
    refined,
    rounded_profile,
)
from dataset_tools.modelling.sculpting import Sculpture, Surface

SIDEWAYS = np.array([[0, 0, 1.0], [0, 1.0, 0], [-1.0, 0, 0]])
"""Axes of an outline drawn across a vehicle: x points forward (along z)."""


def wheel(rng: np.random.Generator, radius: float, width: float, sides: int = 48) -> Surface:
    """A tyre with tread and a rim with spokes or holes' hub, its axle along x."""
    r, w = radius, width / 2
    rim, dish = r * rng.uniform(0.55, 0.72), w * rng.uniform(-0.2, 0.5)
    corners = [
        (0, -w),
        (rim, -w),
        (0.93 * r, -0.95 * w),
        (r, -0.6 * w),
        (r, 0.6 * w),
        (0.93 * r, 0.95 * w),
        (rim, w),
        (0.92 * rim, 0.8 * w),
    ]
    corners += [(0.85 * rim, dish), (0.35 * rim, dish + 0.1 * w), (0.3 * rim, dish + 0.4 * w), (0, dish + 0.45 * w)]
    profile = refined(rounded_profile(corners, 0.08 * r, 2), 0.12 * r)
    tread = np.ones((len(profile), sides))
    if rng.random() < 0.7:
        outer = (profile[:, 0] > 0.95 * r) & (np.abs(profile[:, 1]) < 0.75 * w)
        tread[np.ix_(outer, np.arange(sides) % 4 < 2)] = 0.955
    spokes = int(rng.integers(4, 9))
    inner = (profile[:, 0] > 0.4 * rim) & (profile[:, 0] < 0.84 * rim) & (profile[:, 1] > dish - 0.1 * w)
    turned_wheel = lathe(profile, sides, tread)
    lying = np.array([[0, 1.0, 0], [1.0, 0, 0], [0, 0, -1.0]])
    parts = [moved(turned_wheel, axes=lying)]
    if inner.any():
        for a in np.arange(spokes) * 2 * np.pi / spokes:
            axes = frame(0, a)
            bar = moved(block((0.12 * w, 0.5 * (0.9 * rim - 0.3 * rim), 0.09 * r), 0.02 * r, 1, 3), (0, 0.6 * rim, 0))
            parts.append((bar[0] @ axes + [dish + 0.25 * w, 0, 0], bar[1]))
    return merged(parts)


def _wheels(
    rng: np.random.Generator, places: list[tuple[float, float]], radius: float, width: float, track: float
) -> list[Surface]:
    """Wheels on both sides; the front ones steer."""
    steer = rng.uniform(-0.5, 0.5)
    one = wheel(rng, radius, width)
    parts = []
    for z, height in places:
        for side in SIDES:
            axes = frame((steer if z > 0 else 0.0) + (np.pi if side < 0 else 0.0))
            parts.append(moved(one, (side * track, height, z), axes))
    return parts


def car(rng: np.random.Generator) -> Surface:
    """A car, van, pick-up or lorry: body with arches, panes, doors, lamps, bumpers, mirrors, on wheels."""
    work = Sculpture()
    long, half, radius = rng.uniform(0.85, 1.2), rng.uniform(0.34, 0.44), rng.uniform(0.15, 0.22)
    floor, belt = radius * rng.uniform(0.8, 1.1), radius + rng.uniform(0.22, 0.36)
    roof = belt + rng.uniform(0.2, 0.38)
    kind = int(rng.integers(4))  # saloon, van, pick-up, estate
    nose = long * (0.85 if kind == 1 else rng.uniform(0.25, 0.5))
    tail = -long * (0.97 if kind in (1, 3) else rng.uniform(0.3, 0.65))
    rise, fall = rng.uniform(0.12, 0.3), rng.uniform(0.05, 0.25)
    edge = rng.uniform(0.03, 0.09)
    lower = [
        (-long, floor),
        (long, floor),
        (1.02 * long, floor + 0.1),
        (long, belt - 0.1),
        (nose + 0.1, belt),
        (tail, belt),
        (-long, belt - rng.uniform(0, 0.08)),
    ]
    work.add(prism(lower, half, axes=SIDEWAYS, rounding=edge))
    cabin = [
        (tail - fall * 0.4, belt - 0.1),
        (nose + rise, belt - 0.1),
        (nose + rise * 0.9, belt),
        (nose - 0.1, roof),
        (tail + fall, roof),
        (tail - fall * 0.3, belt),
    ]
    shoulders = 0.93 * half
    work.add(prism(cabin, shoulders, axes=SIDEWAYS, rounding=edge), blend=0.03)
    if kind == 2:
        work.cut(slab((0, belt, (tail - long) / 2), (half - 0.05, 0.2, (long + tail) / 2 - 0.05), 0.02), blend=0.01)
    axles = [0.62 * long, -0.6 * long] + ([-0.25 * long] if kind == 1 and rng.random() < 0.3 else [])
    for z in axles:
        for side in SIDES:
            at = np.array([side * half, radius, z])
            work.add(drum(at - [0.12 * side, 0, 0], at + [0.025 * side, 0, 0], 1.38 * radius, 0.02), blend=0.03)
            work.cut(drum(at - [0.17 * side, 0, 0], at + [side, 0, 0], 1.2 * radius), blend=0.01)
            work.cut(slab(at - [0, 1.4 * radius, 0], (0.15, 0.9 * radius, 1.2 * radius)), blend=0.01)
    posts = np.sort(rng.uniform(tail + 0.12, nose - 0.1, int(rng.integers(1, 3))))
    _panes(work, cabin, [tail + 0.05, *posts, nose + 0.05], shoulders, belt, roof)
    for side in SIDES:
        x = side * half
        for z in (*posts, nose):
            seam = [(x, belt - 0.02, z), (x * 1.01, (floor + belt) / 2, z), (x, floor + 0.05, z)]
            groove(work, np.array(seam), 0.008, 0.006)
            work.add(limb([(x * 1.02, belt - 0.08, z - 0.09), (x * 1.02, belt - 0.08, z - 0.03)], 0.013), blend=0.005)
        work.cut(
            limb(
                [
                    (x * 1.01, belt - 0.14, -0.8 * long),
                    (x * 1.015, belt - 0.13, 0),
                    (x * 1.01, belt - 0.15, 0.9 * long),
                ],
                0.01,
            ),
            blend=0.01,
        )
        work.add(
            ellipsoid((side * 0.72 * half, belt - 0.15, long - 0.005), (0.075, rng.uniform(0.04, 0.075), 0.04)),
            blend=0.006,
        )
        work.add(slab((side * 0.75 * half, belt - 0.14, -long), (0.06, 0.05, 0.025), 0.01), blend=0.006)
        work.add(ellipsoid((side * (half + 0.05), belt + 0.05, nose), (0.055, 0.04, 0.03)), blend=0.006)
    for k in range(int(rng.integers(2, 6))):
        work.cut(slab((0, floor + 0.1 + 0.035 * k, 1.02 * long), (0.4 * half, 0.009, 0.035)), blend=0.004)
    for end in (long, -long):
        path = [
            (-half, floor + 0.05, 0.93 * end),
            (-0.8 * half, floor + 0.04, 1.03 * end),
            (0.8 * half, floor + 0.04, 1.03 * end),
            (half, floor + 0.05, 0.93 * end),
        ]
        work.add(limb(path, 0.035), blend=0.008)
    if rng.random() < 0.4:
        for k in np.linspace(0.1, 0.9, int(rng.integers(2, 5))):
            z = tail + k * (nose - tail)
            work.add(limb([(-0.8 * half, roof + 0.03, z), (0.8 * half, roof + 0.03, z)], 0.016), blend=0.005)
        for side in SIDES:
            work.add(
                limb(
                    [(0.75 * side * half, roof + 0.02, tail + 0.1), (0.75 * side * half, roof + 0.02, nose - 0.15)],
                    0.016,
                ),
                blend=0.005,
            )
    body = work.mesh(face_budget(rng, 12000, 30000), finer=1.8)
    return merged([body, *_wheels(rng, [(z, radius) for z in axles], radius, 0.13, half - 0.055)])


def _panes(
    work: Sculpture, cabin: list[tuple[float, float]], posts: list[float], half: float, belt: float, roof: float
) -> None:
    """Sunken panes: at the sides between posts, in front, behind."""
    inside = prism(np.array(cabin), half, axes=SIDEWAYS)
    for a, b in itertools.pairwise(posts):
        for side in SIDES:
            pane = slab(
                (side * half, (belt + roof) / 2 + 0.01, (a + b) / 2),
                (0.02, 0.36 * (roof - belt), (b - a) / 2 - 0.03),
                0.015,
            )
            work.cut(common(pane, [inside]), blend=0.006)
    for (z, y), (z2, y2) in ((cabin[2], cabin[3]), (cabin[5], cabin[4])):
        slope = np.arctan2(z - z2, y2 - y)
        axes = frame(0, -slope)
        reach = 0.4 * float(np.hypot(z - z2, y2 - y))
        work.cut(slab((0, (y + y2) / 2, (z + z2) / 2), (0.82 * half, reach, 0.02), 0.015, axes), blend=0.006)
