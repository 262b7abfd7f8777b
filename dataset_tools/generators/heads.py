"""Heads and busts: any face, with hair, hat, beard, glasses."""

import numpy as np

from dataset_tools.modelling.anatomy import SIDES, eye, face_budget, groove, warped
from dataset_tools.modelling.fields import (
    Place,
    common,
    ellipsoid,
    frame,
    limb,
    ring,
    ripples,
    slab,
    turned,
)
from dataset_tools.modelling.sculpting import Sculpture, Surface


def head(rng: np.random.Generator) -> Surface:
    """A head on its neck, shoulders or a stand: any face, hair or hat, beard, glasses."""
    work = Sculpture()
    turn, nod, tilt = rng.uniform(-0.5, 0.5), rng.uniform(-0.2, 0.2), rng.uniform(-0.15, 0.15)
    place = Place(np.zeros(3), frame(turn, nod, tilt))
    _skull_and_face(work, rng, place)
    kind = int(rng.integers(4))
    if kind < 3:
        _hair(work, rng, place, long=kind == 2)
    else:
        hat(work, rng, place)
    nape = np.array([0.0, -0.85, -0.1])
    work.add(limb([place.at(0, -0.25, -0.12), nape], [0.24, rng.uniform(0.22, 0.32)]), blend=0.08)
    for side in SIDES:
        work.add(limb([place.at(0.3 * side, -0.25, -0.1), nape + [0.06 * side, 0.0, 0.24]], [0.05, 0.045]), blend=0.06)
    stand = int(rng.integers(3))
    if stand == 0:
        wide = rng.uniform(0.55, 0.8)
        for side in SIDES:
            path = [
                nape,
                nape + [0.4 * wide * side, -0.16, 0],
                nape + [side * wide, -0.3, 0],
                nape + [1.1 * side * wide, -0.6, 0],
            ]
            work.add(limb(path, [0.24, 0.22, 0.22, 0.18]), blend=0.12)
            work.add(
                limb([nape + [0.06 * side, -0.08, 0.25], nape + [0.7 * side * wide, -0.18, 0.2]], [0.05, 0.04]),
                blend=0.06,
            )
        work.add(ellipsoid(nape + [0, -0.45, 0.03], (0.85 * wide, 0.4, 0.32)), blend=0.12)
        work.cut(slab(nape + [0, -1.0, 0], (2, 0.4, 2)), blend=0.02)
    elif stand == 1:
        outline = [
            (0, -1.4),
            (0.42, -1.4),
            (0.42, -1.3),
            (0.34, -1.26),
            (0.2, -1.12),
            (0.22, -0.95),
            (0.3, -0.86),
            (0, -0.8),
        ]
        work.add(turned(outline), blend=0.02)
    else:
        work.cut(slab(nape + [0, -0.45, 0], (2, 0.42, 2), 0, frame(0, rng.uniform(-0.3, 0.3))), blend=0.02)
    return warped(work.mesh(face_budget(rng, 12000, 45000)), rng, 0.025)


def _skull_and_face(work: Sculpture, rng: np.random.Generator, place: Place) -> None:
    wide, jaw, chin = rng.uniform(0.88, 1.1), rng.uniform(0.85, 1.2), rng.uniform(-0.56, -0.47)
    axes = place.axes
    work.add(ellipsoid(place.at(0, 0.16, -0.06), (0.37 * wide, 0.42, 0.47), axes))
    work.add(ellipsoid(place.at(0, -0.14, 0.11), (0.29 * wide, 0.4, 0.31), axes), blend=0.15)
    for side in SIDES:
        line = [(0.28 * side * wide, -0.1, -0.02), (0.23 * side * jaw, -0.38, 0.1), (0, chin, 0.3)]
        work.add(limb(place.along(line), [0.08, 0.08, 0.1]), blend=0.12)
        cheek = rng.uniform(0.07, 0.11)
        work.add(ellipsoid(place.at(0.2 * side * wide, -0.17, 0.3), (cheek, cheek, 0.8 * cheek), axes), blend=0.12)
    size, brow = rng.uniform(0.075, 0.1), rng.uniform(0.025, 0.05)
    apart, frown = rng.uniform(0.135, 0.17), rng.uniform(-0.04, 0.05)
    for side in SIDES:
        eye(work, place, side, apart, -0.03, 0.36, size)
        line = [(0.28 * side, 0.05 + frown, 0.28), (0.17 * side, 0.11, 0.4), (0.05 * side, 0.07 - frown, 0.43)]
        work.add(limb(place.along(line), brow), blend=0.05)
    long, hook, wing = rng.uniform(0.17, 0.27), rng.uniform(-0.03, 0.05), rng.uniform(0.045, 0.07)
    end = rng.uniform(0.5, 0.6)
    bridge = [(0, 0.06, 0.4), (0, 0.0, 0.42 + hook), (0, -0.02 - 0.6 * long, 0.47 + hook), (0, -long, end)]
    work.add(limb(place.along(bridge), [0.04, 0.035, 0.045, wing]), blend=0.05)
    for side in SIDES:
        work.add(
            ellipsoid(place.at(1.15 * wing * side, -long - 0.02, end - 0.08), (0.7 * wing, 0.75 * wing, wing), axes),
            blend=0.03,
        )
        work.cut(
            ellipsoid(
                place.at(0.6 * wing * side, -long - 0.06, end - 0.04), (0.35 * wing, 0.4 * wing, 0.5 * wing), axes
            ),
            blend=0.015,
        )
        fold = [
            (1.7 * wing * side, -long + 0.02, 0.42),
            (0.15 * side, -long - 0.1, 0.4),
            (0.17 * side, -long - 0.2, 0.36),
        ]
        if rng.random() < 0.5:
            groove(work, place.along(fold), 0.016, 0.03)
    mouth, smile, lips = -long - rng.uniform(0.11, 0.15), rng.uniform(-0.03, 0.05), rng.uniform(0.022, 0.042)
    half = rng.uniform(0.1, 0.16)
    ends = 0.44 - 1.6 * half * half
    for lift, bow in ((0.5, 0.012), (-0.75, -0.012)):
        line = [
            (-half, mouth + smile, ends - 0.03),
            (-0.3 * half, mouth + lift * lips + bow, 0.45),
            (0, mouth + lift * lips, 0.455),
        ]
        line += [(0.3 * half, mouth + lift * lips + bow, 0.45), (half, mouth + smile, ends - 0.03)]
        work.add(limb(place.along(line), lips * np.array([0.4, 1.0, 1.05, 1.0, 0.4])), blend=0.03)
    line = [(-1.1 * half, mouth + smile, ends + 0.01), (0, mouth, 0.495), (1.1 * half, mouth + smile, ends + 0.01)]
    groove(work, place.along(line), 0.012 if rng.random() < 0.8 else 0.03, 0.012)
    _human_ears(work, place, wide, rng.uniform(0.85, 1.25))
    if rng.random() < 0.25:
        _beard(work, rng, place, mouth, chin)
    if rng.random() < 0.2:
        _glasses(work, place, apart, rng.uniform(0.1, 0.14))


def _human_ears(work: Sculpture, place: Place, wide: float, size: float) -> None:
    for side in SIDES:
        out = 0.375 * wide
        rim = [(0.0, -0.1, 0.02), (0.02, -0.02, -0.06), (0.06, 0.1, -0.1), (0.06, 0.15, -0.02), (0.03, 0.1, 0.04)]
        path = [(side * (out + size * x), -0.05 + size * y, -0.02 + size * z) for x, y, z in rim]
        work.add(limb(place.along(path), 0.028 * size), blend=0.02)
        work.add(
            ellipsoid(place.at(side * (out + 0.01), -0.02, -0.03), (0.03, 0.11 * size, 0.06 * size), place.axes),
            blend=0.03,
        )
        work.cut(
            ellipsoid(place.at(side * (out + 0.06), -0.0, -0.01), (0.03, 0.05 * size, 0.03 * size), place.axes),
            blend=0.02,
        )


def _hair(work: Sculpture, rng: np.random.Generator, place: Place, long: bool) -> None:
    """Hair to a hairline, combed in strands."""
    volume = rng.uniform(0.035, 0.1)
    cap = ellipsoid(place.at(0, 0.17, -0.08), (0.38 + volume, 0.43 + volume, 0.48 + volume), place.axes)
    line, slope = rng.uniform(0.24, 0.36), rng.uniform(0.4, 0.9)
    behind = slab(
        place.at(rng.uniform(-0.12, 0.12), line + 0.9, -0.55), (1.5, 1.0, 1.1), 0.05, frame(0, -slope) @ place.axes
    )
    work.add(common(cap, [behind]), blend=0.015)
    if long:
        for side in SIDES:
            for k in range(4):
                reach = rng.uniform(-1.1, -0.6)
                lock = [
                    (side * (0.25 + 0.05 * k), 0.35, 0.1 - 0.14 * k),
                    (side * 0.43, 0.0, 0.05 - 0.15 * k),
                    (side * rng.uniform(0.38, 0.5), 0.5 * reach, -0.16 * k),
                    (side * rng.uniform(0.3, 0.5), reach, 0.05 - 0.13 * k),
                ]
                work.add(limb(place.along(lock), [0.08, 0.1, 0.1, 0.05]), blend=0.02)
    elif rng.random() < 0.3:
        work.add(ellipsoid(place.at(0, 0.5, -0.4), rng.uniform(0.13, 0.22)), blend=0.03)
    strands, twist = rng.uniform(18, 34), rng.uniform(-3, 3)
    curl = ripples(rng, 0.25, 8)

    def combed(points: np.ndarray) -> np.ndarray:
        local = (points - place.origin) @ place.axes.T
        angle = np.arctan2(local[:, 0], local[:, 1] + 0.2)
        return np.asarray(0.013 * np.sin(strands * angle + twist * local[:, 2] + 1.2 * curl(points)))

    work.press(common(cap, [behind]), combed, 0.04)


def hat(work: Sculpture, rng: np.random.Generator, place: Place) -> None:
    """A hat with or without a brim, set a little askew on a head at a place."""
    high, brim = rng.uniform(0.3, 0.6), rng.uniform(0.02, 0.3)
    rim = [(0, 0), (0.45 + brim, 0), (0.46 + brim, 0.03), (0.46, 0.05), (0.46, 0.13), (0.44, 0.14)]
    outline = place.scale * np.array([*rim, (rng.uniform(0.25, 0.45), high), (0, high + 0.03)])
    axes = frame(rng.uniform(-0.2, 0.2), rng.uniform(-0.25, 0.05), rng.uniform(-0.15, 0.15)) @ place.axes
    work.add(turned(outline, place.at(0, 0.24, -0.05), axes), blend=0.02 * place.scale)


def _beard(work: Sculpture, rng: np.random.Generator, place: Place, mouth: float, chin: float) -> None:
    reach, curl = rng.uniform(0.1, 0.45), ripples(rng, 0.09, 10)
    for side in SIDES:
        work.add(
            limb(
                place.along([(0.33 * side, -0.15, 0.05), (0.26 * side, -0.4, 0.15), (0, chin - 0.5 * reach, 0.34)]),
                [0.05, 0.1, 0.13],
            ),
            blend=0.05,
        )
        work.add(
            limb(
                place.along(
                    [(0, mouth + 0.07, 0.48), (0.11 * side, mouth + 0.04, 0.44), (0.18 * side, mouth - 0.1, 0.34)]
                ),
                [0.03, 0.04, 0.03],
            ),
            blend=0.02,
        )
    work.add(limb(place.along([(0, chin, 0.33), (0, chin - reach, 0.32)]), [0.14, 0.05]), blend=0.08)
    region = ellipsoid(place.at(0, chin - 0.5 * reach, 0.25), (0.36, 0.25 + 0.5 * reach, 0.3), place.axes)
    work.press(region, lambda p: 0.012 * curl(p * [1.0, 0.4, 1.0]), 0.05)


def _glasses(work: Sculpture, place: Place, apart: float, radius: float) -> None:
    for side in SIDES:
        work.add(ring(place.at(apart * side, -0.03, 0.5), place.axes[2], radius, 0.018), blend=0.004)
        work.add(
            limb(
                place.along([(side * (apart + radius), -0.02, 0.49), (0.4 * side, 0.0, 0.2), (0.4 * side, 0.0, -0.05)]),
                0.018,
            )
        )
    work.add(limb(place.along([(-0.06, 0.0, 0.5), (0, 0.02, 0.52), (0.06, 0.0, 0.5)]), 0.018))
