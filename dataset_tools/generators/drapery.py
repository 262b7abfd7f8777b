"""Cloth: thrown over a ball, a box or a table, or hung from pegs; it falls by itself until it lies in folds."""

import numpy as np

from dataset_tools.modelling.fields import Part, drum, ellipsoid, frame, ripples, slab
from dataset_tools.modelling.patches import block, lathe, merged, moved, outwards, refined, rounded_profile, sheet, tube
from dataset_tools.modelling.sculpting import Surface
from ncmodel.types import Floats

STEPS, ROUNDS = 170, 9
"""Steps of the fall, and corrections of the threads' lengths in each."""

GRAVITY, DRAG, FRICTION = 0.0009, 0.975, 0.6


def drapery(rng: np.random.Generator) -> Surface:
    """A cloth in folds over or below what holds it: tablecloth, dust sheet, curtain, towel."""
    kind = int(rng.integers(4))
    rows, columns = (int(rng.integers(40, 60)) for _ in range(2))
    wide, long = rng.uniform(1.2, 1.8), rng.uniform(1.2, 1.8)
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, rows), np.linspace(-0.5, 0.5, columns), indexing="ij")
    if kind < 3:
        holders, solids = _holder(rng, kind)
        spread = np.stack([long * u, np.full_like(u, 1.02), wide * v], axis=-1) @ frame(rng.uniform(0, 1.5))
        spread += rng.uniform(-0.12, 0.12, 3) * [1, 0, 1]
        spread[..., 1] += 0.012 * ripples(rng, 0.3, 8)(spread.reshape(-1, 3)).reshape(u.shape)
        cloth = _fallen(spread, np.zeros(u.shape, dtype=bool), solids)
    else:
        pegs, gather = int(rng.integers(3, 8)), rng.uniform(0.55, 0.8)
        pleated = rng.random() < 0.6
        wave = wide * 0.16 / (pegs - 1) * np.cos(2 * np.pi * (pegs - 1) * (v + 0.5)) * (1.0 if pleated else 0.4)
        spread = np.stack([gather * wide * v, 2.0 - long * (u + 0.5), wave + 0.15 * u * v], axis=-1)
        pinned = np.zeros(u.shape, dtype=bool)
        crests = np.linspace(0, columns - 1, pegs).round().astype(int)
        pinned[0, slice(None) if pleated else crests] = True
        rest = np.stack([wide * v, long * u, np.zeros_like(u)], axis=-1)
        cloth = _fallen(spread, pinned, [], rest)
        high, reach = float(cloth[0, crests, 1].max()) + 0.03, 0.5 * gather * wide + 0.15
        holders = [tube(np.linspace((-reach, high, 0), (reach, high, 0), 20), 0.022, 14)]
        knob = lathe(rounded_profile([(0, -0.04), (0.045, -0.03), (0.05, 0.03), (0, 0.06)], 0.02), 20)
        for side in (-1.0, 1.0):
            holders.append(moved(knob, (side * reach, high, 0), frame(0, 0, side * np.pi / 2)))
        for place in cloth[0, crests]:
            angle = np.linspace(0, 2 * np.pi, 17)
            loop = np.stack([np.zeros(17), 0.035 * np.cos(angle), 0.035 * np.sin(angle)], axis=1)
            holders.append(tube(loop + [place[0], high, 0], 0.007, 8))
    return moved(merged([sheet(_finer(cloth), rng.uniform(0.008, 0.02)), *holders]), axes=frame(rng.uniform(-0.8, 0.8)))


def _holder(rng: np.random.Generator, kind: int) -> tuple[list[Surface], list[Part]]:
    """What the cloth falls on: its surfaces, and the parts that keep the cloth out."""
    if kind == 0:
        radius = rng.uniform(0.3, 0.5)
        centre = np.array([0, 1.0 - radius, 0])
        outline = [(0, 0), (0.3, 0), (0.3, 0.05), (0.1, 0.12), (0.1, 1 - radius), (0, 1 - radius)]
        return [lathe(refined(rounded_profile(outline, 0.03), 0.05), 32)], [ellipsoid(centre, radius)]
    if kind == 1:
        half = rng.uniform([0.25, 0.2, 0.2], [0.55, 0.4, 0.45])
        turn = frame(rng.uniform(0, 1.5))
        other = rng.uniform(0.12, 0.22)
        at = np.array([rng.uniform(-0.25, 0.25), 1.0 - other * 0.8, rng.uniform(-0.2, 0.2)])
        high = 1.0 - 1.2 * other - half[1]
        solids = [slab((0, high, 0), half, 0.06, turn), ellipsoid(at, other)]
        return [moved(block(half, 0.06, 3, 6), (0, high, 0), turn)], solids
    radius, legs = rng.uniform(0.45, 0.7), int(rng.integers(3, 6))
    # The cloth's table is a drum down to the floor, so that nothing is pulled through the board.
    top = drum((0, 0.3, 0), (0, 1.0, 0), radius, 0.025)
    board = [(0, 0.94), (radius, 0.94), (radius, 1.0), (0, 1.0)]
    holders = [outwards(lathe(refined(rounded_profile(board, 0.025), 0.08), 48))]
    shape = [(0, 0), (0.03, 0), (0.02, 0.1), (0.05, 0.5), (0.035, 0.6), (0.06, 0.7), (0.06, 0.95), (0, 0.95)]
    leg = lathe(refined(rounded_profile(shape, 0.02), 0.04), 16)
    holders += [moved(leg, 0.75 * radius * frame(2 * np.pi * k / legs)[2]) for k in range(legs)]
    return holders, [top]


def _fallen(spread: Floats, pinned: np.ndarray, solids: list[Part], rest: Floats | None = None) -> Floats:
    """A cloth, (rows, columns, 3), after its fall: Verlet steps, then threads brought back to their lengths.

    Threads run along rows, along columns and along both diagonals (which resist shear), and across every second
    vertex (which resist bending).
    """
    still = spread if rest is None else rest
    threads = [
        (first, second, np.linalg.norm(still[first] - still[second], axis=-1, keepdims=True), stiffness)
        for first, second, stiffness in _threads()
    ]
    lowest = 0.012
    place, before = spread.copy(), spread.copy()
    for _ in range(STEPS):
        moving = place + DRAG * (place - before) - [0, GRAVITY, 0]
        before, place = place, np.where(pinned[..., None], spread, moving)
        for _ in range(ROUNDS):
            for first, second, length, stiffness in threads:
                along = place[first] - place[second]
                now = np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1e-9)
                # Neighbouring threads move a vertex at once: half of the half each keeps that stable.
                shift = 0.25 * stiffness * (now - length) / now * along
                place[first] -= shift
                place[second] += shift
            place[pinned] = spread[pinned]
        for solid in solids:
            _kept_out(place, before, solid)
        place[..., 1] = np.maximum(place[..., 1], lowest)
    return place


def _threads() -> list[tuple[tuple[slice, slice], tuple[slice, slice], float]]:
    """Slices of the vertices at both ends, and stiffness."""
    every, head, tail = slice(None), slice(None, -1), slice(1, None)
    return [
        ((head, every), (tail, every), 1.0),
        ((every, head), (every, tail), 1.0),
        ((head, head), (tail, tail), 0.4),
        ((head, tail), (tail, head), 0.4),
        ((slice(None, -2), every), (slice(2, None), every), 0.15),
        ((every, slice(None, -2)), (every, slice(2, None)), 0.15),
    ]


def _kept_out(place: Floats, before: Floats, solid: Part, gap: float = 0.018) -> None:
    """Push vertices out of a solid, and slow those that rub on it."""
    points = place.reshape(-1, 3)
    inside = np.flatnonzero(solid.distance(points) < gap)
    if not len(inside):
        return
    near = points[inside]
    depth = gap - solid.distance(near)
    slope = np.stack([solid.distance(near + step) - solid.distance(near - step) for step in 1e-4 * np.eye(3)], axis=1)
    slope /= np.maximum(np.linalg.norm(slope, axis=1, keepdims=True), 1e-12)
    points[inside] = near + depth[:, None] * slope
    earlier = before.reshape(-1, 3)
    earlier[inside] += FRICTION * (points[inside] - earlier[inside])


def _finer(cloth: Floats) -> Floats:
    """Twice as many rows and columns, through the same points, smooth."""
    from scipy.interpolate import CubicSpline

    for axis in (0, 1):
        count = cloth.shape[axis]
        place = np.linspace(0, count - 1, 2 * count - 1)
        cloth = CubicSpline(np.arange(count), cloth, axis=axis)(place)
    return cloth
