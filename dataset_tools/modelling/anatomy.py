"""What animals, people and busts have in common: eyes, ears, mouths, limbs with toes and fingers.

Each works on a sculpture at a place whose z looks forward and whose y points up.
"""

import itertools

import numpy as np

from dataset_tools.modelling.fields import Place, ellipsoid, frame, limb, ripples
from dataset_tools.modelling.sculpting import Sculpture, Surface
from ncmodel.types import Floats

SIDES = (-1.0, 1.0)


def face_budget(rng: np.random.Generator, least: int = 9000, most: int = 32000) -> int:
    """How many faces a shape is to have: small counts are as likely as large ones, by their ratio."""
    return round(float(np.exp(rng.uniform(np.log(least), np.log(most)))))


def warped(surface: Surface, rng: np.random.Generator, amount: float = 0.03) -> Surface:
    """A surface bent smoothly as a whole, so that nothing on it is quite symmetric."""
    vertices, faces = surface
    size = float(np.ptp(vertices, axis=0).max())
    waves = [ripples(rng, 1.1 * size, 5) for _ in range(3)]
    return vertices + amount * size / 2 * np.stack([wave(vertices) for wave in waves], axis=1), faces


def eye(work: Sculpture, place: Place, side: float, x: float, y: float, z: float, radius: float) -> None:
    """A socket, a ball in it, and an upper and a lower lid."""
    r = place.scale * radius
    work.cut(ellipsoid(place.at(side * x, y, z + 0.5 * radius), (1.35 * r, 0.95 * r, 0.9 * r), place.axes), blend=r)
    work.add(ellipsoid(place.at(side * x, y, z - 0.25 * radius), 0.95 * r))
    across = np.linspace(-1.15, 1.15, 5)
    for lift, bow in ((0.15, 0.62), (-0.2, -0.45)):
        arc = [
            (side * x + radius * t, y + radius * (lift + bow * (1 - t * t)), z + radius * (0.45 * (1 - t * t) - 0.1))
            for t in across
        ]
        work.add(limb(place.along(arc), r * np.array([0.12, 0.2, 0.24, 0.2, 0.12])), blend=0.25 * r)


def button_eye(work: Sculpture, place: Place, side: float, x: float, y: float, z: float, radius: float) -> None:
    """A round eye that stands out of a dent."""
    r = place.scale * radius
    work.cut(ellipsoid(place.at(side * 1.15 * x, y, z), 1.25 * r), blend=0.6 * r)
    work.add(ellipsoid(place.at(side * x, y, z), r))


def groove(work: Sculpture, path: Floats, width: float, blend: float) -> None:
    """A furrow along a path on the surface."""
    work.cut(limb(path, width * np.concatenate([[0.4], np.ones(len(path) - 2), [0.4]])), blend=blend)


def ear(work: Sculpture, root: Floats, tip: Floats, width: float, flatten: float, yaw: float) -> None:
    """An animal's ear: a flat leaf from root to tip, hollowed in front."""
    axes = frame(yaw)
    middle = 0.5 * (root + tip)
    work.add(limb([root, middle, tip], [0.6 * width, width, 0.25 * width], flatten, axes), blend=0.4 * width)
    ahead = 0.95 * flatten * width * axes[2]
    hollow = [root + 0.35 * (tip - root) + ahead, middle + ahead, root + 0.8 * (tip - root) + ahead]
    work.cut(limb(hollow, [0.4 * width, 0.6 * width, 0.2 * width], flatten, axes), blend=0.25 * width)


def horn(work: Sculpture, path: Floats, radius: float, rings: int) -> None:
    """A horn that tapers along a path, ringed."""
    from dataset_tools.modelling.fields import smooth_curve

    fine = smooth_curve(path, 6)
    taper = np.linspace(1.0, 0.12, len(fine))
    work.add(limb(fine, radius * taper), blend=0.3 * radius)
    for k in np.linspace(1, len(fine) - 3, rings).astype(int) if rings else ():
        work.add(ellipsoid(fine[k], radius * taper[k] * 1.18), blend=0.15 * radius)


def toes(work: Sculpture, place: Place, count: int, width: float, length: float, clawed: bool) -> None:
    """A paw: toes side by side at a place, z forward."""
    for k in range(count):
        t = 0.0 if count == 1 else 2.0 * k / (count - 1) - 1.0
        size = place.scale * width / count * (1.25 - 0.15 * t * t)
        start = place.at(0.55 * width * t, 0.0, 0.0)
        end = place.at(0.8 * width * t, -0.2 * width, length * (1 - 0.2 * t * t))
        work.add(
            limb([start, 0.5 * (start + end) + [0, 0.25 * size, 0], end], [size, 1.05 * size, 0.85 * size]),
            blend=0.2 * size,
        )
        if clawed:
            claw = [end, place.at(0.85 * width * t, -0.35 * width, length * 1.35)]
            work.add(limb(claw, [0.45 * size, 0.12 * size]), blend=0.05 * size)


def finger(work: Sculpture, path: Floats, radius: float, nail: Floats, blend: float) -> None:
    """A finger along its joints, knuckles thicker than what is between, with a nail on the side of `nail`."""
    bones = [path[0]]
    radii = [1.05]
    for a, b in itertools.pairwise(path):
        bones += [0.5 * (a + b), b]
        radii += [0.92, 1.0]
    radii[-1] = 0.78
    work.add(limb(np.array(bones), radius * np.array(radii)), blend=blend)
    for joint in path[1:-1]:
        work.add(ellipsoid(joint + 0.35 * radius * nail, 0.75 * radius), blend=0.4 * radius)
        along = path[-1] - path[0]
        across = np.cross(along / np.linalg.norm(along), nail)
        crease = [joint + radius * (0.75 * s * across - 0.72 * nail) for s in (-0.6, 0.0, 0.6)]
        groove(work, np.array(crease), 0.13 * radius, 0.1 * radius)
    tip = path[-1] - path[-2]
    axes = np.stack([np.cross(nail, tip / np.linalg.norm(tip)), nail, tip / np.linalg.norm(tip)])
    work.add(
        ellipsoid(path[-1] + 0.62 * radius * nail, np.array([0.55, 0.22, 0.75]) * radius, axes), blend=0.05 * radius
    )
