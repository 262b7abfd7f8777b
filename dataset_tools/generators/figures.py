"""Hands in a gesture, and whole characters in a pose, dressed."""

import numpy as np

from dataset_tools.generators.heads import hat
from dataset_tools.modelling.anatomy import SIDES, button_eye, face_budget, finger, groove, warped
from dataset_tools.modelling.fields import (
    Place,
    common,
    drum,
    ellipsoid,
    frame,
    frame_along,
    limb,
    ring,
    ripples,
    slab,
    turned,
)
from dataset_tools.modelling.sculpting import Sculpture, Surface


def hand(rng: np.random.Generator) -> Surface:
    """A hand in some gesture, left or right, with or without a sleeve."""
    work = Sculpture()
    side = float(rng.choice(SIDES))
    wide, long, thick = rng.uniform(0.36, 0.48), rng.uniform(0.42, 0.52), rng.uniform(0.1, 0.14)
    palm = Place(np.zeros(3), frame(rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3)))
    work.add(slab(palm.at(0, 0.5 * long, 0), (0.5 * wide + 0.04, 0.55 * long, thick), 0.95 * thick, palm.axes))
    work.add(
        limb(palm.along([(0, -0.5, -0.02), (0, -0.12, 0), (0, 0.2, 0)]), [0.19, 0.16, 0.2], 0.75, palm.axes), blend=0.12
    )
    gesture, spread = rng.uniform(0.0, 1.2), rng.uniform(0.05, 0.22)
    lone = int(rng.integers(0, 6))  # one finger may point while the others bend
    back = -palm.axes[2]
    lengths = np.array([0.62, 0.7, 0.65, 0.5]) * rng.uniform(0.85, 1.1)
    for k, length in enumerate(lengths):
        t = (k - 1.5) / 1.5
        bend = 0.12 if k == lone else gesture * rng.uniform(0.75, 1.15)
        yaw = -side * spread * t
        knuckle = palm.at(-side * t * 0.43 * wide, long * (1.02 - 0.07 * t * t), 0.0)
        path, pitch, normal = [knuckle], 0.15, back
        for part in (0.45, 0.32, 0.25):
            pitch += bend * (0.9 if part > 0.4 else 1.0)
            direction = palm.axes[1] * np.cos(pitch) + palm.axes[2] * np.sin(pitch) + palm.axes[0] * yaw * np.cos(pitch)
            path.append(path[-1] + length * part * direction / np.linalg.norm(direction))
            normal = -palm.axes[2] * np.cos(pitch) + palm.axes[1] * np.sin(pitch)
        finger(work, np.array(path), rng.uniform(0.078, 0.092) * (0.85 if k == 3 else 1.0), normal, 0.04)
        work.add(ellipsoid(knuckle + 0.07 * back, 0.07), blend=0.05)
        tendon = [palm.at(-0.2 * side * t * wide, 0.1, -thick), knuckle + 0.06 * back]
        work.add(limb(tendon, [0.02, 0.04]), blend=0.06)
    thumb = [palm.at(side * 0.3 * wide, 0.1, 0.04), palm.at(side * (0.55 * wide + 0.1), 0.34, 0.14 + 0.1 * gesture)]
    tip = palm.at(side * (0.55 * wide + rng.uniform(-0.2, 0.3)), 0.62, 0.16 + 0.22 * gesture)
    thumb += [(thumb[1] + tip) / 2 + side * 0.05 * palm.axes[0], tip]
    work.add(limb(thumb[:2], [0.16, 0.12]), blend=0.1)
    finger(work, np.array(thumb[1:]), 0.1, (back + side * palm.axes[0]) / np.sqrt(2), 0.06)
    for height, bow in ((0.62, 0.1), (0.42, -0.12)):
        crease = [
            (-0.45 * wide, long * height, 0.95 * thick),
            (0, long * (height + bow), 1.02 * thick),
            (0.45 * wide, long * (height + 2 * bow * side * 0.3), 0.95 * thick),
        ]
        groove(work, palm.along(crease), 0.016, 0.02)
    if rng.random() < 0.45:
        work.add(drum(palm.at(0, -0.75, -0.02), palm.at(0, -0.3, -0.02), rng.uniform(0.24, 0.32), 0.04), blend=0.005)
        work.add(ring(palm.at(0, -0.34, -0.02), palm.axes[1], 0.27, 0.04), blend=0.02)
    return warped(work.mesh(face_budget(rng, 10000, 36000)), rng, 0.02)


def character(rng: np.random.Generator) -> Surface:
    """A person or a toy figure in a pose, dressed: belt, boots, collar, hat or hair, sometimes a skirt or a cape."""
    work = Sculpture()
    stout, childlike = rng.uniform(0.8, 1.35), rng.uniform(0.0, 1.0)
    lean, twist = rng.uniform(-0.12, 0.12), rng.uniform(-0.4, 0.4)
    waist = np.array([0.0, 0.98 - 0.15 * childlike, 0.0])
    chest = waist + [lean, 0.36, rng.uniform(-0.05, 0.08)]
    turned_chest = Place(chest, frame(twist, rng.uniform(-0.1, 0.1), lean))
    broad = 0.19 * stout
    work.add(ellipsoid(waist + [0, -0.02, 0], (0.19 * stout, 0.17, 0.14 * stout)))
    work.add(limb([waist, 0.5 * (waist + chest), chest], 0.15 * stout * np.array([1.0, 0.95, 1.1]), 0.8), blend=0.06)
    work.add(ellipsoid(chest, (broad * 1.1, 0.2, 0.14 * stout), turned_chest.axes), blend=0.06)
    for side in SIDES:
        _arm(work, rng, turned_chest, side, broad)
        _leg(work, rng, waist, side, stout)
    _character_head(work, rng, turned_chest, 0.16 + 0.12 * childlike)
    work.add(ring(waist + [0, 0.06, 0], (0.1 * lean, 1, 0), 0.165 * stout, 0.035), blend=0.006)
    work.add(slab(waist + [0.0, 0.06, 0.185 * stout], (0.05, 0.04, 0.03), 0.01), blend=0.004)
    dress = int(rng.integers(4))
    if dress == 0:
        pleats, wide, low = rng.integers(7, 15), rng.uniform(0.3, 0.5), rng.uniform(0.3, 0.7)
        skirt = turned(
            [
                (0, waist[1] + 0.03),
                (0.15 * stout, waist[1] + 0.03),
                (wide, low),
                (wide - 0.04, low),
                (0.1, waist[1] - 0.1),
                (0, waist[1] - 0.1),
            ]
        )
        work.add(skirt, blend=0.02)
        work.press(
            skirt,
            lambda p: 0.03 * np.sin(pleats * np.arctan2(p[:, 0], p[:, 2])) * np.clip((waist[1] - p[:, 1]) / 0.3, 0, 1),
            0.02,
        )
    elif dress == 1:
        folds = ripples(rng, 0.16, 5)
        cape = limb(
            turned_chest.along([(0, 0.12, -0.12), (0, -0.3, -0.22), (rng.uniform(-0.2, 0.2), -1.0, -0.42)]),
            [0.22, 0.3, 0.42],
            0.14,
            turned_chest.axes,
        )
        work.add(cape, blend=0.01)
        work.press(cape, lambda p: 0.035 * folds(p * [1, 0.15, 0.3]), 0.03)
    else:
        line = [(0.0, 0.16, 0.13), (0.01, 0.0, 0.17), (0.0, -0.3, 0.17)]
        groove(work, turned_chest.along(line), 0.01, 0.01)
    return warped(work.mesh(face_budget(rng, 12000, 40000)), rng, 0.02)


def _arm(work: Sculpture, rng: np.random.Generator, chest: Place, side: float, broad: float) -> None:
    lift, swing, bend = rng.uniform(0.15, 1.5), rng.uniform(-0.6, 0.9), rng.uniform(0.1, 1.8)
    shoulder = chest.at(side * (broad + 0.03), 0.12, 0)
    down = np.array([side * np.sin(lift), -np.cos(lift), np.sin(swing) * np.cos(lift)])
    elbow = shoulder + 0.3 * down / np.linalg.norm(down)
    fore = down * np.cos(bend) + np.array([-0.4 * side, 0.5, 1.0]) * np.sin(bend)
    fore /= np.linalg.norm(fore)
    wrist = elbow + 0.27 * fore
    work.add(ellipsoid(shoulder, 0.085), blend=0.05)
    work.add(limb([shoulder, 0.5 * (shoulder + elbow), elbow], [0.075, 0.078, 0.06]), blend=0.04)
    work.add(limb([elbow, elbow + 0.3 * (wrist - elbow), wrist], [0.058, 0.065, 0.042]), blend=0.02)
    if rng.random() < 0.6:
        work.add(drum(wrist - 0.07 * fore, wrist, 0.065, 0.015), blend=0.006)
    palm = Place(wrist + 0.05 * fore, frame_along(fore, rng.uniform(-1, 1)), 0.09)
    work.add(slab(palm.origin, (0.045, 0.055, 0.026), 0.02, palm.axes), blend=0.02)
    curl = rng.uniform(0.1, 0.9)
    for k in range(4):
        x = 0.36 * (k - 1.5)
        work.add(
            limb(
                palm.along([(x, 0.4, 0), (1.1 * x, 0.9, 0.1 * curl), (1.15 * x, 1.35 - 0.6 * curl, 0.7 * curl)]), 0.0165
            ),
            blend=0.006,
        )
    work.add(
        limb(palm.along([(-0.4 * side, 0.0, 0.1), (-0.8 * side, 0.35, 0.3), (-0.75 * side, 0.7, 0.4)]), 0.019),
        blend=0.01,
    )


def _leg(work: Sculpture, rng: np.random.Generator, waist: np.ndarray, side: float, stout: float) -> None:
    stride, stance = rng.uniform(-0.35, 0.35), rng.uniform(0.09, 0.22)
    hip = waist + [side * 0.1 * stout, -0.1, 0]
    ankle = np.array([side * stance, 0.1, stride])
    knee = (hip + ankle) / 2 + [0, 0.02, 0.05 + 0.1 * abs(stride)]
    calf = ankle + 0.6 * (knee - ankle) + [0, 0, -0.03]
    work.add(limb([hip, 0.5 * (hip + knee), knee], 0.1 * stout * np.array([1.1, 1.0, 0.75])), blend=0.05)
    work.add(limb([knee, calf, ankle], [0.075 * stout, 0.078 * stout, 0.05]), blend=0.03)
    if rng.random() < 0.7:
        cuff = ankle + rng.uniform(0.2, 0.75) * (calf - ankle)
        work.add(limb([cuff, ankle], [0.092, 0.07]), blend=0.004)
        work.add(ring(cuff, cuff - ankle, 0.085, 0.02), blend=0.006)
    foot = Place(ankle, frame(side * rng.uniform(0, 0.5)))
    work.add(
        limb(foot.along([(0, -0.03, -0.04), (0, -0.04, 0.08), (0, -0.055, 0.19)]), [0.06, 0.058, 0.045]), blend=0.03
    )
    work.add(slab(foot.at(0, -0.09, 0.07), (0.06, 0.018, 0.16), 0.012, foot.axes), blend=0.004)


def _character_head(work: Sculpture, rng: np.random.Generator, chest: Place, size: float) -> None:
    place = Place(
        chest.at(0, 0.24 + 1.1 * size, 0.02), frame(rng.uniform(-0.7, 0.7), rng.uniform(-0.2, 0.2)) @ chest.axes, size
    )
    work.add(limb([chest.at(0, 0.12, 0), place.origin], [0.075, 0.06]), blend=0.04)
    work.add(ring(chest.at(0, 0.2, 0.01), chest.axes[1], 0.075, 0.025), blend=0.006)
    work.add(ellipsoid(place.origin, size * np.array([0.88, 1.0, 0.95]), place.axes), blend=0.01)
    work.add(ellipsoid(place.at(0, -0.55, 0.35), 0.5 * size), blend=0.25 * size)
    for side in SIDES:
        button_eye(work, place, side, 0.34, 0.05, 0.86, rng.uniform(0.12, 0.2))
        work.add(
            ellipsoid(place.at(0.88 * side, 0.0, 0.0), size * np.array([0.12, 0.26, 0.18]), place.axes),
            blend=0.05 * size,
        )
        work.add(
            limb(place.along([(0.15 * side, 0.33, 0.9), (0.5 * side, 0.36, 0.78)]), 0.06 * size), blend=0.05 * size
        )
    nose = rng.uniform(0.1, 0.22)
    work.add(ellipsoid(place.at(0, -0.15, 0.95), size * np.array([nose, nose, 1.3 * nose])), blend=0.1 * size)
    smile = rng.uniform(-0.08, 0.16)
    groove(
        work,
        place.along([(-0.35, -0.5 + smile, 0.8), (0, -0.55, 0.93), (0.35, -0.5 + smile, 0.8)]),
        0.045 * size,
        0.03 * size,
    )
    if rng.random() < 0.5:
        hat(work, rng, Place(place.at(0, -0.1, 0), place.axes, 2.1 * size))
    else:
        cap = ellipsoid(place.at(0, 0.12, -0.1), size * np.array([1.0, 1.05, 1.02]), place.axes)
        behind = slab(
            place.at(0, 1.6, -0.9),
            size * np.array([2, 1.6, 2.0]),
            0.1 * size,
            frame(0, -rng.uniform(0.3, 0.7)) @ place.axes,
        )
        work.add(common(cap, [behind]), blend=0.02 * size)
        work.press(
            common(cap, [behind]), lambda p: 0.05 * size * np.sin(9 * (p[:, 0] - place.origin[0]) / size), 0.1 * size
        )
