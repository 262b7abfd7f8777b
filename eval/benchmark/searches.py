"""What choosing thresholds costs, and what it finds: the presets' searches beside the published schedule.

All of them maximise the same score: of the same ranking module, on the same view, without lines of the image branch.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial

import numpy as np

from ncmodel.camera import Camera
from ncmodel.errors import UsageError
from ncmodel.model.maps import line_maps, network_maps
from ncmodel.model.predictor import Model, Scored, as_seen
from ncmodel.model.score import DrawingScore
from ncmodel.model.threshold_search import BUDGETS, Budget, Optimum, ScoredDrawing
from ncmodel.nets.blocks import threads_for
from ncmodel.published.model import PublishedModel
from ncmodel.published.rendering import framed, published_view
from ncmodel.published.scoring import MOST, PublishedScore
from ncmodel.published.search import published_search
from ncmodel.report.part import Part
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import Floats, Mask, Mesh

PRESET = "balanced"
"""The preset that is compared."""


@dataclass(frozen=True)
class SearchRow:
    """One view, searched by the preset, by grid and climbs, and by the published schedule.

    Attributes:
        shape: Its name.
        score: That the preset's search reached.
        evaluations: Scores, with gradient or without, that it took.
        grid_score: That grid and climbs reached, which small ranking modules are searched with.
        grid_evaluations: That they took.
        published_score: That the published schedule reached.
        published_evaluations: That it took, all with gradient.
    """

    shape: str
    score: float
    evaluations: int
    grid_score: float
    grid_evaluations: int
    published_score: float
    published_evaluations: int


class Clamped:
    """A score as the published schedule asks for it: thresholds count as 0..`MOST`, boundaries aren't drawn.

    Args:
        drawing: The score.
    """

    def __init__(self, drawing: ScoredDrawing) -> None:
        self._drawing = drawing

    @property
    def present(self) -> Mask:
        """(4,) which families have lines."""
        return np.array([family.present for family in self._drawing.fading])

    def slope(self, thresholds: Floats) -> tuple[float, Floats]:
        """The score at one (4,) t, and its (4,) gradient, 0 where t is clamped."""
        score, gradient = self._drawing.slope(np.clip(thresholds, 0.0, MOST), False)
        return score, np.where((thresholds >= 0.0) & (thresholds <= MOST), gradient, 0.0)


def search_part(meshes: Sequence[Mesh], model: Model, advance: Callable[[str], None]) -> Part:
    """The searches on each mesh from the default view.

    Args:
        meshes: What to draw.
        model: With a ranking module.
        advance: Called after each mesh.

    Raises:
        UsageError: The model has no ranking module.
    """
    if model.checkpoint.ranker is None:
        raise UsageError("this model has no ranking module, whose score a search maximises")
    found = []
    for mesh in meshes:
        found.append(measure_searches(mesh, model))
        advance(mesh.name)
    reached = np.mean([row.score >= row.published_score for row in found])
    share = np.mean([row.evaluations / row.published_evaluations for row in found])
    text = (
        f"The score that each search reached on the default view, and in brackets how often it asked for one. The "
        f"preset {PRESET} reaches the published schedule's on {reached:.0%} of the views, with {share:.1%} of its "
        f"evaluations. Grid and climbs are what {PRESET} does with small ranking modules."
    )
    return Part("search", "Searches for thresholds", text, search_rows(found), [asdict(row) for row in found])


def search_rows(found: Sequence[SearchRow]) -> list[list[str]]:
    """The table, its head first."""
    return [
        ["shape", PRESET, "grid and climbs", "published schedule"],
        *(
            [
                row.shape,
                f"{row.score:.4f} ({row.evaluations})",
                f"{row.grid_score:.4f} ({row.grid_evaluations})",
                f"{row.published_score:.4f} ({row.published_evaluations})",
            ]
            for row in found
        ),
    ]


def measure_searches(mesh: Mesh, model: Model) -> SearchRow:
    """One mesh from the default view."""
    score_of = _scores_of(mesh, model)

    def search(budget: Budget | str) -> Optimum:
        return model.search(score_of, model.known_budget(budget))

    preset, grid = search(PRESET), search(BUDGETS[PRESET])
    ranker = model.checkpoint.ranker
    assert ranker is not None
    with threads_for(ranker.dims.width):
        published = published_search(Clamped(score_of(ranker)))
    return SearchRow(
        shape=mesh.name,
        score=preset.score,
        evaluations=preset.evaluations,
        grid_score=grid.score,
        grid_evaluations=grid.evaluations,
        published_score=published.score,
        published_evaluations=published.evaluations,
    )


def _scores_of(mesh: Mesh, model: Model) -> Scored:
    """Makes the score of the default view's drawings, as the model draws it."""
    camera, surface = Camera.orbit(mesh.used_vertices), Surface(mesh)
    if isinstance(model, PublishedModel):
        return partial(PublishedScore, view=published_view(View(surface, framed(camera))))
    seen, preset = as_seen(View(surface, camera)), model.checkpoint.preset
    maps, lines = network_maps(seen, preset.inputs, preset.percentile), line_maps(seen, percentile=preset.percentile)
    return partial(DrawingScore, maps=maps, lines=lines)
