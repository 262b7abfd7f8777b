"""Plants: in pots, flowers, trees; stems and leaves are sheets and tubes."""

import numpy as np

from dataset_tools.modelling.anatomy import warped
from dataset_tools.modelling.fields import frame, smooth_curve
from dataset_tools.modelling.patches import lathe, merged, moved, outwards, refined, rounded_profile, sheet, tube
from dataset_tools.modelling.sculpting import Surface
from ncmodel.types import Floats


def leaf(
    rng: np.random.Generator, long: float, wide: float, droop: float, lobes: int = 0, rows: int = 16, columns: int = 9
) -> Surface:
    """A leaf along z from the origin: pointed or lobed, folded at its midrib, veined, drooping, curled."""
    t, s = np.meshgrid(np.linspace(0, 1, rows), np.linspace(-1, 1, columns), indexing="ij")
    fullness, place = rng.uniform(0.6, 1.3), rng.uniform(0.6, 1.2)
    width = wide * np.sin(np.pi * np.clip(t, 0.01, 0.99) ** place) ** fullness
    if lobes:
        width = width * (0.72 + 0.28 * np.abs(np.sin(np.pi * lobes * t)))
    fold, curl, veins = rng.uniform(0.05, 0.5), rng.uniform(-0.3, 0.3), int(rng.integers(4, 8))
    rise = fold * np.abs(s) * width + 0.02 * wide * np.cos(2 * np.pi * (veins * t - 1.5 * np.abs(s)))
    bend = droop * t
    z = long * np.where(abs(droop) > 1e-3, np.sin(bend) / np.where(np.abs(bend) > 1e-6, droop, 1.0), t)
    y = -long * (1 - np.cos(bend)) / (droop if abs(droop) > 1e-3 else 1.0)
    points = np.stack([s * width + curl * wide * t**2, y + rise, z], axis=-1)
    return sheet(points, rng.uniform(0.012, 0.03) * wide + 0.002)


def pot(rng: np.random.Generator, radius: float, high: float) -> Surface:
    """A flower pot with a rim, a saucer sometimes, filled with earth."""
    foot, rim = radius * rng.uniform(0.55, 0.85), rng.uniform(0.06, 0.2) * high
    corners = [(0, 0), (foot, 0), (0.96 * radius, high - rim), (1.1 * radius, high - rim), (1.12 * radius, high)]
    corners += [(0.95 * radius, high), (0.9 * radius, 0.9 * high), (0, 0.93 * high)]
    profile = refined(rounded_profile(corners, 0.02, 2), 0.05 * high + 0.01)
    sides, kind = 48, int(rng.integers(4))
    angle = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    band = ((profile[:, 1] > 0.1 * high) & (profile[:, 1] < high - rim - 0.02) & (profile[:, 0] > 0.7 * foot))[:, None]
    pattern = (
        np.zeros(sides),
        0.04 * np.cos(12 * angle),
        0.05 * (np.cos(8 * angle) > 0.3),
        -0.03 * (np.cos(16 * angle) > 0.5),
    )[kind]
    parts = [lathe(profile, sides, np.asarray(1.0 + band * pattern[None, :], dtype=float))]
    if rng.random() < 0.4:
        saucer = [
            (0, -0.04),
            (1.2 * foot, -0.04),
            (1.35 * foot, 0.04),
            (1.28 * foot, 0.04),
            (1.15 * foot, -0.01),
            (0, -0.01),
        ]
        parts.append(lathe(refined(rounded_profile(saucer, 0.01), 0.05), sides))
    return merged(parts)


def plant(rng: np.random.Generator) -> Surface:
    """A plant in a pot: a rosette of blades, leaves along stems, or a cactus."""
    radius, high = rng.uniform(0.22, 0.38), rng.uniform(0.35, 0.6)
    parts = [pot(rng, radius, high)]
    kind = int(rng.integers(3))
    if kind == 0:
        for k in range(int(rng.integers(8, 20))):
            yaw, lean = k * 2.4 + rng.uniform(-0.2, 0.2), rng.uniform(0.4, 1.4)
            blade = leaf(rng, rng.uniform(0.6, 1.2), rng.uniform(0.05, 0.13), rng.uniform(0.3, 2.0), rows=24, columns=7)
            axes = frame(0, -lean) @ frame(yaw)
            parts.append(moved(blade, (0, 0.9 * high, 0), axes))
    elif kind == 1:
        lobes = int(rng.choice([0, 0, 3, 4]))
        for _ in range(int(rng.integers(2, 6))):
            yaw, reach = rng.uniform(0, 6.3), rng.uniform(0.1, 0.5)
            top = np.array([reach * np.sin(yaw), high + rng.uniform(0.5, 1.2), reach * np.cos(yaw)])
            start = np.array([rng.uniform(-0.1, 0.1), 0.9 * high, rng.uniform(-0.1, 0.1)])
            path = smooth_curve(np.stack([start, start + [0, 0.4 * (top[1] - start[1]), 0], top]), 10)
            parts.append(tube(path, np.linspace(0.025, 0.01, len(path)), 10))
            for k in range(4, len(path), int(rng.integers(2, 4))):
                parts += _leaf_on_stalk(rng, path[k], 2.4 * k + yaw, rng.uniform(0.2, 0.4), lobes)
    else:
        parts += _cactus(rng, high)
    return warped(merged(parts), rng, 0.01)


def _leaf_on_stalk(rng: np.random.Generator, at: Floats, yaw: float, size: float, lobes: int) -> list[Surface]:
    axes = frame(0, rng.uniform(-0.7, 0.1)) @ frame(yaw)
    stalk = np.linspace(0, 0.35 * size, 5)[:, None] * axes[2] + at
    blade = leaf(rng, size, size * rng.uniform(0.28, 0.45), rng.uniform(0.2, 1.3), lobes)
    return [tube(stalk, 0.008, 6), moved(blade, stalk[-1] - 0.01 * axes[2], axes)]


def _cactus(rng: np.random.Generator, base: float) -> list[Surface]:
    parts = []
    ribs, sides = int(rng.integers(8, 15)), 0
    sides = 6 * ribs
    angle = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    ribbed = 1 - 0.16 * np.abs(np.sin(ribs * angle / 2 + 0.0)) ** 0.7
    section = np.stack([np.cos(angle), np.sin(angle)], axis=1) * (2 * ribbed - 1)[:, None]
    high, thick = rng.uniform(0.6, 1.2), rng.uniform(0.14, 0.22)
    dome = np.sqrt(np.clip(1 - np.linspace(0, 1, 8) ** 2, 0.003, 1))
    trunk = np.array([(0.02 * np.sin(3 * y), base - 0.05 + y, 0.02 * np.cos(2 * y)) for y in np.linspace(0, high, 24)])
    size = np.concatenate([np.linspace(0.8, 1, 6), np.ones(10), dome]) * thick
    parts.append(outwards(tube(trunk, size, section=section)))
    for _ in range(int(rng.integers(0, 4))):
        yaw, start, rise = rng.uniform(0, 6.3), rng.uniform(0.3, 0.6) * high, rng.uniform(0.25, 0.5)
        out = rng.uniform(0.25, 0.4)
        knots = np.array([(0, start, 0), (0.8 * out, start, 0), (out, start + 0.15, 0), (out, start + 0.15 + rise, 0)])
        path = np.stack([smooth_curve(knots, 8)[:, 0], smooth_curve(knots, 8)[:, 1] + base, np.zeros(25)], 1)
        arm = np.concatenate([np.ones(17), dome]) * 0.55 * thick
        parts.append(moved(outwards(tube(path, arm, section=section)), axes=frame(yaw)))
    return parts


def flower(rng: np.random.Generator) -> Surface:
    """A bunch of flowers on stems: petals in whorls about a head, leaves, sometimes in a pot."""
    parts = []
    potted = rng.random() < 0.5
    base = 0.0
    if potted:
        base = rng.uniform(0.3, 0.5)
        parts.append(pot(rng, rng.uniform(0.18, 0.3), base))
    for _ in range(int(rng.integers(1, 6))):
        yaw, reach, high = rng.uniform(0, 6.3), rng.uniform(0.0, 0.45), rng.uniform(0.7, 1.3)
        knots = np.array([(0, 0.85 * base, 0), (0.2 * reach, base + 0.5 * high, 0), (reach, base + high, 0)]) @ frame(
            yaw
        )
        path = smooth_curve(knots, 10)
        parts.append(tube(path, np.linspace(0.022, 0.016, len(path)), 10))
        for k in (5, 9, 13)[: int(rng.integers(1, 4))]:
            parts += _leaf_on_stalk(rng, path[k], yaw + 2.4 * k, rng.uniform(0.2, 0.35), 0)
        tilt = frame(0, rng.uniform(0.2, 1.3)) @ frame(rng.uniform(-0.8, 0.8))
        parts += [moved(piece, path[-1], tilt) for piece in _bloom(rng)]
    return warped(merged(parts), rng, 0.01)


def _bloom(rng: np.random.Generator) -> list[Surface]:
    """A flower's head, opening along y."""
    heart = rng.uniform(0.04, 0.1)
    dome = smooth_curve(
        np.array([(0.3 * heart, -0.06), (heart, 0.0), (0.8 * heart, 0.6 * heart), (0.0, 0.8 * heart)]), 5
    )
    angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    parts = [lathe(dome, 40, 1 + 0.06 * np.cos(10 * angle)[None, :] * np.ones((len(dome), 1)))]
    petals, long, wide = int(rng.integers(5, 13)), rng.uniform(0.14, 0.3), rng.uniform(0.25, 0.5)
    for whorl in range(int(rng.integers(1, 4))):
        for k in range(petals):
            axes = frame(0, -rng.uniform(0.1, 0.35) - 0.35 * whorl) @ frame(2 * np.pi * (k + 0.5 * whorl) / petals)
            petal = leaf(
                rng,
                long * (1 - 0.18 * whorl),
                wide * long * min(1.0, 8 / petals),
                rng.uniform(-0.5, 0.6),
                rows=12,
                columns=7,
            )
            parts.append(moved(petal, 0.6 * heart * axes[2], axes))
    return parts


def tree(rng: np.random.Generator) -> Surface:
    """A tree: a gnarled trunk with roots, branches that fork, leaves or bare, or a fir's tiers."""
    parts: list[Surface] = []
    if rng.random() < 0.3:
        high, tiers = rng.uniform(1.2, 1.8), int(rng.integers(3, 7))
        parts.append(tube(np.linspace((0, 0, 0), (0.03, high, 0), 10), np.linspace(0.1, 0.03, 10), 14))
        points = int(rng.integers(7, 13))
        angle = np.linspace(0, 2 * np.pi, 6 * points, endpoint=False)
        jag = 1 + 0.12 * np.cos(points * angle)
        for k in range(tiers):
            y, r = 0.3 + (high - 0.35) * k / tiers, 0.55 * (1 - k / (tiers + 0.6))
            lift = 1.6 * (high - 0.3) / tiers
            outline = [
                (0.1 * r, 0.06),
                (0.6 * r, 0.02),
                (r, -0.05),
                (0.95 * r, 0.0),
                (0.5 * r, 0.45 * lift),
                (0.02, lift),
            ]
            skirt = refined(rounded_profile(outline, 0.03), 0.06)
            tier = lathe(skirt, len(angle), np.broadcast_to(jag, (len(skirt), len(angle))))
            parts.append(moved(tier, (0.03 * k / tiers, y, 0), frame(rng.uniform(0, 6.3), rng.uniform(-0.08, 0.08))))
        return warped(merged(parts), rng, 0.02)
    leafy, size = rng.random() < 0.7, rng.uniform(0.09, 0.16)

    def grow(at: Floats, direction: Floats, long: float, thick: float, depth: int) -> None:
        bend = direction + rng.normal(0, 0.25, 3) + [0, 0.15, 0]
        end = at + long * bend / np.linalg.norm(bend)
        path = smooth_curve(np.stack([at - 0.02 * direction, at + 0.5 * long * direction, end]), 5)
        parts.append(tube(path, np.linspace(thick, 0.68 * thick, len(path)), 12 if depth > 1 else 7))
        if depth == 0:
            for _ in range(int(rng.integers(3, 6)) if leafy else 0):
                axes = frame(rng.uniform(0, 6.3), rng.uniform(-0.8, 0.6))
                foliage = leaf(rng, size * rng.uniform(0.8, 1.4), 0.35 * size, rng.uniform(0, 1), rows=7, columns=5)
                parts.append(moved(foliage, path[int(rng.integers(4, len(path)))], axes))
            return
        spin = rng.uniform(0, 6.3)
        for k in range(int(rng.integers(2, 4))):
            yaw = spin + 2.1 * k
            side = np.array([np.sin(yaw), rng.uniform(0.2, 0.9), np.cos(yaw)])
            grow(end, side / np.linalg.norm(side), long * rng.uniform(0.6, 0.8), 0.66 * thick, depth - 1)

    grow(np.zeros(3), np.array([0.0, 1.0, 0.0]), rng.uniform(0.5, 0.8), rng.uniform(0.09, 0.14), 4)
    for k in range(int(rng.integers(3, 6))):
        axes = frame(1.3 * k + rng.uniform(-0.2, 0.2))
        root = smooth_curve(np.array([(0, 0.25, 0.02), (0, 0.05, 0.14), (0.05, -0.04, 0.34)]), 5)
        parts.append(moved(tube(root, np.linspace(0.07, 0.02, len(root)), 10), axes=axes))
    return merged(parts)
