"""Vehicles: cars and vans, aircraft, boats; bodies are sculpted, wheels, wings and masts added as shells."""

import itertools
from collections.abc import Callable

import numpy as np

from dataset_tools.collection.anatomy import SIDES, face_budget, groove
from dataset_tools.modelling.fields import common, drum, ellipsoid, frame, limb, prism, slab
from dataset_tools.modelling.patches import (
    block,
    lathe,
    loft,
    merged,
    mirrored,
    moved,
    refined,
    rounded_profile,
    sheet,
    tube,
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


def _wing(span: float, root: float, tip: float, sweep: float, lift: float, thick: float, rows: int = 14) -> Surface:
    """One wing towards +x: an aerofoil that tapers, sweeps and rises."""
    t = np.linspace(0, 1, 20)
    camber = 0.6 * thick * (1.48 * np.sqrt(t) - 0.63 * t - 1.758 * t**2 + 1.42 * t**3 - 0.5 * t**4)
    upper, lower = np.stack([0.5 - t, 1.6 * camber], 1), np.stack([0.5 - t, -camber], 1)[1:-1]
    section = np.concatenate([upper, lower[::-1]])
    place = np.concatenate([np.linspace(0, 0.97, rows), [0.985, 0.995, 1.0]])
    end = np.concatenate([np.ones(rows), [0.9, 0.7, 0.4]])
    chord = (root + (tip - root) * place) * end
    sections = [
        np.stack(
            [
                np.full(len(section), span * s),
                section[:, 1] * c + lift * span * s,
                section[:, 0] * c - sweep * span * s,
            ],
            1,
        )
        for s, c in zip(place, chord, strict=True)
    ]
    return loft(np.array(sections)[:, ::-1])


def aircraft(rng: np.random.Generator) -> Surface:
    """An aeroplane: airliner, jet, propeller plane or biplane, with engines, tail, windows, wheels, panel lines."""
    work = Sculpture()
    fat = rng.uniform(0.1, 0.2)
    bow, droop = rng.uniform(0.2, 0.35), rng.uniform(-0.04, 0.04)
    path = [
        (0, droop, 1.05),
        (0, 0.3 * droop, 1.05 - bow),
        (0, 0, 0.1),
        (0, 0.04, -0.5),
        (0, rng.uniform(0.05, 0.12), -1.0),
    ]
    work.add(limb(path, fat * np.array([0.25, 0.9, 1.0, 0.8, 0.22]), rng.uniform(0.85, 1.1), frame(np.pi / 2)))
    jet = rng.random() < 0.5
    if jet:
        windows = int(rng.integers(6, 14))
        for k in np.linspace(-0.5, 0.6, windows):
            for side in SIDES:
                work.cut(ellipsoid((side * fat, 0.03, k), (0.03, 0.028, 0.02)), blend=0.005)
        work.cut(slab((0, 0.75 * fat, 1.1 - bow), (0.7 * fat, 0.12 * fat, 0.06), 0.01, frame(0, 0.7)), blend=0.006)
    else:
        work.add(ellipsoid((0, 0.85 * fat, 0.25), (0.6 * fat, 0.75 * fat, 0.28)), blend=0.012)
        for z in (0.12, 0.3):
            arc = [(0.66 * fat * np.sin(a), 0.85 * fat + 0.76 * fat * np.cos(a), z) for a in np.linspace(-1.3, 1.3, 7)]
            work.add(limb(np.array(arc), 0.009), blend=0.005)
    for z in (0.7, 0.0, -0.55):
        arc = [(1.0 * fat * np.sin(a), fat * np.cos(a), z) for a in np.linspace(0, 2 * np.pi, 13)]
        work.cut(limb(np.array(arc), 0.007), blend=0.005)
    parts = [work.mesh(face_budget(rng, 8000, 20000))]
    span, root, sweep = (
        rng.uniform(0.75, 1.15),
        rng.uniform(0.3, 0.55),
        rng.uniform(0.25, 0.8) if jet else rng.uniform(-0.05, 0.2),
    )
    level, lift = rng.uniform(-0.6, 0.7) * fat, rng.uniform(-0.03, 0.15)
    wing = moved(_wing(span, root, root * rng.uniform(0.3, 0.8), sweep, lift, 0.13), (0, level, 0.15))
    parts.append(mirrored(wing, 0))
    if not jet and rng.random() < 0.35:
        parts.append(mirrored(moved(wing, (0, 2.2 * fat, 0.05)), 0))
        for x in (0.35, 0.8):
            foot, head = [
                (x * span, level + lift * x * span, 0.15 - sweep * x * span),
                (x * span, level + 2.2 * fat + lift * x * span, 0.2 - sweep * x * span),
            ]
            parts.append(mirrored(tube(np.linspace(foot, head, 5), 0.015, 8), 0))
    height, slope = rng.uniform(0.25, 0.45), rng.uniform(0.3, 0.9)
    fin = _wing(height, 0.32, 0.17, slope, 0.0, 0.12, 8)
    upright = np.array([[0, 1.0, 0], [-1.0, 0, 0], [0, 0, 1.0]])
    tee = rng.random() < 0.3
    parts.append(moved(fin, (0, 0.05, -0.8), upright))
    tail_at = (0, 0.05 + height if tee else 0.06, -0.85 - (slope * height if tee else 0.0))
    parts.append(
        mirrored(moved(_wing(rng.uniform(0.3, 0.45), 0.25, 0.14, 0.6 * sweep + 0.1, 0.05, 0.12, 8), tail_at), 0)
    )
    parts += _engines(rng, jet, span, level, lift, sweep, fat)
    if rng.random() < 0.6:
        for x, z in ((0.0, 0.75 if jet else -0.85), (0.22, 0.05), (-0.22, 0.05)):
            small = 0.06 if x or jet else 0.04
            low = -fat - 0.12
            parts.append(moved(wheel(rng, small, 0.05, 24), (x, low, z)))
            parts.append(tube(np.linspace((0.9 * x, -0.5 * fat, z), (x, low, z), 6), 0.014, 8))
    bank = frame(rng.uniform(-0.3, 0.3), rng.uniform(-0.15, 0.15), rng.uniform(-0.2, 0.2))
    return moved(merged(parts), axes=bank)


def _engines(
    rng: np.random.Generator, jet: bool, span: float, level: float, lift: float, sweep: float, fat: float
) -> list[Surface]:
    forward = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])
    if not jet:
        blades, parts = int(rng.integers(2, 5)), []
        spinner = lathe(rounded_profile([(0, -0.06), (0.07, -0.06), (0.065, 0.03), (0, 0.12)], 0.03), 24)
        parts.append(moved(spinner, (0, 0, 1.1), forward))
        for k in range(blades):
            blade = moved(_wing(0.3, 0.09, 0.05, 0.0, 0.0, 0.1, 8), axes=frame(0, 0.9))
            parts.append(moved(blade, (0, 0, 1.1), frame(0, 0, 0.3 + 2 * np.pi * k / blades)))
        return parts
    radius, long = rng.uniform(0.055, 0.09), rng.uniform(0.12, 0.2)
    corners = [
        (0, -1.3),
        (0.25, -1.25),
        (0.55, -0.8),
        (0.75, -1.0),
        (1.05, 0.1),
        (1.0, 0.9),
        (0.88, 1.0),
        (0.8, 0.7),
        (0.75, 0.2),
        (0.3, 0.2),
        (0, 0.6),
    ]
    pod = lathe(refined(rounded_profile(np.array(corners) * [radius, long], 0.3 * radius), 0.4 * radius), 28)
    places, parts = ((0.35,), (0.3, 0.62), (0.0,))[int(rng.integers(3))], []
    for x in places:
        at = (
            (x * span, level + lift * x * span - 1.25 * radius, 0.4 - sweep * x * span) if x else (1.5 * fat, 0.1, -0.6)
        )
        parts.append(mirrored(moved(pod, at, forward), 0))
        if x:
            pylon = np.linspace(np.array(at) + [0, 0.5 * radius, -0.02], np.array(at) + [0, 1.4 * radius, -0.15], 4)
            parts.append(mirrored(tube(pylon, 0.02, 8), 0))
        else:
            parts.append(mirrored(tube(np.linspace((0.5 * fat, 0.06, -0.6), at, 4), 0.03, 10), 0))
    return parts


def boat(rng: np.random.Generator) -> Surface:
    """A ship or boat: planked hull, deck, cabins, funnels or masts with sails, railing."""
    beam, depth, sheer, long = rng.uniform(0.2, 0.36), rng.uniform(0.18, 0.34), rng.uniform(0.05, 0.25), 1.0
    stern, planks = rng.uniform(0.3, 0.9), int(rng.integers(0, 7))
    rows, around = 46, 24
    s = np.linspace(-1, 1, rows)
    width = beam * np.where(s < 0, 1 - (1 - stern) * np.abs(s) ** 2.2, np.maximum(1 - np.abs(s) ** 2.4, 0.015))
    edge = sheer * np.abs(s) ** 2.5 * np.where(s < 0, 0.5, 1.0)
    keel = -depth * np.maximum(1 - np.maximum(s, 0) ** 4 * rng.uniform(0.4, 0.9) - 0.25 * np.maximum(-s, 0) ** 3, 0.1)
    u = np.linspace(0, np.pi, around)
    fullness = rng.uniform(0.55, 0.9)
    step = 1.0 + (0.035 * (((np.arange(around) * planks / 12) % 1.0) - 0.5) if planks else np.zeros(around))
    x = -np.sign(np.cos(u)) * np.abs(np.cos(u)) ** fullness * step
    y = np.sin(u) ** fullness * step
    hull = np.stack(
        [
            width[:, None] * x,
            edge[:, None] + (keel - edge)[:, None] * y,
            np.broadcast_to(s[:, None] * long, (rows, around)),
        ],
        -1,
    )
    wall, sunk = 0.94, rng.uniform(0.03, 0.09)
    lanes = np.array([1.0, wall, wall, 0.5, 0.0, -0.5, -wall, -wall, -1.0])
    drop = np.array([0.012, 0.012, -sunk, -sunk, -sunk, -sunk, -sunk, 0.012, 0.012])
    deck = np.stack([width[:, None] * lanes, edge[:, None] + drop, np.broadcast_to(s[:, None] * long, (rows, 9))], -1)
    parts = [loft(np.concatenate([hull, deck], axis=1))]
    floor = -sunk
    kind = int(rng.integers(3))
    z = rng.uniform(-0.55, -0.2)
    for level in range(int(rng.integers(1, 4))):
        half = np.array([beam * rng.uniform(0.4, 0.6), rng.uniform(0.06, 0.11), rng.uniform(0.15, 0.35)]) * 0.85**level
        cabin = Sculpture()
        cabin.add(slab((0, 0, 0), half, 0.02))
        for k in np.linspace(-0.75, 0.75, int(rng.integers(2, 6))):
            for side in SIDES:
                shape = ellipsoid(
                    (side * half[0], 0.1 * half[1], k * half[2]), (0.02, 0.35 * half[1], 0.09 * half[2] + 0.01)
                )
                cabin.cut(shape, blend=0.006)
        cabin.cut(slab((0, 0.15 * half[1], half[2]), (0.75 * half[0], 0.4 * half[1], 0.015), 0.01), blend=0.006)
        cabin.add(slab((0, half[1], 0), (half[0] + 0.02, 0.012, half[2] + 0.02), 0.01), blend=0.006)
        parts.append(moved(cabin.mesh(2500, finer=2.5), (0, floor + half[1], z)))
        floor += 2 * half[1]
        z += rng.uniform(-0.06, 0.08)
    if kind == 0:
        for k in range(int(rng.integers(1, 4))):
            high, lean = rng.uniform(0.12, 0.3), rng.uniform(0.0, 0.3)
            profile = rounded_profile(
                [
                    (0, 0),
                    (0.05, 0),
                    (0.05, 0.8 * high),
                    (0.06, 0.82 * high),
                    (0.06, high),
                    (0.045, high),
                    (0.04, 0.6 * high),
                    (0, 0.6 * high),
                ],
                0.008,
            )
            parts.append(
                moved(lathe(refined(profile, 0.04), 24), (0, floor - 0.01, z - 0.12 + 0.16 * k), frame(0, -lean))
            )
    else:
        parts += _rig(rng, beam, lambda z: float(np.interp(z, s, width)), sails=kind == 2)
    parts += _railing(s, width, edge, long)
    return moved(merged(parts), axes=frame(rng.uniform(-0.5, 0.5), rng.uniform(-0.08, 0.08), rng.uniform(-0.12, 0.12)))


def _rig(rng: np.random.Generator, beam: float, width: Callable[[float], float], sails: bool) -> list[Surface]:
    parts = []
    for z in np.linspace(-0.35, 0.5, int(rng.integers(1, 4))) + rng.uniform(-0.1, 0.1):
        high = rng.uniform(0.7, 1.2)
        parts.append(tube(np.linspace((0, -0.1, z), (0, high, z - 0.05), 14), np.linspace(0.022, 0.01, 14), 10))
        belly, swing = rng.uniform(0.05, 0.16), rng.uniform(-0.5, 0.5)
        for low, top in ((0.15, 0.55), (0.58, 0.92)) if sails else ():
            wide = beam * rng.uniform(0.9, 1.5) * (1.2 - top)
            a, b = np.meshgrid(np.linspace(0, 1, 16), np.linspace(-1, 1, 18), indexing="ij")
            bulge = belly * np.sin(np.pi * a) ** 0.7 * (1 - 0.6 * b**2)
            spot = np.stack([wide * b * (1.25 - 0.25 * a), high * (low + (top - low) * a), bulge], -1)
            parts.append(moved(sheet(spot, 0.008), (0, 0, z + 0.02), frame(swing)))
            for h in (low, top):
                yard = np.linspace((-1.2 * wide, h * high, 0), (1.2 * wide, h * high, 0), 8)
                parts.append(moved(tube(yard, 0.011, 8), (0, 0, z + 0.01), frame(swing)))
        for side in SIDES:
            for k in (-0.08, 0.08):
                parts.append(
                    tube(np.linspace((side * 0.93 * width(z + k), 0.0, z + k), (0, 0.9 * high, z - 0.04), 6), 0.005, 5)
                )
    return parts


def _railing(s: np.ndarray, width: np.ndarray, edge: np.ndarray, long: float) -> list[Surface]:
    parts = []
    for side in SIDES:
        top = np.stack([side * 0.96 * width, edge + 0.075, s * long], axis=1)[2:-2]
        parts.append(tube(top, 0.007, 6))
        for k in range(0, len(top), 4):
            parts.append(tube(np.linspace(top[k] - [0, 0.075, 0], top[k], 3), 0.006, 6))
    return parts
