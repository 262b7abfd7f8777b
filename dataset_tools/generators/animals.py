"""Animals on legs: four of them, or the six and eight of insects, spiders and scorpions."""

import numpy as np

from dataset_tools.modelling.anatomy import (
    SIDES,
    button_eye,
    ear,
    eye,
    face_budget,
    groove,
    horn,
    toes,
    warped,
)
from dataset_tools.modelling.fields import Place, ellipsoid, frame, limb, ripples
from dataset_tools.modelling.sculpting import Sculpture, Surface


def quadruped(rng: np.random.Generator) -> Surface:
    """A four-legged animal in its stride: cat, dog, horse, cow, goat, pig, bear or none of them."""
    work = Sculpture()
    length, girth, height = rng.uniform(0.85, 1.35), rng.uniform(0.17, 0.31), rng.uniform(0.4, 0.85)
    bow, sway = rng.uniform(-0.06, 0.06), rng.uniform(-0.08, 0.08)
    rump, chest = np.array([0.0, height, -length / 2]), np.array([sway, height * rng.uniform(0.95, 1.1), length / 2])
    loin = (rump + chest) / 2 + [0.5 * sway, bow, 0.0]
    belly = rng.uniform(0.8, 1.15)
    work.add(limb([rump, loin, chest], girth * np.array([0.9, belly * 0.88, 1.0])))
    work.add(ellipsoid(chest + [0, -0.2 * girth, -0.3 * girth], girth * np.array([0.92, 1.15, 1.3])), blend=0.1)
    _quadruped_legs(work, rng, rump, chest, girth)
    scale = girth * rng.uniform(0.75, 1.1)
    turn, nod = rng.uniform(-0.8, 0.8), rng.uniform(-0.15, 0.5)
    neck = rng.uniform(0.25, 0.7)
    rise = rng.uniform(0.15, 1.15)
    poll = chest + neck * np.array([0.35 * np.sin(turn), np.sin(rise), np.cos(rise)]) + [0, 0.3 * girth, 0.25 * girth]
    middle = (chest + poll) / 2 + [0.0, rng.uniform(-0.04, 0.08), rng.uniform(-0.02, 0.06)]
    work.add(
        limb([chest + [0, 0.2 * girth, 0.1 * girth], middle, poll], [0.8 * girth, 0.75 * scale, 0.75 * scale]),
        blend=0.12,
    )
    _quadruped_head(work, rng, Place(poll, frame(turn, nod), scale))
    _tail(work, rng, rump + [0, 0.35 * girth, -0.7 * girth], girth)
    if rng.random() < 0.35:
        coat = ripples(rng, rng.uniform(0.05, 0.12), 16)
        work.press(ellipsoid(loin, (0.6, 0.6, length)), lambda p: 0.008 * coat(p * [1, 0.5, 1]), 0.3)
    return warped(work.mesh(face_budget(rng)), rng, 0.025)


def _quadruped_legs(
    work: Sculpture, rng: np.random.Generator, rump: np.ndarray, chest: np.ndarray, girth: float
) -> None:
    thick = girth * rng.uniform(0.24, 0.42)
    hoofed, count = rng.random() < 0.4, int(rng.integers(3, 5))
    sit = rng.random() < 0.15
    for end, bend, front in ((chest, -0.06, True), (rump, 0.1, False)):
        for side in SIDES:
            stride = rng.uniform(-0.24, 0.24)
            hip = end + [0.6 * girth * side, -0.15 * girth, 0.0]
            out = hip[0] + 0.1 * girth * side
            ground = np.array([out, 0.04, hip[2] + stride + (0.35 if sit and not front else 0.0)])
            knee = np.array([out, 0.55 * hip[1], hip[2] + 0.5 * stride + bend + (0.3 if sit and not front else 0.0)])
            hock = np.array([out, 0.25 * hip[1], knee[2] + 0.4 * (ground[2] - knee[2]) - 1.3 * bend])
            muscle = girth * np.array([0.42, 0.85, 0.6 if front else 0.75])
            work.add(ellipsoid(hip + [0, -0.15 * girth, 0], muscle, frame(0, rng.uniform(-0.3, 0.3))), blend=0.07)
            work.add(limb([hip, knee, hock, ground], thick * np.array([1.7, 1.15, 0.8, 0.85])), blend=0.06)
            work.add(ellipsoid(knee, 1.15 * thick), blend=0.04)
            foot = Place(ground, frame(rng.uniform(-0.25, 0.25)), thick)
            if hoofed:
                work.add(limb(foot.along([(0, 0.3, 0), (0, -0.5, 0.5)]), thick * np.array([0.95, 1.35])), blend=0.01)
                groove(work, foot.along([(0, 1.0, 1.5), (0, 0, 1.9), (0, -1.2, 2.0)]), 0.22 * thick, 0.1 * thick)
            else:
                toes(work, foot, count, 1.5, 1.5, rng.random() < 0.5)
    if sit:
        work.add(ellipsoid(rump + [0, -0.3, 0.05], (girth, 0.35, girth)), blend=0.15)


def _quadruped_head(work: Sculpture, rng: np.random.Generator, place: Place) -> None:
    s = place.scale
    muzzle, wide = rng.uniform(0.7, 1.9), rng.uniform(0.38, 0.7)
    drop = -rng.uniform(0.15, 0.45)
    work.add(ellipsoid(place.at(0, 0.1, 0.15), s * np.array([0.75, 0.8, 0.95]), place.axes), blend=0.25 * s)
    snout = [(0, 0, 0.5), (0, 0.6 * drop, 0.5 + 0.5 * muzzle), (0, drop, 0.5 + muzzle)]
    work.add(limb(place.along(snout), s * np.array([0.66, 0.9 * wide, wide]), 0.85, place.axes), blend=0.3 * s)
    jaw = [(0, -0.45, 0.1), (0, drop - 0.4, 0.45 + 0.5 * muzzle), (0, drop - 0.42, 0.4 + 0.92 * muzzle)]
    work.add(limb(place.along(jaw), s * np.array([0.4, 0.7 * wide, 0.55 * wide])), blend=0.12 * s)
    front = 0.5 + muzzle + 0.8 * wide
    work.add(
        ellipsoid(place.at(0, drop + 0.3 * wide, front - 0.1), s * wide * np.array([0.55, 0.42, 0.4])), blend=0.06 * s
    )
    for side in SIDES:
        lip = [(0.1 * side * wide, drop - 0.45 * wide, front), (side * wide, drop - 0.35 * wide, 0.5 + muzzle)]
        groove(work, place.along([*lip, (side * 0.95 * wide, drop - 0.15, 0.5 + 0.35 * muzzle)]), 0.07 * s, 0.06 * s)
        work.cut(
            ellipsoid(place.at(0.28 * side * wide, drop + 0.3 * wide, front + 0.22 * wide), 0.15 * s * wide),
            blend=0.05 * s,
        )
        if rng.random() < 0.6:
            eye(work, Place(place.at(0, 0, 0), frame(0.6 * side) @ place.axes, s), side, 0.2, 0.3, 0.92, 0.2)
        else:
            button_eye(work, place, side, 0.56, 0.3, 0.75, rng.uniform(0.14, 0.22))
        work.add(limb(place.along([(0.3 * side, 0.52, 0.95), (0.55 * side, 0.56, 0.7)]), 0.14 * s), blend=0.1 * s)
    kind, size, spread = int(rng.integers(3)), rng.uniform(0.5, 1.3), rng.uniform(0.2, 0.9)
    for side in SIDES:
        lift = (0.8, 0.25, -0.6)[kind] + rng.uniform(-0.15, 0.15)
        tip = place.at(side * (0.5 + size * spread), 0.65 + size * lift, -0.15 + 0.2 * rng.uniform(-1, 1))
        ear(work, place.at(0.5 * side, 0.65, -0.1), tip, s * rng.uniform(0.25, 0.42), 0.35, 0.4 * side)
    if rng.random() < 0.3:
        curl, reach = rng.uniform(-0.6, 1.0), rng.uniform(0.8, 2.0)
        for side in SIDES:
            path = [
                (0.3 * side, 0.75, 0.1),
                (0.45 * side, 0.8 + 0.4 * reach, -0.1),
                (0.55 * side + 0.4 * curl * side, 0.75 + 0.7 * reach, -0.3 - 0.4 * reach),
            ]
            horn(work, place.along(path), 0.2 * s, int(rng.integers(0, 8)))


def _tail(work: Sculpture, rng: np.random.Generator, root: np.ndarray, girth: float) -> None:
    reach, side = rng.uniform(0.2, 0.7), rng.uniform(-0.3, 0.3)
    lift = rng.uniform(-0.6, 0.6)
    path = [root, root + [0.4 * side, 0.4 * lift * reach, -0.5 * reach], root + [side, lift * reach, -0.75 * reach]]
    bushy = rng.random() < 0.4
    radii = girth * (np.array([0.25, 0.4, 0.12]) if bushy else np.array([0.24, 0.16, 0.1]))
    work.add(limb(path, radii), blend=0.06)


def insect(rng: np.random.Generator) -> Surface:
    """A beetle, ant, spider or scorpion-like animal: segments, jointed legs, feelers, pincers or horns."""
    work = Sculpture()
    segments = int(rng.integers(2, 4))
    z, parts = 0.0, []
    for k in range(segments):
        radii = np.array([rng.uniform(0.16, 0.3), rng.uniform(0.13, 0.24), rng.uniform(0.2, 0.38)]) * (
            1.3 if k == 0 else 0.85
        )
        z += radii[2] * (0.0 if k == 0 else 0.85)
        parts.append((np.array([0.03 * rng.normal(), 0.32 + 0.02 * rng.normal(), z]), radii))
        work.add(ellipsoid(*parts[-1], frame(0.1 * rng.normal(), 0.1 * rng.normal())), blend=0.03)
        z += radii[2] * 0.8
    back, radii = parts[0]
    if rng.random() < 0.6:
        groove(
            work,
            np.array(
                [
                    back + [0, radii[1], radii[2] * 0.7],
                    back + [0, 1.02 * radii[1], 0],
                    back + [0, 0.5 * radii[1], -radii[2] * 0.95],
                ]
            ),
            0.018,
            0.015,
        )
    for t in np.linspace(-0.6, 0.6, int(rng.integers(0, 6))):
        reach = np.sqrt(1 - t * t)
        arc = [
            back + [radii[0] * reach * np.sin(a) * 1.02, radii[1] * reach * np.cos(a) * 1.02, t * radii[2]]
            for a in np.linspace(-1.6, 1.6, 7)
        ]
        groove(work, np.array(arc), 0.015, 0.012)
    thorax, wide = parts[min(1, segments - 1)]
    for k in range(pairs := int(rng.integers(3, 5))):
        for side in SIDES:
            t = k / (pairs - 1) - 0.5
            hip = thorax + [side * 0.7 * wide[0], -0.4 * wide[1], t * wide[2] * 1.4]
            knee = hip + [side * rng.uniform(0.22, 0.36), rng.uniform(0.12, 0.28), t * 0.4]
            shin = knee + [side * rng.uniform(0.14, 0.3), -knee[1] + 0.08, t * 0.35]
            work.add(limb([hip, knee], [0.055, 0.045]), blend=0.03)
            work.add(limb([knee, shin, shin + [side * 0.1, -0.05, 0.05]], [0.045, 0.03, 0.02]), blend=0.01)
            work.add(ellipsoid(knee, 0.055), blend=0.02)
    head, size = parts[-1]
    for side in SIDES:
        button_eye(work, Place(head), side, 0.7 * size[0], 0.4 * size[1], 0.6 * size[2], rng.uniform(0.045, 0.09))
        feeler = [
            head + [0.3 * side * size[0], 0.5 * size[1], 0.8 * size[2]],
            head + [side * 0.25, 0.3, size[2] + 0.15],
            head + [side * 0.4, 0.25 + 0.1 * rng.normal(), size[2] + 0.4],
        ]
        work.add(limb(feeler, [0.028, 0.02, 0.022]), blend=0.02)
        arm = [
            head + [0.6 * side * size[0], -0.1, 0.6 * size[2]],
            head + [side * 0.28, -0.12, size[2] + 0.12],
            head + [side * 0.06, -0.12, size[2] + 0.32],
        ]
        work.add(limb(arm, [0.06, 0.05, 0.02]), blend=0.03)
    if rng.random() < 0.5:
        path = [
            back + [0, 0.2 * radii[1], -0.9 * radii[2]],
            back + [0.05, 0.3, -radii[2] - 0.3],
            back + [0.1 * rng.normal(), 0.65, -radii[2] - 0.15],
            back + [0.1 * rng.normal(), 0.7, -radii[2] + 0.15],
        ]
        for a, b in zip(np.linspace(0, 0.85, 6), np.linspace(0.15, 1.0, 6), strict=True):
            knots = np.array(
                [[np.interp(t * 3, range(4), np.array(path)[:, d]) for d in range(3)] for t in (a, (a + b) / 2, b)]
            )
            work.add(limb(knots, 0.1 * np.array([1.0, 1.15, 0.9]) * (1 - 0.6 * a)), blend=0.006)
    return warped(work.mesh(face_budget(rng, 12000, 40000)), rng, 0.03)
