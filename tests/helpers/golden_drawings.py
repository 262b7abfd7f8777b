"""Three small stored drawings: the meshes they are of, the commands that draw them, and what tells two drawings apart.

`pytest tests/ncmodel/cli/test_golden_drawings.py --update-golden` draws them anew; a change in them needs a reason.
"""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from ncmodel.types import Floats
from tests.helpers import analytic
from tests.helpers.dirty import Geometry, box, joined, moved
from tests.helpers.pictures import SVG, shade_of

FOLDER = Path(__file__).parents[1] / "golden"

PIXELS = 0.3
"""Lines may be off by what simplification allows and rounding adds: the last digits of numbers, which other
processors may compute differently, can decide which points of a line are kept."""
OPACITY = 0.08
"""A taper's pieces are of even opacity, steps of 1/32 apart; a piece may end a little earlier or later."""
SPACING = 0.1  # pixels between compared points


def torus() -> Geometry:
    """Closed, so coarse that some of its edges are creases."""
    return analytic.torus(16, 8)


def window() -> Geometry:
    """A bumpy torus with a window, and a block that pierces it: lines of all eight families."""
    vertices, faces = analytic.torus(16, 10)
    vertices = vertices * (1 + 0.3 * np.sin(18 * vertices[:, :1]) * np.cos(11 * vertices[:, 2:]))
    return joined((vertices, faces[20:]), moved(box(), (0.4, -0.2, 0.1), 0.3))


def open_box() -> Geometry:
    """A box without its lid: boundaries and creases."""
    vertices, faces = box((0, 0, 0), (1, 0.6, 0.8))
    return vertices, faces[vertices[faces][:, :, 1].min(axis=1) < 0.6]


DRAWINGS = {
    "torus": (torus, "draw torus.obj -o torus.svg --size 96"),
    "window": (
        window,
        "draw window.obj -o window.svg --size 96"
        " --lines contours,boundaries,creases,intersections,suggestive,ridges,valleys,apparent"
        " --thresholds suggestive=0.02,apparent=1",
    ),
    "open_box": (open_box, "draw open_box.obj -o open_box.svg --size 128 --azimuth 50"),
}
"""Name -> the mesh, and the command that made the drawing of it."""


def differences(found: str, expected: str) -> list[str]:
    """What tells one SVG drawing from another beyond `PIXELS` and `OPACITY`, a line each; nothing if they are alike.

    Lines are compared as points along them, so that it doesn't matter in which order, direction and pieces they come.
    """
    here, there = ET.fromstring(found.encode()), ET.fromstring(expected.encode())
    told = [
        f"{name} is {here.get(name)}, expected {there.get(name)}"
        for name in ("width", "height", "viewBox")
        if here.get(name) != there.get(name)
    ]
    ours, theirs = (list(root.iter(f"{SVG}g")) for root in (here, there))
    if [group.get("id") for group in ours] != [group.get("id") for group in theirs]:
        names = ([str(group.get("id")) for group in groups] for groups in (ours, theirs))
        return [*told, "families are {}, expected {}".format(*(", ".join(part) for part in names))]
    for one, other in zip(ours, theirs, strict=True):
        told += _differences_in_a_family(one, other)
    return told


def _differences_in_a_family(one: ET.Element, other: ET.Element) -> list[str]:
    told = []
    if one.get("stroke-width") != other.get("stroke-width"):
        told.append(f"{one.get('id')}: lines are {one.get('stroke-width')} wide, expected {other.get('stroke-width')}")
    for points, others, what in (
        (_points(other), _points(one), "missing"),
        (_points(one), _points(other), "not expected"),
    ):
        scale = np.array([1 / PIXELS, 1 / PIXELS, 1 / OPACITY])
        if len(others) == 0:
            return [*told, f"{one.get('id')}: all lines {what}"]
        distance, _ = cKDTree(others * scale).query(points * scale, p=np.inf)
        if (distance > 1).any():
            u, v, opacity = points[distance > 1][0]
            length = SPACING * (distance > 1).sum()
            told.append(
                f"{one.get('id')}: {length:.1f} of {SPACING * len(points):.1f} pixels {what}, "
                f"the first at ({u:.1f}, {v:.1f}) of opacity {opacity:.2f}"
            )
    return told


def _points(group: ET.Element) -> Floats:
    """(n, 3) u, v and opacity along a family's paths."""
    parts = [np.zeros((0, 3))]
    for path in group.iter(f"{SVG}path"):
        corners = np.array(path.attrib["d"].lstrip("M").split(), dtype=float).reshape(-1, 2)
        along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
        at = np.linspace(0, along[-1], max(2, round(along[-1] / SPACING)))
        u, v = (np.interp(at, along, corners[:, axis]) for axis in (0, 1))
        parts.append(np.stack([u, v, np.full(len(at), shade_of(path))], axis=1))
    return np.concatenate(parts)
