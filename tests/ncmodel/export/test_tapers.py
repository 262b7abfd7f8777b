"""Tapers as pieces of even opacity."""

import itertools
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from ncmodel.export.page import Picture
from ncmodel.export.png import ink
from ncmodel.export.svg import svg
from ncmodel.export.tapers import OPACITY_STEP, OVERLAP
from ncmodel.types import Stroke
from tests.helpers.pictures import SVG, shade_of, shown


def test_a_lone_taper_has_the_same_ink() -> None:
    points = np.linspace([10.0, 20.0], [190.0, 150.0], 4)
    taper = Picture(200, 200, [Stroke("suggestive", points, np.array([0.0, 0.9, 1.0, 0.3]))], line_width=10.0)
    vector, raster = shown(svg(taper), (200, 200)), ink(taper)
    assert vector.sum() == pytest.approx(raster.sum(), rel=0.03)
    levels = sorted({shade_of(path) for path in ET.fromstring(svg(taper)).iter(f"{SVG}path")})
    assert np.diff(levels).max() < 1.5 * OPACITY_STEP


def test_pieces_are_few_where_opacity_trembles_and_no_shorter_than_wide() -> None:
    rng = np.random.default_rng(2)
    points = np.stack([np.linspace(5, 195, 400), np.full(400, 50.0)], axis=1)
    still = Stroke("ridges", points, 0.5 + 0.4 * OPACITY_STEP * rng.choice([-1, 1], 400))
    wild = Stroke("ridges", points, rng.random(400))
    assert svg(Picture(768, 768, [still])).count("<path") == 1
    drawn = [np.array(d.split(), dtype=float) for d in re.findall(r'd="M([^"]+)"', svg(Picture(768, 768, [wild])))]
    assert min(d[-2] - d[0] for d in drawn[:-1]) > 1.98


def test_pieces_of_a_taper_run_on_from_each_other() -> None:
    rng = np.random.default_rng(1)
    points, alpha = np.cumsum(rng.normal(0, 9, (40, 2)), axis=0) + 100, rng.uniform(0.2, 1.0, 40)
    document = svg(Picture(200, 200, [Stroke("ridges", points, alpha)]))
    paths = [np.array(d.split(), dtype=float).reshape(-1, 2) for d in re.findall(r'd="M([^"]+)"', document)]
    for one, following in itertools.pairwise(paths):
        assert np.linalg.norm(one[-1] - following[0]) == pytest.approx(2 * OVERLAP, abs=0.02)
    length = sum(np.linalg.norm(np.diff(path, axis=0), axis=1).sum() for path in paths)
    overlaps = 2 * OVERLAP * (len(paths) - 1)
    assert length == pytest.approx(np.linalg.norm(np.diff(points, axis=0), axis=1).sum() + overlaps, rel=2e-3)


def test_invisible_parts_leave_a_gap() -> None:
    line = Stroke("ridges", np.array([[0.0, 5], [40, 5], [60, 5], [100, 5]]), np.array([1.0, 0.0, 0.0, 1.0]))
    document = svg(Picture(100, 10, [line]))
    ends = [[float(x) for x in d.split()] for d in re.findall(r'd="M([^"]+)"', document)]
    covered = np.array([[e[0], e[-2]] for e in ends])
    assert not ((covered[:, 0] < 45) & (covered[:, 1] > 55)).any()
    assert svg(Picture(100, 10, [Stroke("ridges", line.points, np.zeros(3))])).count("<path") == 0
