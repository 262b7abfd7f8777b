"""The decision tree: what it knows of pixels, predicts what its leaves say, learns what it should, and draws."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from eval.baselines.decision_tree import Rule, Tree, draw, expected_ink
from eval.baselines.tree_features import NAMES, feature_maps, near_surface
from eval.baselines.tree_fitting import RIDGES, Examples, examples_of, fit, ridge_costs
from eval.measures.evaluation import Settings, Target
from ncmodel.camera import Camera
from ncmodel.errors import InputError
from ncmodel.lines.visibility import MESH_EDGES
from ncmodel.mesh.load import make_mesh
from ncmodel.model.ridge_detection import RidgeOptions
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Image
from tests.helpers.analytic import ellipsoid, sphere
from tests.helpers.oracles import pixel_distances

SIDE = 192
GRADIENT, BRIGHTNESS = "gradient_1", "n_dot_v_1"
EDGES = Tree((Rule({}, {}, 0.0, {GRADIENT: 4.0}, 0.0, 1.0),), 0.0, RidgeOptions(low=0.3, high=0.6, full=0.3))
"""Ink where brightness changes fast."""


@pytest.fixture(scope="module")
def view() -> View:
    """An egg, which fills half of its picture."""
    mesh = make_mesh(*ellipsoid(3), "egg")
    return View(Surface(mesh), Camera.orbit(mesh.vertices, elevation=20, size=(SIDE, SIDE)))


def features(values: dict[str, list[float]]) -> Image:
    """(F, P) with these values, the others 0."""
    length = len(next(iter(values.values())))
    return np.array([values.get(name, [0.0] * length) for name in NAMES], dtype=np.float32)


def test_empty_paper_looks_the_same_everywhere(view: View) -> None:
    maps = feature_maps(view)
    assert maps.shape == (len(NAMES), SIDE, SIDE)
    assert np.isfinite(maps).all()
    paper = ~near_surface(view)
    assert paper.mean() > 0.2
    assert np.ptp(maps[:, paper], axis=1).max() < 1e-4


def test_curvature_of_a_sphere_is_the_same_everywhere_on_it() -> None:
    mesh = make_mesh(*sphere(), "ball")
    ball = View(Surface(mesh), Camera.orbit(mesh.vertices, size=(SIDE, SIDE)))
    maps = dict(zip(NAMES, feature_maps(ball), strict=True))
    hit = ball.buffers.hit
    # In units of the largest of them all, squashed: 1 / (1 + 1).
    for name in ("k1_1", "k2_1", "k1_4", "k2_4"):
        np.testing.assert_allclose(maps[name][hit], 0.5, atol=0.02)
        assert not maps[name][~hit].any()
    assert maps["depth_gradient_1"][hit].max() > 0.01


def test_what_is_learnt_holds_for_pictures_of_other_sizes(view: View) -> None:
    larger = View(view.surface, view.camera.resized(2 * SIDE, 2 * SIDE))
    small, large = feature_maps(view), feature_maps(larger)[:, ::2, ::2]
    inside = view.buffers.hit & larger.buffers.hit[::2, ::2]
    for name, one, other in zip(NAMES, small, large, strict=True):
        apart = np.median(np.abs(one - other)[inside])
        assert apart <= 0.1 * np.percentile(np.abs(one[inside]), 90) + 1e-6, name


def test_the_mean_of_the_leaves_that_hold_is_predicted() -> None:
    dark = Rule({}, {BRIGHTNESS: 0.5}, 0.4, {GRADIENT: 1.0}, 0.0, 0.9)
    steep = Rule({GRADIENT: 0.1}, {}, 0.2, {}, 0.2, 0.2)
    tree = Tree((dark, steep), 0.3)
    asked = features({BRIGHTNESS: [0.2, 0.5, 0.8, 0.8, 0.1], GRADIENT: [0.0, 0.1, 0.05, 0.5, 0.7]})
    assert tree.predict(asked) == pytest.approx([0.4, 0.5, 0.3, 0.2, (0.9 + 0.2) / 2], abs=1e-6)


def made_examples(count: int = 4000, seed: int = 0) -> Examples:
    """Pixels whose ink is linear in one feature, on either side of a step in another."""
    rng = np.random.default_rng(seed)
    values = rng.uniform(-1, 1, (len(NAMES), count)).astype(np.float32)
    step, slope = values[NAMES.index(GRADIENT)], values[NAMES.index("k1_2")]
    return Examples(values, np.where(step > 0.25, 0.6 + 0.3 * slope, 0.2 - 0.1 * slope).astype(np.float64))


def test_a_piecewise_linear_rule_is_learnt() -> None:
    pytest.importorskip("cubist")
    tree = fit(made_examples())
    asked = made_examples(2000, seed=1)
    away = np.abs(asked.features[NAMES.index(GRADIENT)] - 0.25) > 0.01
    assert np.abs(tree.predict(asked.features) - asked.ink)[away].max() < 0.02
    assert len(tree.rules) < 8
    assert fit(made_examples()) == tree


def test_noise_is_pruned_away() -> None:
    pytest.importorskip("cubist")
    examples = made_examples()
    ink = np.clip(0.5 + 0.1 * np.random.default_rng(2).standard_normal(len(examples.ink)), 0, 1)
    assert len(fit(Examples(examples.features, ink)).rules) <= 5


def test_cubist_predicts_the_same() -> None:
    cubist, pandas = pytest.importorskip("cubist"), pytest.importorskip("pandas")
    examples = made_examples()
    noisy = np.clip(examples.ink + 0.05 * np.random.default_rng(3).standard_normal(len(examples.ink)), 0, 1)
    theirs = cubist.Cubist(n_rules=100, unbiased=True, extrapolation=0.0, random_state=0)
    theirs.fit(pandas.DataFrame(examples.features.T, columns=list(NAMES)), noisy)
    asked = made_examples(500, seed=4).features
    expected = theirs.predict(pandas.DataFrame(asked.T, columns=list(NAMES)))
    # It computes with seven digits.
    np.testing.assert_allclose(fit(Examples(examples.features, noisy)).predict(asked), expected, atol=1e-4)


def test_half_of_the_examples_have_ink_and_none_is_empty_paper(view: View) -> None:
    ink = np.zeros((SIDE, SIDE), np.float32)
    ink[SIDE // 2 - 1 : SIDE // 2 + 1] = 1.0
    found = examples_of(view, ink, 100, np.random.default_rng(0))
    assert found.features.shape == (len(NAMES), 100)
    assert found.ink.mean() == 0.5
    near = feature_maps(view)[:, near_surface(view)]
    assert {column.tobytes() for column in found.features.T} <= {column.tobytes() for column in near.T}
    few = examples_of(view, ink, 10**6, np.random.default_rng(0))
    assert few.ink.sum() == (near_surface(view) & (ink > 0)).sum()


def test_a_tree_of_gradients_draws_the_outline(view: View) -> None:
    drawn = draw(view, EDGES)
    assert {stroke.family for stroke in drawn.strokes}.isdisjoint(MESH_EDGES)
    mask = drawn.ink() > 0.5
    hit = view.buffers.hit
    rim = hit & ~(np.roll(hit, 1, 0) & np.roll(hit, -1, 0) & np.roll(hit, 1, 1) & np.roll(hit, -1, 1))
    assert pixel_distances(mask, rim).min(axis=1).max() < 3
    assert np.median(pixel_distances(rim, mask).min(axis=1)) < 1.5
    assert not expected_ink(view, EDGES)[~near_surface(view)].any()


def test_what_counts_as_a_line_is_found(view: View) -> None:
    truth = replace(EDGES, ridges=RIDGES[-1])
    target = Target.of("egg", {"0": draw(view, truth).ink()}, Settings())
    costs = ridge_costs(view, target, EDGES, RIDGES[::5])
    assert costs.shape == (len(RIDGES[::5]),)
    assert ridge_costs(view, target, EDGES, RIDGES[-1:]) == pytest.approx([0.0])


def test_a_tree_is_read_as_it_was_written(tmp_path: Path) -> None:
    tree = replace(EDGES, training={"seed": 3})
    tree.save(tmp_path / "tree.json")
    assert Tree.load(tmp_path / "tree.json") == tree


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"kind": "letter"}, "a letter of version 1"),
        ({"version": 2}, "of version 2"),
        ({"features": ["a"]}, "1 features"),
        ({"mean": "much"}, "much"),
        ({"rules": [{"above": {"a": 1}}]}, "missing"),
        ({"rules": [{**vars(EDGES.rules[0]), "slopes": {"odd": 1.0}}]}, "known features"),
        ({"rules": 3}, "not iterable"),
    ],
)
def test_another_file_is_refused(tmp_path: Path, change: dict[str, object], complaint: str) -> None:
    path = tmp_path / "tree.json"
    EDGES.save(path)
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(InputError, match=complaint):
        Tree.load(path)


def test_what_is_no_json_is_refused(tmp_path: Path) -> None:
    (tmp_path / "tree.json").write_text("[1, 2")
    with pytest.raises(InputError, match=r"tree\.json"):
        Tree.load(tmp_path / "tree.json")
    with pytest.raises(InputError, match="can't be read"):
        Tree.load(tmp_path / "none.json")
