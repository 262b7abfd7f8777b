"""Mechanical parts: toothed wheels, housings, pipe fittings, tools; fillets, bores, ribs, threads, engraved marks."""

import numpy as np

from dataset_tools.modelling.anatomy import face_budget
from dataset_tools.modelling.fields import (
    Part,
    Place,
    drum,
    ellipsoid,
    frame,
    limb,
    placed,
    prism,
    repeated,
    ring,
    slab,
    turned,
)
from dataset_tools.modelling.sculpting import Sculpture, Surface
from ncmodel.types import Floats

UP = np.array([0.0, 1.0, 0.0])


def tumbled(surface: Surface, rng: np.random.Generator) -> Surface:
    """A part lying or standing some way round, as parts are modelled."""
    axes = np.eye(3)[list([(0, 1, 2), (0, 1, 2), (1, 2, 0), (2, 0, 1)][int(rng.integers(4))])]
    return surface[0] @ axes.T @ frame(rng.uniform(-0.6, 0.6)), surface[1]


def gearwheel(rng: np.random.Generator) -> Surface:
    """A toothed wheel, spur or helical, a sprocket or a pinion on a shaft: hub, keyway, web with holes or spokes."""
    work = Sculpture()
    teeth, half = int(rng.integers(9, 30)), rng.uniform(0.08, 0.35)
    tall, lean = rng.uniform(0.5, 0.8) * 5.0 / teeth, rng.uniform(0.3, 0.6)
    pitch = np.pi / teeth
    root = 1.0 - 0.55 * tall
    foot, tip = 0.62 * pitch * root, lean * pitch
    twist = rng.uniform(-0.8, 0.8) if rng.random() < 0.35 else 0.0
    round_tip = rng.random() < 0.3
    tooth = [
        (-foot, root - 0.1),
        (-0.9 * foot, root),
        (-tip, 1 + 0.45 * tall),
        (tip, 1 + 0.45 * tall),
        (0.9 * foot, root),
        (foot, root - 0.1),
    ]
    if round_tip:
        tooth[2:4] = [(-1.3 * tip, 1.0), (-0.5 * tip, 1 + 0.4 * tall), (0.5 * tip, 1 + 0.4 * tall), (1.3 * tip, 1.0)]
    flat_on = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])  # the outline's y runs outwards along z
    work.add(drum(-half * UP, half * UP, root, 0.015))
    work.add(repeated(prism(tooth, half, axes=flat_on, rounding=0.012), teeth, twist), blend=0.03)
    bore = rng.uniform(0.1, 0.22)
    hub = bore + rng.uniform(0.07, 0.15)
    lift, other = half + rng.uniform(0.0, 0.25), half + rng.uniform(0.0, 0.1)
    rim = root - rng.uniform(0.1, 0.16)
    sunk = half * rng.uniform(0.3, 0.8)
    if rim > hub + 0.15:
        for sign in (-1.0, 1.0):
            outline = [
                (hub, sign * (half - sunk)),
                (rim, sign * (half - sunk)),
                (rim + 0.03, sign * (half + 0.1)),
                (hub - 0.02, sign * (half + 0.1)),
            ]
            work.cut(turned(outline), blend=0.04)
        holes, middle = int(rng.integers(3, 8)), (hub + rim) / 2
        size = min(0.42 * (rim - hub), 0.8 * np.pi * middle / holes)
        if rng.random() < 0.5:
            work.cut(repeated(drum((0, -1, middle), (0, 1, middle), 0.85 * size), holes), blend=0.025)
        elif rng.random() < 0.6:
            sector = limb([(-0.55 * size, 0, middle), (0, 0, middle + 0.06), (0.55 * size, 0, middle)], 0.6 * size)
            work.cut(
                repeated(
                    Part(lambda p: sector.distance(p * [1, 0, 1]), sector.low - [0, 1, 0], sector.high + [0, 1, 0]),
                    holes,
                ),
                blend=0.025,
            )
        else:
            work.add(repeated(slab((0, 0, middle), (0.04, 0.8 * half, 0.55 * (rim - hub)), 0.02), holes), blend=0.03)
    work.add(drum(-other * UP, lift * UP, hub, 0.02), blend=0.03)
    if rng.random() < 0.3:
        work.add(drum(-rng.uniform(0.3, 1.2) * UP, rng.uniform(0.6, 1.4) * UP, 0.9 * bore, 0.03), blend=0.02)
        work.add(ring(0.5 * UP, UP, 0.9 * bore, 0.03), blend=0.01)
    else:
        work.cut(drum(-2 * UP, 2 * UP, bore), blend=0.02)
        work.cut(slab((0, 0, bore), (0.3 * bore, 2, 0.35 * bore)), blend=0.012)
        if lift > half + 0.12:
            work.cut(drum((0, half + 0.5 * (lift - half), 0), (1, half + 0.5 * (lift - half), 0), 0.035), blend=0.01)
    return tumbled(work.mesh(face_budget(rng, 7000, 28000), finer=3.5), rng)


def housing(rng: np.random.Generator) -> Surface:
    """A cast or milled part: foot, block or barrel, bosses, gussets, fins, stepped bores, engraved marks."""
    work = Sculpture()
    long, deep, foot = rng.uniform(0.7, 1.1), rng.uniform(0.4, 0.7), rng.uniform(0.06, 0.1)
    fillet = rng.uniform(0.03, 0.07)
    work.add(slab((0, foot, 0), (long, foot, deep), 0.03))
    high, offset = rng.uniform(0.4, 0.9), rng.uniform(-0.2, 0.2) * long
    body = np.array([rng.uniform(0.45, 0.65) * long, high / 2, rng.uniform(0.5, 0.75) * deep])
    middle = np.array([offset, foot + high / 2, rng.uniform(-0.15, 0.1) * deep])
    bore = 0.55 * min(body[1], body[0])
    if rng.random() < 0.45:
        radius = 0.62 * high
        axis_height = foot + radius * 0.95
        work.add(
            drum((offset - body[0], axis_height, middle[2]), (offset + body[0], axis_height, middle[2]), radius, 0.03),
            blend=fillet,
        )
        work.add(
            slab((offset, foot + 0.4 * radius, middle[2]), (0.9 * body[0], 0.5 * radius, 0.9 * radius), 0.03),
            blend=fillet,
        )
        for sign in (-1.0, 1.0):
            end = np.array([offset + sign * body[0], axis_height, middle[2]])
            flange = Place(end, frame(0, 0, np.pi / 2))
            work.add(drum(end - [0.05, 0, 0], end + [0.05, 0, 0], 1.22 * radius, 0.015), blend=0.02)
            work.cut(
                placed(
                    repeated(drum((0, -0.2, 1.1 * radius), (0, 0.2, 1.1 * radius), 0.035), int(rng.integers(5, 11))),
                    flange,
                ),
                blend=0.01,
            )
        bore, axis_at = 0.7 * radius, np.array([offset, axis_height, middle[2]])
        across = np.array([1.0, 0, 0])
    else:
        work.add(slab(middle, body, rng.uniform(0.03, 0.1)), blend=fillet)
        across = np.array([0, 0, 1.0]) if rng.random() < 0.7 else np.array([1.0, 0, 0])
        axis_at = middle + [0, 0.12 * high, 0]
        for sign in (1.0, -1.0)[: int(rng.integers(1, 3))]:
            reach = body @ np.abs(across)
            work.add(drum(axis_at, axis_at + sign * (reach + 0.1) * across, bore + 0.1, 0.02), blend=fillet)
    work.cut(drum(axis_at - 2 * across, axis_at + 2 * across, 0.6 * bore), blend=0.02)
    work.cut(drum(axis_at + (0.3 * (body @ across)) * across, axis_at + 2 * across, bore), blend=0.02)
    for x in (-1.0, 1.0):
        for z in (-1.0, 1.0):
            at = np.array([0.85 * x * long, 0, 0.78 * z * deep])
            work.add(drum(at, at + [0, 2.6 * foot, 0], 0.11, 0.015), blend=0.02)
            work.cut(drum(at - UP, at + UP, 0.05), blend=0.01)
    for k in range(int(rng.integers(0, 4))):
        z = middle[2] + (k - 1) * 0.4 * body[2]
        for sign in (-1.0, 1.0):
            gusset = [(-0.1, 0), (0.9 * (long - abs(offset) - body[0]) + 0.05, 0), (-0.1, rng.uniform(0.5, 0.9) * high)]
            axes = frame(0.0 if sign > 0 else np.pi)
            work.add(prism(gusset, 0.03, (offset + sign * body[0], 2 * foot, z), axes, 0.012), blend=0.03)
    top = middle[1] + body[1]
    extra = int(rng.integers(4))
    if extra == 0:
        for x in np.linspace(-0.8, 0.8, int(rng.integers(4, 9))):
            work.add(slab((offset + x * body[0], top, middle[2]), (0.025, 0.15, 0.85 * body[2]), 0.01), blend=0.02)
    elif extra == 1:
        at = np.array([offset + rng.uniform(-0.3, 0.3), top, middle[2]])
        work.add(drum(at - [0, 0.3, 0], at + [0, 0.22, 0], 0.16, 0.02), blend=0.04)
        work.add(drum(at + [0, 0.18, 0], at + [0, 0.25, 0], 0.22, 0.015), blend=0.02)
        work.cut(drum(at - [0, 0.1, 0], at + UP, 0.1), blend=0.015)
    elif extra == 2:
        work.add(drum((offset - 0.3, top, middle[2]), (offset + 0.3, top, middle[2]), 0.06), blend=0.03)
    _marks(work, rng, np.array([offset, middle[1], middle[2] + body[2]]), body)
    if rng.random() < 0.5:
        work.cut(slab((0, 0, 0), (0.5 * long, 0.4 * foot, 2)), blend=0.02)
    return tumbled(work.mesh(face_budget(rng, 7000, 28000), finer=3.5), rng)


def _marks(work: Sculpture, rng: np.random.Generator, at: Floats, half: Floats) -> None:
    """A frame and strokes like letters, engraved in the front."""
    x, y = rng.uniform(-0.75, -0.4) * half[0], rng.uniform(-0.7, -0.4) * half[1]
    size = rng.uniform(0.05, 0.09)
    for k in range(int(rng.integers(3, 7))):
        for _ in range(int(rng.integers(2, 4))):
            ends = rng.choice([0.0, 0.5, 1.0], (2, 2)) * [0.7, 1.3]
            if np.ptp(ends, axis=0).max() > 0:
                path = [at + [x + size * (1.05 * k + u), y + size * v, 0] for u, v in ends]
                work.cut(limb(path, 0.011), blend=0.006)
    if rng.random() < 0.5:
        low, high = at + [x - 0.05, y - 0.05, 0], at + [x + 7.5 * size, y + 1.6 * size + 0.05, 0]
        for a, b in (((0, 0), (1, 0)), ((1, 0), (1, 1)), ((1, 1), (0, 1)), ((0, 1), (0, 0))):
            corner = [np.array([(low, high)[u][0], (low, high)[v][1], at[2]]) for u, v in (a, b)]
            work.cut(limb(corner, 0.012), blend=0.006)


def fitting(rng: np.random.Generator) -> Surface:
    """A valve, joint or nozzle: turned body with flanges, hexagon, thread, side branch, hand wheel or lever."""
    work = Sculpture()
    radius, reach = rng.uniform(0.2, 0.32), rng.uniform(0.7, 1.1)
    work.add(drum(-reach * UP, reach * UP, radius, 0.02))
    work.add(ellipsoid((0, 0, 0), radius * np.array([1.5, 1.7, 1.5])), blend=0.1)
    for sign in (-1.0, 1.0):
        kind = int(rng.integers(3))
        end = sign * reach
        if kind == 0:
            wide, bolts = radius + rng.uniform(0.18, 0.28), int(rng.integers(4, 10))
            work.add(drum((0, end - 0.06, 0), (0, end + 0.06, 0), wide, 0.02), blend=0.04)
            lane = (wide + radius) / 2
            bolt = drum((0, end - 0.2, lane), (0, end + 0.2, lane), 0.045)
            if rng.random() < 0.5:
                work.cut(repeated(bolt, bolts), blend=0.012)
            else:
                work.add(repeated(drum((0, end - 0.11, lane), (0, end + 0.11, lane), 0.05, 0.012), bolts), blend=0.01)
        elif kind == 1:
            hexagon = [(1.35 * radius * np.cos(a), 1.35 * radius * np.sin(a)) for a in np.arange(6) * np.pi / 3]
            work.add(prism(hexagon, 0.12, (0, end - 0.25 * sign, 0), frame(0, np.pi / 2), 0.02), blend=0.02)
            turns = int(rng.integers(5, 10))
            for y in np.linspace(end - 0.1 * sign, end + 0.25 * sign, turns):
                work.add(ring((0, y, 0), UP, 0.98 * radius, 0.02), blend=0.012)
            work.add(drum((0, end, 0), (0, end + 0.3 * sign, 0), 0.97 * radius, 0.03), blend=0.01)
        else:
            for y in np.linspace(0.4, 1.0, int(rng.integers(3, 6))) * end:
                barb = [
                    (0, y - 0.06),
                    (0.85 * radius, y - 0.06),
                    (1.18 * radius, y - 0.05 * sign),
                    (0.9 * radius, y + 0.06),
                    (0, y + 0.06),
                ]
                work.add(turned(barb), blend=0.015)
    swing = rng.uniform(-0.5, 0.5)
    side = np.array([0.0, np.sin(swing), np.cos(swing)])
    length = rng.uniform(0.6, 0.95)
    work.add(drum(0 * side, length * side, 0.75 * radius, 0.02), blend=0.1)
    work.add(drum((length - 0.1) * side, length * side, 1.1 * radius, 0.02), blend=0.03)
    for way, share in ((UP, 0.62), (-UP, 0.62), (side, 0.46)):
        work.cut(drum(0.3 * way, 2 * way, share * radius), blend=0.015)
    if rng.random() < 0.6:
        axis = np.array([1.0, 0.0, 0.0])
        work.add(drum(0 * axis, 0.62 * axis, 0.6 * radius, 0.02), blend=0.06)
        work.add(drum(0 * axis, 0.95 * axis, 0.06), blend=0.02)
        if rng.random() < 0.6:
            wheel, spokes = rng.uniform(0.3, 0.42), int(rng.integers(3, 7))
            centre = Place(0.92 * axis, frame(0, 0, -np.pi / 2))
            work.add(placed(ring((0, 0, 0), UP, wheel, 0.045), centre))
            work.add(
                placed(repeated(limb([(0, 0, 0), (0, 0.02, wheel / 2), (0, 0, wheel)], 0.032), spokes), centre),
                blend=0.02,
            )
            work.add(ellipsoid(0.94 * axis, 0.1), blend=0.02)
        else:
            work.add(
                limb([0.9 * axis, 0.93 * axis + 0.4 * UP, 0.98 * axis + 0.9 * UP], [0.07, 0.05, 0.065], 0.6), blend=0.02
            )
    return tumbled(work.mesh(face_budget(rng, 7000, 28000), finer=3.5), rng)


def tool(rng: np.random.Generator) -> Surface:
    """A hand tool: hammer, spanner, screwdriver or pistol-shaped, with a grip that is ribbed or fluted."""
    work = Sculpture()
    kind = int(rng.integers(4))
    thick = rng.uniform(0.08, 0.12)
    grip = [(0, -1.0, 0), (rng.uniform(-0.06, 0.06), -0.6, 0), (0, -0.1, 0)]
    work.add(limb(grip, thick * np.array([0.95, 1.1, 0.8]), 0.85))
    flutes = int(rng.integers(5, 11))
    if rng.random() < 0.5:
        for y in np.linspace(-0.95, -0.35, flutes):
            work.cut(ring((0, y, 0), UP, 1.15 * thick, 0.022), blend=0.015)
    else:
        work.cut(repeated(limb([(0, -0.95, 1.05 * thick), (0, -0.4, 1.05 * thick)], 0.25 * thick), flutes), blend=0.015)
    neck = rng.uniform(0.35, 0.6)
    work.add(drum((0, -0.2, 0), (0, neck, 0), 0.05, 0.01), blend=0.03)
    if kind == 0:
        work.add(slab((0, neck, 0), (0.1, 0.1, 0.16), 0.03), blend=0.03)
        work.add(drum((0, neck, 0.1), (0, neck, 0.38), 0.085), blend=0.03)
        work.add(drum((0, neck, 0.36), (0, neck, 0.5), 0.13, 0.025), blend=0.02)
        for side in (-1.0, 1.0):
            claw = [
                (0.04 * side, neck, -0.1),
                (0.06 * side, neck + 0.04, -0.35),
                (0.08 * side, neck - rng.uniform(0.05, 0.3), -0.55),
            ]
            work.add(limb(claw, [0.09, 0.065, 0.03]), blend=0.02)
    elif kind == 1:
        size = rng.uniform(0.18, 0.28)
        work.add(slab((0, 0.0, 0), (0.09, neck, 0.035), 0.03), blend=0.02)
        work.add(drum((0, neck + 0.1, -0.06), (0, neck + 0.1, 0.06), size, 0.02), blend=0.05)
        work.cut(
            slab((0.02, neck + 0.25, 0), (0.5 * size, 0.22, 1), 0.02, frame(0, 0, rng.uniform(-0.4, 0.4))), blend=0.015
        )
        work.cut(slab((0, 0.1, 0.05), (0.045, 0.5 * neck, 0.025), 0.02), blend=0.015)
        _marks(work, rng, np.array([0.05, 0.05, 0.055]), np.array([0.1, 0.1, 0.1]))
    elif kind == 2:
        work.add(drum((0, -0.1, 0), (0, neck + 0.6, 0), 0.042), blend=0.02)
        work.add(ring((0, -0.05, 0), UP, 0.06, 0.03), blend=0.02)
        work.add(slab((0, neck + 0.65, 0), (0.07, 0.14, 0.02), 0.01), blend=0.03)
    else:
        work.add(limb([(0, 0, -0.45), (0, 0.04, 0), (0, 0, 0.55)], [0.19, 0.21, 0.15]), blend=0.08)
        for z in np.linspace(0.3, 0.75, 4):
            work.add(drum((0, 0, z), (0, 0, z + 0.09), 0.15 - 0.1 * (z - 0.3), 0.015), blend=0.012)
        work.add(drum((0, 0, 0.7), (0, 0, 1.2), 0.03, 0.01), blend=0.01)
        work.add(limb([(0, -0.2, 0.12), (0, -0.3, 0.16), (0, -0.38, 0.12)], 0.035), blend=0.02)
        work.add(slab((0, -1.05, 0.03), (0.13, 0.1, 0.2), 0.03), blend=0.02)
        for k in range(int(rng.integers(3, 7))):
            for side in (-1.0, 1.0):
                work.cut(slab((0.2 * side, 0.02, -0.35 + 0.07 * k), (0.05, 0.09, 0.015), 0.01), blend=0.008)
        for y in (-0.12, 0.12):
            work.cut(limb([(-0.3, y, -0.4), (-0.3, 0.6 * y, 0.1)], 0.1), blend=0.03)
    return tumbled(work.mesh(face_budget(rng, 6000, 22000), finer=3.5), rng)
