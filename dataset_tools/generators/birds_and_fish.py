"""Birds, with feathers in rows, and fish, with scales and rayed fins."""

import numpy as np

from dataset_tools.modelling.anatomy import (
    SIDES,
    button_eye,
    face_budget,
    groove,
    toes,
    warped,
)
from dataset_tools.modelling.fields import Place, ellipsoid, frame, limb
from dataset_tools.modelling.sculpting import Sculpture, Surface


def bird(rng: np.random.Generator) -> Surface:
    """A bird with folded or spread wings, feathers in rows, a bill, and feet on a perch or on none."""
    work = Sculpture()
    lean, plump = rng.uniform(-0.2, 0.7), rng.uniform(0.24, 0.36)
    axes = frame(0.0, -lean)
    body = Place(np.array([0.0, 0.7, 0.0]), axes)
    work.add(ellipsoid(body.origin, (plump, plump * rng.uniform(0.9, 1.15), 0.5), axes))
    head_scale = plump * rng.uniform(0.5, 0.75)
    neck = rng.uniform(0.12, 0.55)
    poll = body.at(rng.uniform(-0.1, 0.1), 0.6 * plump + neck, 0.36 + 0.2 * neck)
    sweep = (body.at(0, 0.1, 0.3) + poll) / 2 + [0, 0, rng.uniform(-0.05, 0.1)]
    work.add(
        limb([body.at(0, 0.1, 0.25), sweep, poll], [0.75 * plump, 0.8 * head_scale, 0.75 * head_scale]), blend=0.12
    )
    place = Place(poll, frame(rng.uniform(-0.9, 0.9), rng.uniform(-0.2, 0.3)), head_scale)
    work.add(ellipsoid(place.at(0, 0.1, 0.1), head_scale * np.array([0.9, 0.95, 1.05]), place.axes), blend=0.08)
    bill, hook, wide = rng.uniform(0.7, 2.6), rng.uniform(0.0, 0.5), rng.uniform(0.2, 0.42)
    upper = [(0, 0.05, 0.8), (0, 0.05 - 0.1 * hook, 0.9 + 0.6 * bill), (0, -0.1 - hook, 0.95 + bill)]
    work.add(limb(place.along(upper), head_scale * wide * np.array([1.2, 0.8, 0.15]), 1.0), blend=0.05 * head_scale)
    lower = [(0, -0.2, 0.75), (0, -0.22 - 0.05 * hook, 0.85 + 0.55 * bill), (0, -0.2 - 0.6 * hook, 0.9 + 0.85 * bill)]
    work.add(limb(place.along(lower), head_scale * wide * np.array([0.9, 0.5, 0.12])), blend=0.01)
    for side in SIDES:
        button_eye(work, place, side, 0.72, 0.3, 0.5, rng.uniform(0.16, 0.26))
        line = [(side * 0.25, -0.1, 1.0 + 0.4 * bill), (side * 0.5, -0.12, 0.85), (side * 0.75, -0.05, 0.6)]
        groove(work, place.along(line), 0.06 * head_scale, 0.03)
    if rng.random() < 0.35:
        for k in range(int(rng.integers(3, 6))):
            tip = place.at(0.1 * (k - 2), 1.5 + 0.25 * k, -0.6 - 0.25 * k)
            work.add(limb([place.at(0, 0.9, 0.1 - 0.15 * k), tip], head_scale * np.array([0.2, 0.08])), blend=0.04)
    spread = rng.uniform(0.5, 1.1) if rng.random() < 0.4 else 0.0
    for side in SIDES:
        _wing(work, rng, body, side, plump, spread)
    for k in np.linspace(-1, 1, int(rng.integers(4, 8))):
        fan = body.at(0.22 * k * rng.uniform(0.8, 1.2), 0.0, -0.85 - 0.1 * (1 - k * k))
        work.add(limb([body.at(0.08 * k, 0.02, -0.35), fan], [0.07, 0.06], 0.35, axes), blend=0.01)
    stance = rng.uniform(-0.08, 0.08)
    for side in SIDES:
        hip, knee = body.at(0.45 * plump * side, -0.6 * plump, -0.05), np.array([0.5 * plump * side, 0.28, 0.02])
        ground = np.array([0.5 * plump * side, 0.05, side * stance])
        work.add(limb([hip, knee], [0.13, 0.05]), blend=0.08)
        work.add(limb([knee, ground + [0, 0.1, -0.05], ground], [0.045, 0.03, 0.035]), blend=0.02)
        toes(work, Place(ground, frame(rng.uniform(-0.3, 0.3)), 0.06), 3, 1.6, 2.2, True)
        work.add(limb([ground, ground + [0, -0.01, -0.14]], [0.035, 0.02]), blend=0.01)
    return warped(work.mesh(face_budget(rng, 10000, 36000)), rng, 0.02)


def _wing(work: Sculpture, rng: np.random.Generator, body: Place, side: float, plump: float, spread: float) -> None:
    """A wing of overlapping feathers, two rows."""
    shoulder = body.at(side * 0.8 * plump, 0.25 * plump, 0.22)
    lift = rng.uniform(0.1, 0.7)
    outward = np.array([side * spread, lift * spread, 0.1 * spread])
    wrist = shoulder + outward + (body.at(side * 0.12, 0.02, -0.1) - body.origin)
    work.add(limb([shoulder, wrist], [0.13, 0.08], 0.6, frame(0, 0, 0)), blend=0.08)
    rows = ((int(rng.integers(5, 9)), 0.5, 0.0), (int(rng.integers(4, 7)), 0.28, 0.04))
    for count, reach, up in rows:
        for t in np.linspace(0, 1, count):
            root = shoulder + t * (wrist - shoulder) + up * np.array([0.6 * side, 0.5, 0.1])
            back = body.at(
                side * (0.03 + 0.5 * spread * t), -0.25 * plump * (1 - t) * (spread == 0), -reach * (0.75 + 0.45 * t)
            )
            tip = root + back - body.origin
            work.add(
                limb(
                    [root, 0.5 * (root + tip) + [0.03 * side, 0.02, 0], tip],
                    [0.07, 0.075, 0.035],
                    0.35,
                    frame(0, 0, 0.9 * side * (spread == 0)),
                ),
                blend=0.004,
            )


def fish(rng: np.random.Generator) -> Surface:
    """A fish: scales or none, gill cover, rayed fins, a tail, its body bent as it swims."""
    work = Sculpture()
    tall, thin, bend = rng.uniform(0.16, 0.42), rng.uniform(0.1, 0.2), rng.uniform(-0.25, 0.25)
    along = np.linspace(0.95, -0.8, 8)
    taper = np.array([0.28, 0.68, 0.93, 1.0, 0.9, 0.66, 0.4, 0.24]) ** rng.uniform(0.8, 1.2)
    spine = np.stack([bend * np.sin(1.8 * along), 0.05 * np.sin(2 * along), along], axis=1)
    work.add(limb(spine, tall * taper, thin / tall, np.array([[0, 0, 1.0], [0, 1.0, 0], [-1.0, 0, 0]])))
    scaly = rng.random() < 0.6
    pitch = rng.uniform(0.075, 0.12)

    def scales(points: np.ndarray) -> np.ndarray:
        u, v = points[:, 2] / pitch, points[:, 1] / pitch
        row = np.floor(u)
        across = v + 0.5 * (row % 2)
        return np.asarray(0.012 * (u - row) * np.abs(np.cos(np.pi * across)))

    if scaly:
        work.press(ellipsoid((0, 0, -0.1), (0.6, 0.8 * tall, 0.75)), scales, 0.06)
    snout = spine[0]
    for side in SIDES:
        place = Place(spine[1] + [0, 0.15 * tall, 0.0], frame(0.2 * side), 1.0)
        button_eye(work, place, side, thin * 0.62, 0.0, 0.02, tall * rng.uniform(0.14, 0.24))
        gill = spine[2] + np.array([side * thin, 0.0, -0.02])
        arc = [
            gill + [-0.15 * side * thin, 0.55 * tall, 0.05],
            gill + [0, 0.2 * tall, -0.06],
            gill + [0, -0.2 * tall, -0.06],
            gill + [-0.2 * side * thin, -0.6 * tall, 0.08],
        ]
        groove(work, np.array(arc), 0.018, 0.015)
        mouth = [
            snout + [0, -0.02, 0.28 * tall],
            snout + [0.6 * side * thin * taper[0], -0.05, 0.1 * tall],
            snout + [0.75 * side * thin * taper[1], -0.3 * tall, -0.1],
        ]
        groove(work, np.array(mouth), 0.016, 0.015)
        root = spine[3] + np.array([side * thin * 0.85, -0.35 * tall, 0.05])
        _fin(
            work,
            rng,
            root,
            root + [0, -0.12, -0.03],
            np.array([side * 0.22, -0.12, -0.3]),
            np.array([side * 0.18, -0.2, -0.16]),
        )
    size = rng.uniform(0.15, 0.4)
    _fin(
        work,
        rng,
        spine[2] + [0, 0.8 * tall, 0],
        spine[5] + [0, 0.5 * tall, 0],
        np.array([0, size, -0.12]),
        np.array([0, 0.4 * size, -0.15]),
    )
    _fin(
        work,
        rng,
        spine[4] + [0, -0.75 * tall, 0],
        spine[5] + [0, -0.5 * tall, 0],
        np.array([0, -0.7 * size, -0.12]),
        np.array([0, -0.3 * size, -0.12]),
    )
    fork = rng.uniform(0.2, 0.45)
    for up in SIDES:
        end = np.array([-0.3 * bend, up * fork, -rng.uniform(0.3, 0.5)])
        _fin(work, rng, spine[-1] + [0, up * 0.15 * tall, 0], spine[-1], end, np.array([-0.2 * bend, 0.04 * up, -0.2]))
    return warped(work.mesh(face_budget(rng, 10000, 40000)), rng, 0.02)


def _fin(
    work: Sculpture, rng: np.random.Generator, start: np.ndarray, end: np.ndarray, first: np.ndarray, last: np.ndarray
) -> None:
    """A fin of rays, from where it begins to where it ends, its first and its last ray."""
    for t in np.linspace(0, 1, int(rng.integers(5, 9))):
        root, ray = start + t * (end - start), first + t * (last - first)
        tip = root + ray * rng.uniform(0.92, 1.05)
        work.add(limb([root - 0.15 * ray, 0.5 * (root + tip), tip], [0.035, 0.026, 0.016]), blend=0.035)
