"""The searches beside each other on one view."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from eval.benchmark import searches
from eval.benchmark.searches import Clamped, SearchRow, measure_searches, search_part, search_rows
from ncmodel.cli.main import main
from ncmodel.errors import UsageError
from ncmodel.mesh.load import make_mesh
from ncmodel.model.predictor import Model
from ncmodel.model.threshold_search import LARGE_BUDGETS
from ncmodel.nets.blocks import WIDE, initialise
from ncmodel.nets.checkpoints import Checkpoint
from ncmodel.nets.ranking import RankingModule
from ncmodel.published.search import Schedule, published_search
from ncmodel.types import Floats
from tests.helpers import analytic
from tests.helpers.known_scores import Known
from tests.helpers.micro_training import MICRO

pytestmark = pytest.mark.usefixtures("one_thread")


@pytest.fixture
def wide() -> Model:
    """A ranking module as wide as large ones, but shallow, with random weights."""
    ranker = RankingModule(replace(MICRO.ranking, size=16, width=WIDE, blocks=(1,)))
    initialise(ranker, torch.Generator().manual_seed(0))
    return Model(Checkpoint(replace(MICRO, translation=MICRO.translation, ranking=ranker.dims), ranker=ranker))


def test_all_searches_maximise_the_same_score(wide: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    short = Schedule(starts=2, steps=2, inner=4)
    monkeypatch.setattr(searches, "published_search", lambda drawing: published_search(drawing, short))
    row = measure_searches(make_mesh(*analytic.torus(40, 20)), wide)
    looks = LARGE_BUDGETS["balanced"].looks
    assert row.evaluations == looks + 1
    assert 2 <= row.published_evaluations <= 2 * 2 * 5
    assert row.grid_evaluations > 2 * row.evaluations
    scores = np.array([row.score, row.grid_score, row.published_score])
    assert np.isfinite(scores).all()
    # One surface of scores: what 2 x 2 short steps reach from random places, neither search is far below.
    assert row.score >= row.published_score - 0.05 * abs(row.published_score)


def test_thresholds_are_clamped_as_the_published_code_does() -> None:
    asked: list[Floats] = []

    def score(t: Floats) -> float:
        asked.append(t)
        return float(t.sum())

    drawing = Clamped(Known(score, boundary_gain=1.0))
    value, slope = drawing.slope(np.array([-1.0, 0.5, 6.0, 1.0]))
    assert value == pytest.approx(0.0 + 0.5 + 5.0 + 1.0)  # boundaries would add 1
    np.testing.assert_allclose(slope, [0.0, 1.0, 0.0, 1.0], atol=1e-6)
    assert drawing.present.all()


def test_the_part_says_how_often_the_schedule_s_score_is_reached(wide: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = iter([SearchRow("a", 2.0, 10, 1.5, 150, 1.0, 200), SearchRow("b", 2.0, 10, 2.5, 150, 3.0, 100)])
    monkeypatch.setattr(searches, "measure_searches", lambda mesh, model: next(rows))
    done: list[str] = []
    mesh = make_mesh(*analytic.torus(8, 8))
    part = search_part([mesh, mesh], wide, done.append)
    assert "on 50% of the views, with 7.5% of its evaluations" in part.text
    assert part.rows[1] == ["a", "2.0000 (10)", "1.5000 (150)", "1.0000 (200)"]
    assert part.rows[0] == search_rows([])[0]
    assert len(done) == 2
    with pytest.raises(UsageError, match="no ranking module"):
        search_part([mesh], Model(Checkpoint(MICRO)), done.append)


def test_searches_are_of_a_model(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "-o", str(tmp_path / "out"), "--parts", "search"]) == 2
    assert capsys.readouterr().err == "ncontours: --parts: found search, expected a model beside it: --model FILE\n"
    assert not (tmp_path / "out").exists()
