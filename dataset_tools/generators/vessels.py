"""Vessels: vases, jugs, bottles, teapots; and lamps. Turned, fluted, twisted, with handles and relief."""

import numpy as np

from dataset_tools.modelling.anatomy import warped
from dataset_tools.modelling.fields import frame, smooth_curve
from dataset_tools.modelling.patches import lathe, merged, moved, outwards, refined, rounded_profile, tube
from dataset_tools.modelling.sculpting import Surface
from ncmodel.types import Floats


def _silhouette(rng: np.random.Generator) -> Floats:
    """Radius and height of a vessel's outside, from foot to lip: foot, belly, neck, lip."""
    high, belly = rng.uniform(1.0, 2.2), rng.uniform(0.35, 0.75)
    foot, neck = belly * rng.uniform(0.35, 0.8), belly * rng.uniform(0.2, 0.8)
    at = rng.uniform(0.25, 0.6)
    knots = [
        (foot, 0.0),
        (foot * rng.uniform(0.8, 1.0), 0.06 * high),
        (belly, at * high),
        (0.9 * belly, (at + 0.12) * high),
    ]
    knots += [(neck, rng.uniform(0.75, 0.88) * high), (neck * rng.uniform(1.0, 1.7), high)]
    return smooth_curve(np.array(knots), 8)


def _carving(rng: np.random.Generator, profile: Floats, sides: int) -> Floats:
    """Factors of the radius: flutes, facets, a twisted rope, a relief of leaves or beads, or nothing."""
    angle = np.linspace(0, 2 * np.pi, sides, endpoint=False)[None, :]
    height = profile[:, 1:] / np.ptp(profile[:, 1])
    count, twist, depth = int(rng.integers(5, 17)), rng.uniform(-4, 4), rng.uniform(0.015, 0.07)
    low, high = np.sort(rng.uniform(0.1, 0.9, 2))
    band = np.clip((height - low) / 0.05, 0, 1) * np.clip((high + 0.08 - height) / 0.05, 0, 1)
    wave = np.cos(count * angle + twist * height)
    patterns = [
        np.zeros_like(wave),
        np.abs(wave),
        -np.abs(np.cos((count * angle + twist * height) / 2)),
        np.clip(3 * wave, -0.5, 0.5),
        np.maximum(wave * np.cos(count * np.pi * height * rng.uniform(0.6, 1.5)), 0) ** 0.7,
        np.where((np.floor(12 * height) % 2) == 0, wave, -wave),
    ]
    return np.asarray(1.0 + depth * band * patterns[int(rng.integers(len(patterns)))])


def _handle(rng: np.random.Generator, top: Floats, bottom: Floats, bow: float, width: float, flat: float) -> Surface:
    """A handle between two points of radius and height, towards +x."""
    reach = max(top[0], bottom[0]) + bow
    knots = np.array(
        [
            (top[0] - 0.03, top[1], 0),
            (0.5 * (top[0] + reach), top[1] + rng.uniform(0, 0.15), 0),
            (reach, (top[1] + bottom[1]) / 2 + 0.1, 0),
            (bottom[0] + 0.4 * bow, bottom[1] - 0.02, 0),
            (bottom[0] - 0.04, bottom[1], 0),
        ]
    )
    angle = np.linspace(0, 2 * np.pi, 14, endpoint=False)
    section = np.stack([np.cos(angle), flat * np.sin(angle)], axis=1)
    path = smooth_curve(knots, 8)
    return tube(path, width * np.interp(np.linspace(0, 1, len(path)), [0, 0.5, 1], [1.2, 0.9, 1.1]), section=section)


def vase(rng: np.random.Generator) -> Surface:
    """A vase, amphora, jug, teapot or bowl, with handles, spout, lid, rings and carved patterns."""
    outside = _silhouette(rng)
    wall, sides = rng.uniform(0.025, 0.05), int(rng.integers(16, 33)) * 4
    fine = refined(outside, rng.uniform(0.02, 0.04))
    for _ in range(int(rng.integers(0, 4))):
        place, size = rng.uniform(0.05, 0.97) * fine[-1, 1], rng.uniform(0.015, 0.035)
        fine = fine + np.stack(
            [rng.choice([-0.8, 1.0]) * size * np.exp(-(((fine[:, 1] - place) / size) ** 2)), np.zeros(len(fine))], 1
        )
    flutes = _carving(rng, fine, sides)
    lip = np.array(
        [
            [fine[-1, 0] + 0.5 * wall, fine[-1, 1] + 0.3 * wall],
            [fine[-1, 0] + 0.3 * wall, fine[-1, 1] + wall],
            [fine[-1, 0] - 0.6 * wall, fine[-1, 1] + 0.9 * wall],
        ]
    )
    inside = fine[::-3] - [wall, 0.0]
    inside = inside[inside[:, 1] > 0.12 * fine[-1, 1]]
    inside[:, 0] = np.maximum(inside[:, 0], 0.05)
    profile = np.concatenate([fine, lip, inside])
    factors = np.concatenate([flutes, np.ones((len(lip) + len(inside), sides))])
    parts = [outwards(lathe(profile, sides, factors))]
    handles, top = int(rng.integers(0, 3)), rng.uniform(0.78, 0.98)
    low = rng.uniform(0.35, 0.6)

    def at(share: float) -> Floats:
        height = share * fine[-1, 1]
        return np.array([np.interp(height, fine[:, 1], fine[:, 0]), height])

    bow, width, flat = rng.uniform(0.1, 0.35), rng.uniform(0.03, 0.06), rng.uniform(0.7, 1.8)
    for k in range(handles):
        parts.append(moved(_handle(rng, at(top), at(low), bow, width, flat), axes=frame(np.pi * k)))
    if rng.random() < 0.3:
        start, end = at(rng.uniform(0.3, 0.5)), at(1.0) + [rng.uniform(0.15, 0.35), 0.05]
        knots = np.array(
            [
                (-start[0] + 0.05, start[1], 0),
                (-start[0] - 0.18, start[1] + 0.1, 0),
                (-end[0] + 0.05, end[1] - 0.15, 0),
                (-end[0] - 0.1, end[1], 0),
            ]
        )
        path = smooth_curve(knots, 9)
        parts.append(tube(path, np.linspace(0.13, 0.06, len(path)), 20))
    if rng.random() < 0.3:
        r = fine[-1, 0]
        corners = [
            (0, 0),
            (r, 0),
            (1.02 * r, 0.04),
            (0.7 * r, 0.14),
            (0.12, 0.2),
            (0.08, 0.24),
            (0.13, 0.3),
            (0.1, 0.37),
            (0, 0.39),
        ]
        parts.append(moved(lathe(refined(rounded_profile(corners, 0.03), 0.03), 48), (0, fine[-1, 1] + wall, 0)))
    spun = moved(merged(parts), axes=frame(rng.uniform(-1.5, 1.5)))
    return warped(spun, rng, rng.uniform(0.0, 0.025))


def bottle(rng: np.random.Generator) -> Surface:
    """Bottles and jars, one to four that stand together: round, square or oval, with caps, labels, grooves."""
    parts, x = [], 0.0
    for _ in range(int(rng.integers(1, 5))):
        radius, high = rng.uniform(0.18, 0.32), rng.uniform(0.5, 1.1)
        neck, cap = radius * rng.uniform(0.3, 0.75), rng.uniform(0.08, 0.2)
        shoulder = high * rng.uniform(0.7, 0.9)
        corners = [
            (0, 0.02),
            (0.8 * radius, 0.0),
            (radius, 0.03),
            (radius, 0.2 * high),
            (0.97 * radius, 0.22 * high),
            (0.97 * radius, shoulder - 0.1),
            (radius, shoulder - 0.08),
            (radius, shoulder),
        ]
        corners += [
            (neck, high),
            (neck, high + 0.05),
            (1.15 * neck, high + 0.05),
            (1.15 * neck, high + 0.08),
            (0.9 * neck, high + 0.08),
            (0, high + 0.08),
        ]
        rounding = [
            0,
            0.02,
            0.05,
            0.005,
            0.005,
            0.005,
            0.005,
            rng.uniform(0.04, 0.2),
            rng.uniform(0.02, 0.1),
            0.004,
            0.006,
            0.006,
            0,
            0,
        ]
        profile = refined(rounded_profile(corners, rounding), 0.035)
        sides = 64
        angle = np.linspace(0, 2 * np.pi, sides, endpoint=False)
        power = rng.choice([2.0, 2.0, 5.0, 9.0])
        square = (np.abs(np.cos(angle)) ** power + np.abs(np.sin(angle)) ** power) ** (-1 / power)
        body = np.clip((shoulder + 0.05 - profile[:, 1]) / 0.1, 0, 1)[:, None]
        factors = 1 + body * (square[None, :] - 1)
        bottle_ = lathe(profile, sides, factors)
        knurls = np.where(np.arange(sides) % 2 == 0, 1.0, 0.95)
        lid = [(0, 0), (1.25 * neck, 0), (1.25 * neck, cap), (1.05 * neck, cap + 0.01), (0, cap + 0.01)]
        fine = refined(rounded_profile(lid, 0.012, 2), 0.03)
        rim = (fine[:, 0] > 1.2 * neck)[:, None]
        top = moved(lathe(fine, sides, np.where(rim, knurls[None, :], 1.0)), (0, high + 0.085, 0))
        place = frame(rng.uniform(-1, 1))
        where = (x + 0.8 * radius, 0.0, rng.uniform(-0.3, 0.3))
        pieces = [bottle_] if rng.random() < 0.25 else [bottle_, top]
        parts.append(moved(merged(pieces), where, place, (1, 1, rng.uniform(0.65, 1.0))))
        x += 2.1 * radius * 1.15
    return merged(parts)


def lamp(rng: np.random.Generator) -> Surface:
    """A lamp: standing with a shade, jointed on a desk, a lantern, or a candlestick with arms."""
    kind = int(rng.integers(3))
    sides = 64
    base = rng.uniform(0.22, 0.38)
    corners = [(0, 0), (base, 0), (base, 0.04), (0.8 * base, 0.07), (0.25 * base, 0.12), (0.04, 0.2)]
    if kind == 1:
        return _desk_lamp(rng, corners, sides)
    high = rng.uniform(0.9, 1.5)
    heights = np.linspace(0.2, high, int(rng.integers(5, 9)))
    turned_stem = [(rng.uniform(0.03, 0.14), float(y)) for y in heights[1:-1]]
    stem = smooth_curve(np.array([(0.04, 0.2), *turned_stem, (0.035, high)]), 7)
    profile = np.concatenate([refined(rounded_profile(corners, 0.02), 0.03)[:-1], refined(stem, 0.03), [[0, high]]])
    flutes = np.ones((len(profile), sides))
    if rng.random() < 0.5:
        band = (profile[:, 1] > 0.35) & (profile[:, 1] < 0.75 * high)
        flutes[band] += 0.06 * np.cos(int(rng.integers(6, 13)) * np.linspace(0, 2 * np.pi, sides, endpoint=False))
    parts = [lathe(profile, sides, flutes)]
    if kind == 0:
        wide, narrow, tall = rng.uniform(0.35, 0.6), rng.uniform(0.12, 0.4), rng.uniform(0.35, 0.6)
        bow = rng.uniform(-0.08, 0.08)
        outside = smooth_curve(np.array([(wide, 0), (0.5 * (wide + narrow) + bow, 0.5 * tall), (narrow, tall)]), 9)
        shade = np.concatenate([outside, (outside - [0.02, 0])[::-1], outside[:1]])
        pleats, depth = int(rng.integers(10, 30)), rng.uniform(0.0, 0.05)
        folds = 1 + depth * np.cos(pleats * np.linspace(0, 2 * np.pi, 4 * pleats, endpoint=False))
        tilt = frame(0, 0, rng.uniform(-0.12, 0.12))
        shell = lathe(shade, 4 * pleats, np.broadcast_to(folds, (len(shade), 4 * pleats)))
        parts.append(moved(shell, (0, high - 0.3 * tall, 0), tilt))
        bulb = smooth_curve(
            np.array([(0.0, 0), (0.04, 0.01), (0.05, 0.08), (0.09, 0.17), (0.05, 0.24), (0.0, 0.26)]), 5
        )
        parts.append(moved(lathe(bulb, 24), (0, high, 0)))
    else:
        arms, reach = int(rng.integers(2, 6)), rng.uniform(0.3, 0.55)
        cup = rounded_profile(
            [
                (0, -0.02),
                (0.04, -0.02),
                (0.1, 0.04),
                (0.1, 0.06),
                (0.05, 0.05),
                (0.05, rng.uniform(0.2, 0.45)),
                (0, 0.4),
            ],
            0.012,
        )
        for k in range(arms):
            axes = frame(2 * np.pi * k / arms)
            path = smooth_curve(
                np.array(
                    [
                        (0.03, 0.75 * high, 0),
                        (0.4 * reach, 0.6 * high, 0),
                        (reach, 0.7 * high, 0),
                        (reach, 0.9 * high, 0),
                    ]
                ),
                8,
            )
            parts.append(moved(tube(path, np.linspace(0.035, 0.022, len(path)), 12), axes=axes))
            parts.append(moved(moved(lathe(refined(cup, 0.03), 24), (reach, 0.9 * high, 0)), axes=axes))
        parts.append(moved(lathe(refined(cup, 0.03), 24), (0, high, 0)))
    return warped(moved(merged(parts), axes=frame(rng.uniform(-1, 1))), rng, 0.012)


def _desk_lamp(rng: np.random.Generator, base: list[tuple[float, float]], sides: int) -> Surface:
    parts = [lathe(refined(rounded_profile([*base, (0.04, 0.25), (0, 0.25)], 0.015), 0.03), sides)]
    at, lean = np.array([0.0, 0.22, 0.0]), rng.uniform(0.15, 0.5)
    for k in range(2):
        sign = -1.0 if k == 0 else 1.0
        end = at + rng.uniform(0.45, 0.65) * np.array([sign * np.sin(lean), np.cos(lean), rng.uniform(-0.1, 0.1)])
        for z in (-0.03, 0.03):
            parts.append(tube(np.linspace(at + [0, 0, z], end + [0, 0, z], 12), 0.014, 12))
        turns = 16 * int(rng.integers(5, 9))
        t = np.linspace(0, 1, turns)
        coil = at + (0.1 + 0.3 * t)[:, None] * (end - at)
        coil = coil + 0.028 * np.stack(
            [np.cos(2 * np.pi * turns / 16 * t), np.zeros(turns), np.sin(2 * np.pi * turns / 16 * t)], 1
        )
        parts.append(tube(coil, 0.007, 6))
        joint = lathe(rounded_profile([(0, -0.06), (0.05, -0.06), (0.05, 0.06), (0, 0.06)], 0.012), 24)
        parts.append(moved(joint, end, np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])))
        at, lean = end, rng.uniform(0.7, 1.3)
    outline = [
        (0, 0.0),
        (0.07, 0.0),
        (0.08, -0.12),
        (0.13, -0.16),
        (rng.uniform(0.2, 0.3), -0.4),
        (0.19, -0.4),
        (0.11, -0.17),
        (0, -0.14),
    ]
    shade = lathe(refined(rounded_profile(outline, 0.025), 0.03), sides)
    parts.append(moved(shade, at, frame(rng.uniform(-0.4, 0.4), 0, rng.uniform(0.1, 0.9))))
    return moved(merged([parts[0], *(outwards(p) for p in parts[1:])]), axes=frame(rng.uniform(-1, 1)))
