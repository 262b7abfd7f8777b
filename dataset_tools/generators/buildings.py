"""Buildings: houses with roofs of tiles, temples with columns, towers and castle walls."""

import numpy as np

from dataset_tools.modelling.fields import frame
from dataset_tools.modelling.patches import (
    block,
    extrusion,
    lathe,
    loft,
    merged,
    moved,
    outwards,
    refined,
    rounded_profile,
    tube,
)
from dataset_tools.modelling.sculpting import Surface

Corner = tuple[float, float, float]


def _box(low: Corner, high: Corner, rounding: float = 0.006, divisions: int = 1) -> Surface:
    a, b = np.array(low), np.array(high)
    return moved(block((b - a) / 2, rounding, 1, divisions), (a + b) / 2)


def _window(rng: np.random.Generator, wide: float, high: float, style: np.random.Generator) -> Surface:
    """A window in the plane z = 0, its middle at the origin: casing, sill, bars, sometimes shutters or a gable."""
    w, h, bar = wide / 2, high / 2, 0.12 * wide
    parts = [
        _box((-w - bar, h, 0), (w + bar, h + bar, 0.03)),
        _box((-w - 1.6 * bar, -h - bar, 0), (w + 1.6 * bar, -h, 0.05)),
    ]
    parts += [
        _box((side * (w + bar / 2) - bar / 2, -h, 0), (side * (w + bar / 2) + bar / 2, h, 0.028)) for side in (-1, 1)
    ]
    parts += [
        _box((x * w - 0.006, -h, 0), (x * w + 0.006, h, 0.012))
        for x in np.linspace(-1, 1, int(style.integers(2, 5)))[1:-1]
    ]
    parts += [
        _box((-w, y * h - 0.006, 0), (w, y * h + 0.006, 0.012))
        for y in np.linspace(-1, 1, int(style.integers(2, 5)))[1:-1]
    ]
    if style.random() < 0.35:
        for side in (-1, 1):
            leaf = [_box((0, -h, 0), (0.9 * w, h, 0.015))]
            leaf += [
                _box((0.1 * w, y * h - 0.012, 0.01), (0.8 * w, y * h + 0.012, 0.024))
                for y in np.linspace(-0.85, 0.85, 8)
            ]
            opened = frame(-0.15 - rng.uniform(0, 0.6))
            shutter = moved(merged(leaf), (w + 1.1 * bar, 0, 0), opened)
            parts.append(shutter if side > 0 else moved(shutter, scale=(-1, 1, 1)))
    return merged(parts)


def _roof(rng: np.random.Generator, half: float, deep: float, rise: float, rows: int) -> Surface:
    """A gabled roof, its ridge along z over the origin, tiled in courses, with gable walls."""
    over = 0.08
    run = half + over
    slope = np.arctan2(rise, half)
    eave = -over * np.tan(slope)
    long = run / np.cos(slope)
    tiles = int(rng.integers(8, 18))
    columns = 4 * tiles + 1
    z = np.linspace(-deep - over, deep + over, columns)
    bulge = 0.012 * np.abs(np.cos(np.pi * np.arange(columns) / 4)) if rng.random() < 0.6 else np.zeros(columns)
    parts = []
    for side in (-1.0, 1.0):
        along = [0.0]
        lift = [0.0]
        for k in range(rows):
            along += [long * (k + 0.02) / rows, long * (k + 1) / rows]
            lift += [0.03, 0.008]
        t, up = np.array(along), np.array(lift)[:, None] + bulge[None, :]
        x = side * (run - t * np.cos(slope))
        y = eave + t * np.sin(slope)
        top = np.stack(
            [x[:, None] + side * np.sin(slope) * up, y[:, None] + np.cos(slope) * up, np.broadcast_to(z, up.shape)], -1
        )
        below = np.stack(
            [
                np.broadcast_to(x[:, None], up.shape),
                np.broadcast_to(y[:, None] - 0.03, up.shape),
                np.broadcast_to(z, up.shape),
            ],
            -1,
        )
        ring = np.concatenate([top, below[::-1]]).transpose(1, 0, 2)
        parts.append(outwards(loft(ring)))
    gable = np.array([(-half, -0.01), (half, -0.01), (0, rise - 0.02)])
    parts.append(moved(extrusion(gable, 2 * deep - 0.01, 0.0), (0, 0, -deep + 0.005)))
    ridge = np.stack([np.zeros(20), np.full(20, rise + 0.02), np.linspace(-deep - over, deep + over, 20)], 1)
    parts.append(tube(ridge, 0.03, 10))
    return merged(parts)


def _house(rng: np.random.Generator) -> list[Surface]:
    parts: list[Surface] = []
    style_seed = int(rng.integers(1 << 30))
    storeys = int(rng.integers(1, 4))
    wings = [(0.0, 0.0, rng.uniform(0.35, 0.55), rng.uniform(0.5, 0.8), storeys)]
    if rng.random() < 0.6:
        wings.append(
            (
                rng.uniform(0.4, 0.7),
                rng.uniform(-0.3, 0.5),
                rng.uniform(0.3, 0.4),
                rng.uniform(0.3, 0.45),
                max(1, storeys - 1),
            )
        )
    for number, (x, z, half, deep, floors) in enumerate(wings):
        high = 0.34 * floors + rng.uniform(0.02, 0.1)
        pieces = [_box((-half, 0, -deep), (half, high, deep), 0.004, 8)]
        pieces.append(_box((-half - 0.02, 0, -deep - 0.02), (half + 0.02, 0.07, deep + 0.02), 0.01, 6))
        for floor in range(floors):
            level = 0.2 + 0.34 * floor
            if floor and rng.random() < 0.7:
                pieces.append(
                    _box(
                        (-half - 0.012, 0.34 * floor, -deep - 0.012),
                        (half + 0.012, 0.34 * floor + 0.025, deep + 0.012),
                        0.006,
                        4,
                    )
                )
            for width, reach, turn in ((half, deep, 0.0), (deep, half, np.pi / 2)):
                count = max(1, int(width / 0.17))
                for k, at in enumerate((np.arange(count) + 0.5) / count * 2 - 1):
                    door = floor == 0 and turn == 0 and number == 0 and k == count // 2
                    if rng.random() < 0.12 and not door:
                        continue
                    piece = (
                        _door(rng)
                        if door
                        else moved(_window(rng, 0.11, 0.17, np.random.default_rng(style_seed)), (0, level, 0))
                    )
                    pieces.append(moved(moved(piece, (at * width, 0, reach)), axes=frame(turn)))
        along = rng.random() < 0.5
        rise = rng.uniform(0.2, 0.5)
        roof = _roof(rng, half if along else deep, deep if along else half, rise, int(rng.integers(5, 10)))
        pieces.append(moved(roof, (0, high, 0), frame(0.0 if along else np.pi / 2)))
        if rng.random() < 0.7:
            cx, cz = rng.uniform(-0.4, 0.4) * half, rng.uniform(-0.5, 0.5) * deep
            pieces.append(_box((cx - 0.05, high, cz - 0.05), (cx + 0.05, high + rise + 0.12, cz + 0.05), 0.006))
            pieces.append(
                _box((cx - 0.065, high + rise + 0.1, cz - 0.065), (cx + 0.065, high + rise + 0.13, cz + 0.065), 0.006)
            )
        parts.append(moved(merged(pieces), (x, 0, z)))
    return parts


def _door(rng: np.random.Generator) -> Surface:
    parts = [_box((-0.075, 0.05, 0), (0.075, 0.28, 0.015)), _box((-0.1, 0.28, 0), (0.1, 0.31, 0.05))]
    parts += [_box((side * 0.088 - 0.014, 0.05, 0), (side * 0.088 + 0.014, 0.28, 0.03)) for side in (-1, 1)]
    parts += [_box((x - 0.025, y, 0.01), (x + 0.025, y + 0.08, 0.022)) for x in (-0.035, 0.035) for y in (0.07, 0.175)]
    steps = int(rng.integers(1, 4))
    parts += [_box((-0.13, 0, 0), (0.13, 0.06 * (k + 1) / steps, 0.06 * (steps - k)), 0.004) for k in range(steps)]
    return merged(parts)


def column(rng: np.random.Generator, high: float, radius: float, sides: int = 48) -> Surface:
    """A column: base, fluted shaft that swells, capital."""
    r = radius
    base = [(0, 0), (1.45 * r, 0), (1.45 * r, 0.3 * r), (1.3 * r, 0.35 * r), (1.35 * r, 0.6 * r), (1.05 * r, 0.7 * r)]
    shaft = [(r * (1.0 - 0.18 * t**1.6), 0.7 * r + t * (high - 1.7 * r)) for t in np.linspace(0, 1, 12)]
    top = [
        (0.95 * r, high - 0.9 * r),
        (0.95 * r, high - 0.8 * r),
        (1.35 * r, high - 0.4 * r),
        (1.4 * r, high - 0.35 * r),
    ]
    outline = rounded_profile([*base, *shaft, *top, (1.4 * r, high), (0, high)], 0.08 * r, 2)
    profile = refined(outline, 0.12 * high)
    shaft_only = (profile[:, 1] > 0.8 * r) & (profile[:, 1] < high - 1.05 * r)
    angle = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    flutes = int(rng.choice([8, 12, 16]))
    depth = 0.09 if rng.random() < 0.75 else 0.0
    hollows = depth * shaft_only[:, None] * np.abs(np.cos(flutes * angle / 2))[None, :]
    return lathe(profile, sides, np.asarray(1.0 - hollows, dtype=float))


def _temple(rng: np.random.Generator) -> list[Surface]:
    across, along = int(rng.integers(4, 7)), int(rng.integers(4, 8))
    gap, radius, high = rng.uniform(0.2, 0.28), rng.uniform(0.04, 0.06), rng.uniform(0.5, 0.85)
    half, deep = gap * (across - 1) / 2, gap * (along - 1) / 2
    parts, steps = [], int(rng.integers(2, 5))
    for k in range(steps):
        out = 0.1 + 0.07 * (steps - k)
        parts.append(_box((-half - out, 0.05 * k, -deep - out), (half + out, 0.05 * (k + 1), deep + out), 0.005, 6))
    floor = 0.05 * steps
    seed = int(rng.integers(1 << 30))
    ruined = rng.random() < 0.35
    for i in range(across):
        for j in range(along):
            if i in (0, across - 1) or j in (0, along - 1):
                share = rng.uniform(0.3, 0.9) if ruined and rng.random() < 0.3 else 1.0
                post = column(np.random.default_rng(seed), high * share, radius, 32)
                parts.append(moved(post, (-half + gap * i, floor, -deep + gap * j)))
    if not ruined:
        top, out = floor + high, 1.6 * radius
        parts.append(_box((-half - out, top, -deep - out), (half + out, top + 0.07, deep + out), 0.004, 8))
        for z, width in ((deep + out, half), (-deep - out, half)):
            for x in np.linspace(-width, width, 2 * across - 1):
                parts.append(_box((x - 0.025, top + 0.075, z - 0.02), (x + 0.025, top + 0.14, z + 0.02), 0.004))
        parts.append(_box((-half - out, top + 0.07, -deep - out), (half + out, top + 0.14, deep + out), 0.004, 8))
        parts.append(
            _box((-half - 2 * out, top + 0.14, -deep - 2 * out), (half + 2 * out, top + 0.17, deep + 2 * out), 0.008, 8)
        )
        roof = _roof(rng, half + 1.5 * out, deep + 1.5 * out, rng.uniform(0.15, 0.3), int(rng.integers(4, 8)))
        parts.append(moved(roof, (0, top + 0.17, 0)))
    parts.append(_box((-half + gap, floor, -deep + gap), (half - gap, floor + 0.9 * high, deep - gap), 0.005, 6))
    return parts


def _castle(rng: np.random.Generator) -> list[Surface]:
    count, parts, corners = int(rng.integers(3, 6)), [], []
    spin = rng.uniform(0, 2)
    for k in range(count):
        bearing = spin + 2 * np.pi * k / count
        corners.append(rng.uniform(0.6, 0.95) * np.array([np.sin(bearing), 0, np.cos(bearing)]))
        radius, high = rng.uniform(0.14, 0.24), rng.uniform(0.6, 1.2)
        outline = [
            (0, 0),
            (1.15 * radius, 0),
            (radius, 0.15),
            (radius, high - 0.08),
            (1.18 * radius, high - 0.02),
            (1.18 * radius, high + 0.05),
            (radius, high + 0.05),
            (radius, high),
            (0, high),
        ]
        pieces = [outwards(lathe(refined(rounded_profile(outline, 0.008), 0.07), 48))]
        merlons = int(rng.integers(7, 12))
        merlon = moved(block((0.16 * radius, 0.035, 0.09 * radius), 0.006, 1, 2), (0, high + 0.08, 1.09 * radius))
        pieces += [moved(merlon, axes=frame(2 * np.pi * j / merlons)) for j in range(merlons)]
        for j in range(int(rng.integers(3, 8))):
            slit = merged(
                [
                    _box((-0.03, -0.06, 0), (0.03, 0.06, 0.015)),
                    _box((-0.008, -0.045, 0.01), (0.008, 0.045, 0.022), 0.002),
                ]
            )
            at = moved(slit, (0, rng.uniform(0.25, 0.85) * high, radius - 0.004))
            pieces.append(moved(at, axes=frame(2.4 * j)))
        if rng.random() < 0.6:
            tip = rng.uniform(0.25, 0.6)
            cone = (
                [(0, 0), (1.05 * radius, 0)]
                + [(1.05 * radius * (1 - t) + s, tip * t) for t in np.linspace(0.02, 0.95, 9) for s in (0.0, 0.012)]
                + [(0, tip)]
            )
            pieces.append(moved(outwards(lathe(np.array(cone), 40)), (0, high + 0.02, 0)))
        parts.append(moved(merged(pieces), corners[-1]))
    for k, (a, b) in enumerate(zip(corners, corners[1:] + corners[:1], strict=True)):
        along = b - a
        long, turn = float(np.linalg.norm(along)), -float(np.arctan2(along[2], along[0]))
        high = rng.uniform(0.38, 0.52)
        pieces = [_box((0, 0, -0.05), (long, high, 0.05), 0.005, 8)]
        for x in np.linspace(0.08, long - 0.08, max(2, int(long / 0.11))):
            pieces.append(_box((x - 0.03, high - 0.01, 0.02), (x + 0.03, high + 0.06, 0.05), 0.005))
            pieces.append(_box((x - 0.03, high - 0.01, -0.05), (x + 0.03, high + 0.06, -0.02), 0.005))
        if k == 0:
            arch = [(0.13 * np.cos(t), 0.16 + 0.13 * np.sin(t)) for t in np.linspace(0, np.pi, 15)]
            gate = extrusion(np.array([(0.13, 0.0), *arch, (-0.13, 0.0)]), 0.16, 0.01)
            pieces.append(moved(gate, (long / 2, 0, -0.08)))
            inner = extrusion(0.72 * np.array([(0.13, 0.0), *arch, (-0.13, 0.0)]), 0.19, 0.006)
            pieces.append(moved(inner, (long / 2, 0, -0.095)))
        parts.append(moved(merged(pieces), a, frame(turn)))
    if rng.random() < 0.6:
        parts += [moved(piece, scale=(0.5, 0.7, 0.5)) for piece in _house(rng)]
    return parts


def building(rng: np.random.Generator) -> Surface:
    """A house, a temple or a castle."""
    make = (_house, _house, _temple, _castle)[int(rng.integers(4))]
    return moved(merged(make(rng)), axes=frame(rng.uniform(-0.7, 0.7)))
