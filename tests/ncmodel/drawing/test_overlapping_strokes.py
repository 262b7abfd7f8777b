"""Strokes along other strokes: what goes, and what stays."""

import numpy as np
import pytest

from eval.measures.metrics import compare_lines
from ncmodel.chamfer import Lines
from ncmodel.drawing.draw import draw
from ncmodel.drawing.overlapping_strokes import drop_overlapping
from ncmodel.mesh.load import make_mesh
from ncmodel.types import LineFamily, Stroke
from tests.helpers import analytic


def stroke(*points: tuple[float, float], alpha: float = 1.0) -> Stroke:
    return Stroke("creases", np.array(points, dtype=np.float64), np.full(len(points), alpha))


def length(strokes: tuple[Stroke, ...]) -> float:
    return float(sum(np.linalg.norm(np.diff(s.points, axis=0), axis=1).sum() for s in strokes))


LONG = stroke((0, 0), (60.5, 3), (100, 40))


@pytest.mark.parametrize("aside", [0.0, 0.2, -0.2])
@pytest.mark.parametrize("turn", [1, -1])
def test_a_stroke_along_a_longer_one_goes(aside: float, turn: int) -> None:
    twin = stroke(*[(x, y + aside) for x, y in ((5.3, 5.3 * 3 / 60.5), (60.5, 3))][::turn])
    assert drop_overlapping([twin, LONG], 0.25) == (LONG,)
    assert drop_overlapping([LONG, stroke((58, 2.88), (60.5, 3))], 0.25) == (LONG,)


@pytest.mark.parametrize(
    "other",
    [
        stroke((0, 1), (60.5, 4)),  # beside it
        stroke((30, -20), (30, 20)),  # across
        stroke((20, -4), (60, 6)),  # across at a small angle
        stroke((100, 40), (120, 60)),  # on from its end
    ],
)
def test_others_stay(other: Stroke) -> None:
    assert drop_overlapping([other, LONG], 0.25) == (other, LONG)


def test_stronger_ink_stays() -> None:
    faint, strong = stroke((0, 0), (100, 0), alpha=0.3), stroke((10, 0), (40, 0), alpha=0.8)
    assert drop_overlapping([faint, strong], 0.25) == (faint, strong)
    assert drop_overlapping([stroke((0, 0), (100, 0), alpha=0.8), stroke((10, 0), (40, 0), alpha=0.3)], 0.25)[1:] == ()


def test_what_leaves_a_longer_stroke_is_kept_from_there() -> None:
    fork = Stroke("creases", np.array([(10.0, 0.1), (50.0, 0.1), (50.0, 30.0)]), np.array([0.2, 0.6, 0.9]))
    kept = drop_overlapping([stroke((0, 0), (100, 0)), fork], 0.25)
    assert len(kept) == 2
    np.testing.assert_allclose(kept[1].points[-2:], fork.points[-2:])
    assert 30.0 < length(kept[1:]) < 33.0
    assert kept[1].alpha[-1] == 0.9
    assert 0.55 < kept[1].alpha[0] <= 0.6


def test_a_shape_in_a_tight_shell_is_drawn_once() -> None:
    vertices, faces = analytic.icosphere(4)
    once = make_mesh(vertices, faces)
    both = np.concatenate([vertices, vertices * 0.9997])
    twice = make_mesh(both, np.concatenate([faces, faces + len(vertices)]))
    families = [LineFamily.CONTOURS]
    single, double = (draw(mesh, lines=families) for mesh in (once, twice))
    assert length(double.strokes) == pytest.approx(length(single.strokes), rel=0.02)
    inks = [Lines.of(drawing.ink() > 0.5) for drawing in (single, double)]
    assert compare_lines(inks[0], inks[1], 1.0).f1 > 0.999


def test_nothing_is_no_trouble() -> None:
    assert drop_overlapping([], 0.25) == ()
    assert drop_overlapping([LONG], 0.25) == (LONG,)
