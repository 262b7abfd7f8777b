"""Aircraft and boats: sculpted hulls and cabins, wings, engines, masts and sails as shells."""

from collections.abc import Callable

import numpy as np

from dataset_tools.generators.cars import wheel
from dataset_tools.modelling.anatomy import SIDES, face_budget
from dataset_tools.modelling.fields import ellipsoid, frame, limb, slab
from dataset_tools.modelling.patches import (
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
