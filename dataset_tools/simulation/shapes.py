"""Shapes made in code, for the demo and for tests: organic and mechanical, every one different, the same for a seed.

Organic shapes are smooth blends of capsules and spheres (legged creatures, blobs, figures); mechanical ones are lathes,
extrusions and solids with parts cut away, their edges rounded.
"""

import math
import zlib
from collections.abc import Callable

import numpy as np

from dataset_tools.simulation.signed_distances import (
    box,
    capsule,
    cylinder,
    grid_faces,
    icosphere,
    level_set,
    loft,
    outward_facing,
    smooth_cut,
    smooth_min,
)
from ncmodel.mesh.load import make_mesh
from ncmodel.types import Floats, Ints, Mesh

Parts = list[tuple[Floats, Floats, float, float]]
"""Tapered capsules: end a, end b, radius at a, radius at b."""


def make_shape(kind: str, number: int, seed: int = 0) -> Mesh:
    """One shape of a kind.

    Args:
        kind: A key of `KINDS`.
        number: Which one of its kind; every number is another shape.
        seed: Another seed, another collection.

    Returns:
        A closed mesh, named "KIND_NUMBER", in the units it was made in.
    """
    rng = np.random.default_rng([seed, number, zlib.crc32(kind.encode())])
    vertices, faces = KINDS[kind](rng)
    return Mesh(np.ascontiguousarray(vertices), np.ascontiguousarray(faces, dtype=np.int64), f"{kind}_{number}")


def make_shapes(count: int, seed: int = 0) -> list[Mesh]:
    """The first `count` shapes, going round the kinds."""
    names = (name.rsplit("_", 1) for name in shape_names(count))
    return [make_shape(kind, int(number), seed) for kind, number in names]


def shape_names(count: int) -> list[str]:
    """The names of the first `count` shapes."""
    kinds = list(KINDS)
    return [f"{kinds[i % len(kinds)]}_{i // len(kinds)}" for i in range(count)]


def _blend(parts: Parts, radius: float) -> tuple[Floats, Ints]:
    """A smooth union of tapered capsules."""

    def distance(points: Floats) -> Floats:
        value = capsule(points, *parts[0])
        for part in parts[1:]:
            value = smooth_min(value, capsule(points, *part), radius)
        return value

    ends = np.array([end for a, b, _, _ in parts for end in (a, b)])
    margin = 1.15 * max(max(part[2:]) for part in parts) + 0.05
    return level_set(distance, ends.min(axis=0) - margin, ends.max(axis=0) + margin)


# Organic kinds


def creature(rng: np.random.Generator) -> tuple[Floats, Ints]:
    """A four-legged animal: body, neck, head, ears, legs, tail."""
    length, girth = rng.uniform(0.9, 1.4), rng.uniform(0.2, 0.34)
    height, leg = rng.uniform(0.45, 0.8), rng.uniform(0.06, 0.11)
    front, back = np.array([length / 2, height, 0.0]), np.array([-length / 2, height * rng.uniform(0.9, 1.05), 0.0])
    head = front + [rng.uniform(0.2, 0.4), rng.uniform(0.15, 0.5), 0.0]
    snout = head + [rng.uniform(0.16, 0.3), rng.uniform(-0.15, 0.0), 0.0]
    skull = rng.uniform(0.14, 0.2)
    parts = [(back, front, girth, girth * rng.uniform(0.85, 1.1)), (front, head, 0.6 * girth, 0.7 * skull)]
    parts += [(head, snout, skull, 0.55 * skull)]
    for side in (-1.0, 1.0):
        for end, bend in ((front, 0.06), (back, -0.08)):
            hip = end + [0.0, -0.3 * girth, 0.65 * girth * side]
            knee = np.array([hip[0] + bend, 0.5 * hip[1], hip[2]])
            parts += [(hip, knee, 1.6 * leg, leg), (knee, np.array([hip[0], 0.02, hip[2]]), leg, 1.1 * leg)]
        ear = head + [-0.06, 0.7 * skull, 0.6 * skull * side]
        parts += [(ear, ear + [-0.03, rng.uniform(0.08, 0.22), 0.06 * side], 0.05, 0.04)]
    tail = back + [-rng.uniform(0.2, 0.5), rng.uniform(-0.2, 0.35), 0.0]
    parts += [(back + [-0.5 * girth, 0.3 * girth, 0.0], tail, 0.07, 0.04)]
    return _blend(parts, 0.13)


def blob(rng: np.random.Generator) -> tuple[Floats, Ints]:
    """Balls melted together."""
    parts: Parts = []
    for _ in range(int(rng.integers(4, 8))):
        a = rng.normal(0.0, 0.38, 3)
        radius = float(rng.uniform(0.2, 0.42))
        parts.append((a, a + rng.normal(0.0, 0.2, 3), radius, radius * float(rng.uniform(0.6, 1.0))))
    # Every ball reaches the middle, so that the shape is one piece.
    parts += [(np.zeros(3), part[0], 0.16, 0.16) for part in parts]
    return _blend(parts, 0.2)


def figure(rng: np.random.Generator) -> tuple[Floats, Ints]:
    """A standing figure: trunk, head, arms, legs."""
    waist, chest = np.array([0.0, 0.95, 0.0]), np.array([0.0, 1.35 + rng.uniform(-0.05, 0.1), 0.0])
    trunk = rng.uniform(0.15, 0.24)
    head = chest + [0.0, rng.uniform(0.36, 0.46), 0.03]
    skull = rng.uniform(0.13, 0.19)
    parts = [(waist, chest, trunk, trunk * rng.uniform(0.95, 1.25)), (chest, head, 0.09, 0.09)]
    parts += [(head, head + [0.0, 0.06, 0.02], skull, skull)]
    spread, stance = rng.uniform(0.1, 0.75), rng.uniform(0.1, 0.25)
    for side in (-1.0, 1.0):
        shoulder = chest + [side * (trunk + 0.03), 0.02, 0.0]
        elbow = shoulder + [side * 0.36 * math.sin(spread + 0.3), -0.36 * math.cos(spread + 0.3), 0.0]
        hand = elbow + [side * 0.3 * math.sin(spread), -0.3 * math.cos(spread), rng.uniform(0.0, 0.25)]
        hip = waist + [side * 0.55 * trunk, -0.08, 0.0]
        knee, foot = np.array([side * stance, 0.5, 0.04]), np.array([side * (stance + 0.03), 0.06, 0.0])
        parts += [(shoulder, elbow, 0.085, 0.065), (elbow, hand, 0.065, 0.06)]
        parts += [(hip, knee, 0.12, 0.085), (knee, foot, 0.085, 0.06), (foot, foot + [0.0, -0.01, 0.14], 0.06, 0.05)]
    return _blend(parts, 0.09)


def superquadric(rng: np.random.Generator) -> tuple[Floats, Ints]:
    """A superellipsoid with waves across it, from rounded box to star."""
    directions, faces = icosphere(5)
    e1, e2 = rng.uniform(0.45, 1.5, 2)
    scale = rng.uniform(0.5, 1.0, 3)
    x, y, z = np.abs(directions / scale).T
    ring = (x ** (2 / e2) + z ** (2 / e2)) ** (e2 / e1)
    radius = (ring + y ** (2 / e1)) ** (-e1 / 2)
    waves = int(rng.integers(2, 6))
    phase = np.arctan2(directions[:, 2], directions[:, 0])
    radius = radius * (1 + rng.uniform(0.03, 0.12) * np.cos(waves * phase) * (1 - directions[:, 1] ** 2))
    return directions * radius[:, None], faces


def knot(rng: np.random.Generator) -> tuple[Floats, Ints]:
    """A tube, of varying thickness, along a torus knot."""
    p, q = [(2, 3), (3, 2), (1, 2), (2, 5), (1, 3)][int(rng.integers(5))]
    rings, sides = 220, 28
    s = np.linspace(0.0, 2 * math.pi, rings, endpoint=False)
    radius = 1.0 + 0.42 * np.cos(q * s)
    centre = np.stack([radius * np.cos(p * s), 0.45 * np.sin(q * s), radius * np.sin(p * s)], axis=1)
    tangent = np.roll(centre, -1, axis=0) - np.roll(centre, 1, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    outward = np.stack([np.cos(p * s), np.zeros(rings), np.sin(p * s)], axis=1)
    normal = outward - (outward * tangent).sum(1, keepdims=True) * tangent
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    binormal = np.cross(tangent, normal)
    thickness = rng.uniform(0.13, 0.2) * (1 + rng.uniform(0.0, 0.25) * np.cos(int(rng.integers(2, 7)) * s))
    angle = np.linspace(0.0, 2 * math.pi, sides, endpoint=False)
    circle = np.cos(angle)[None, :, None] * normal[:, None] + np.sin(angle)[None, :, None] * binormal[:, None]
    vertices = centre[:, None] + thickness[:, None, None] * circle
    return outward_facing(vertices.reshape(-1, 3), grid_faces(rings, sides, closed=True))


# Mechanical kinds


def lathe(rng: np.random.Generator) -> tuple[Floats, Ints]:
    """A turned part: a vase, a goblet, a knob, a bottle, with grooves and beads."""
    from scipy.interpolate import PchipInterpolator

    knots = int(rng.integers(5, 9))
    heights = np.linspace(0.0, rng.uniform(1.2, 2.2), knots)
    radii = rng.uniform(0.18, 0.7, knots)
    s = np.linspace(0.0, heights[-1], 90)
    radius = np.asarray(PchipInterpolator(heights, radii)(s))
    for _ in range(int(rng.integers(1, 4))):
        place, depth = rng.uniform(0.15, 0.85) * heights[-1], rng.choice([-1.0, 1.0]) * rng.uniform(0.03, 0.07)
        radius = radius + depth * np.exp(-(((s - place) / 0.035) ** 2))
    return loft(np.stack([np.ones(64), np.zeros(64)], axis=1), s, radius)


def gear(rng: np.random.Generator) -> tuple[Floats, Ints]:
    """A toothed wheel with a hub and a bore, or a fluted knob."""
    teeth = int(rng.integers(6, 13))
    depth, sharp = rng.uniform(0.1, 0.2), rng.uniform(2.0, 5.0)
    half, bore, hub = rng.uniform(0.12, 0.3), rng.uniform(0.12, 0.22), rng.uniform(0.3, 0.42)
    lift = rng.uniform(0.05, 0.16)

    def distance(points: Floats) -> Floats:
        angle = np.arctan2(points[:, 2], points[:, 0])
        rim = 0.85 + depth * np.tanh(sharp * np.sin(teeth * angle)) / math.tanh(sharp)
        radial = np.hypot(points[:, 0], points[:, 2])
        # Dividing by the slope of the rim keeps this close to a distance, so that Newton's steps converge.
        wheel = -smooth_min(-(radial - rim) * 0.55, half - np.abs(points[:, 1]), 0.08)
        body = smooth_min(wheel, cylinder(points, np.zeros(3), 1, hub, half + lift, 0.03), 0.06)
        return smooth_cut(body, cylinder(points, np.zeros(3), 1, bore, 2.0, 0.01), 0.06)

    reach = np.array([1.12, half + lift + 0.08, 1.12])
    return level_set(distance, -reach, reach, grid=52)


def extrusion(rng: np.random.Generator) -> tuple[Floats, Ints]:
    """A star, polygon or clover drawn upwards, twisted and tapered."""
    sides = 120
    lobes = int(rng.integers(3, 7))
    angle = np.linspace(0.0, 2 * math.pi, sides, endpoint=False)
    outline = (np.abs(np.cos(lobes * angle / 2)) ** 8 + np.abs(np.sin(lobes * angle / 2)) ** 8) ** (-1 / 8)
    profile = np.stack([1.0 + rng.uniform(0.15, 0.5) * (outline - 1.0) * 3.0, angle * 0], axis=1)
    height = rng.uniform(0.8, 1.8)
    rounding = 0.06
    rim = np.linspace(0.0, rounding, 7)[:-1]
    s = np.concatenate([rim, np.linspace(rounding, height - rounding, 44), height - rim[::-1]])
    edge = np.minimum(s, height - s)
    bevel = np.where(edge < rounding, rounding - np.sqrt(np.maximum(rounding**2 - (rounding - edge) ** 2, 0)), 0.0)
    radius = 0.55 * (1 - rng.uniform(0.0, 0.5) * s / height) - bevel
    return loft(profile, s, radius, twist=rng.uniform(-1.2, 1.2))


def bracket(rng: np.random.Generator) -> tuple[Floats, Ints]:
    """A block with holes, a slot and a boss: a solid with parts cut away."""
    half = rng.uniform([0.5, 0.14, 0.35], [0.9, 0.3, 0.6])
    wall, hole = rng.uniform(0.12, 0.2), rng.uniform(0.1, 0.18)
    rise = rng.uniform(0.35, 0.7)
    boss = hole + rng.uniform(0.1, 0.16)
    place = rng.uniform(0.25, 0.55) * half[0]
    slot = rng.uniform(0.08, 0.14)

    def distance(points: Floats) -> Floats:
        body = box(points, np.zeros(3), half, 0.05)
        plate = box(points, np.array([-half[0] + wall, rise, 0.0]), np.array([wall, rise + half[1], half[2]]), 0.05)
        body = smooth_min(body, plate, 0.1)
        stud = cylinder(points, np.array([place, half[1], 0.0]), 1, boss, 0.22, 0.03)
        body = smooth_min(body, stud, 0.08)
        body = smooth_cut(body, cylinder(points, np.array([place, 0.0, 0.0]), 1, hole, 2.0, 0.01), 0.05)
        eye = np.array([-half[0] + wall, rise + 0.4 * half[1], 0.0])
        body = smooth_cut(body, cylinder(points, eye, 0, 1.3 * hole, 1.0, 0.01), 0.05)
        return smooth_cut(body, box(points, np.array([place, -half[1], 0.0]), np.array([2.0, slot, slot]), 0.02), 0.05)

    low = np.array([-half[0], -half[1], -half[2]]) - 0.08
    high = np.array([half[0], max(2 * rise + half[1], half[1] + 0.25), half[2]]) + 0.08
    return level_set(distance, low, high, grid=44)


def pipe_joint(rng: np.random.Generator) -> tuple[Floats, Ints]:
    """Pipes that meet, with flanges, bored through."""
    arms = [(0, 1.0), (0, -1.0), (1, 1.0), (2, 1.0)][: int(rng.integers(3, 5))]
    radius = rng.uniform(0.22, 0.32)
    reach, flange = rng.uniform(0.75, 1.0), rng.uniform(0.1, 0.18)

    def distance(points: Floats) -> Floats:
        body = np.linalg.norm(points, axis=1) - 1.15 * radius
        for axis, sign in arms:
            middle = np.zeros(3)
            middle[axis] = sign * reach / 2
            body = smooth_min(body, cylinder(points, middle, axis, radius, reach / 2, 0.03), 0.1)
            end = np.zeros(3)
            end[axis] = sign * (reach - 0.06)
            body = smooth_min(body, cylinder(points, end, axis, radius + flange, 0.06, 0.025), 0.04)
        for axis, sign in arms:
            middle = np.zeros(3)
            middle[axis] = sign * (reach / 2 + 0.2)
            body = smooth_cut(body, cylinder(points, middle, axis, 0.62 * radius, reach / 2 + 0.2, 0.01), 0.04)
        return np.asarray(body)

    size = np.full(3, radius + flange)
    low, high = -size, size.copy()
    for axis, sign in arms:
        (high if sign > 0 else low)[axis] = sign * reach
    return level_set(distance, low - 0.08, high + 0.08, grid=44)


KINDS: dict[str, Callable[[np.random.Generator], tuple[Floats, Ints]]] = {
    maker.__name__: maker
    for maker in (creature, lathe, blob, gear, figure, bracket, superquadric, pipe_joint, extrusion, knot)
}
"""Name -> maker; each maker gives vertices and faces, organic and mechanical in turn."""


def bumpy_torus(faces: int) -> Mesh:
    """A closed surface with lines of every family and about `faces` faces, all of similar size."""
    sides = max(3, round(math.sqrt(faces / 5.0)))
    rings = max(3, round(faces / 2.0 / sides))
    u, v = np.meshgrid(np.arange(rings) * (2 * np.pi / rings), np.arange(sides) * (2 * np.pi / sides), indexing="ij")
    radius = 0.14 * (1.0 + 0.12 * np.cos(5 * u + 2 * v) + 0.08 * np.sin(3 * v - 4 * u))
    across = 0.35 + radius * np.cos(v)
    vertices = np.stack([across * np.sin(u), radius * np.sin(v), across * np.cos(u)], axis=-1).reshape(-1, 3)
    i, j = (index.ravel() for index in np.meshgrid(np.arange(rings), np.arange(sides), indexing="ij"))
    a, b = i * sides + j, (i + 1) % rings * sides + j
    c, d = (i + 1) % rings * sides + (j + 1) % sides, i * sides + (j + 1) % sides
    triangles = np.stack([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)], axis=1).reshape(-1, 3)
    return make_mesh(vertices, triangles, f"bumpy torus of {len(triangles)} faces")
