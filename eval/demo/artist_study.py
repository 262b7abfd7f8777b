"""How near simulated artists come to real ones: `python -m eval.demo.artist_study MESH_DIR`.

The figures of real artists are those of four drawings of two shapes.
"""

import itertools
import math
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, get_args

import numpy as np
import typer

from dataset_tools.artists.motif import Motif
from dataset_tools.candidates.viewpoints import camera_at, choose_azimuths
from dataset_tools.cleaning.repair import clean_file
from dataset_tools.simulation.artists import Artist, Kind, crowd_artists
from eval.baselines import rtsc
from eval.measures.evaluation import DEFAULT_TOLERANCE
from eval.measures.metrics import measure
from eval.measures.traits import Measured, Traits
from ncmodel.mesh.load import SUFFIXES
from ncmodel.report.text import text_table
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import FILTERED_FAMILIES, Image, LineFamily, Mask

SIDE = 768
"""Pixels of the drawings."""
FEW_CONTOURS = 0.25
"""Views with at most this share of inner ink along contours are like those of the real drawings."""

REAL = {
    "inner / outline": "1.0, 1.5, 1.0, 1.9",
    "stroke, mm": "19 to 49",
    "ink in strokes under 5 mm, %": "4 to 10",
    "apparent, %": "44 to 71",
    "ridges, %": "41 to 57",
    "suggestive, %": "28 to 53",
    "contours, %": "16 to 25",
    "valleys, %": "11 to 26",
    "none of them, %": "35",
    "F1, two artists": "47",
    "F1, two artists, few contours": "",
    "F1, one artist twice": "",
    "CPU seconds a drawing": "",
}
"""Figure -> what it is of real artists."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """A crowd's drawings of one view.

    Attributes:
        traits: One a drawing.
        others: F1 between the inner lines of two artists, one a pair.
        selves: F1 between two drawings by one artist, one an artist.
        seconds: CPU seconds a drawing.
    """

    traits: Sequence[Traits]
    others: Sequence[float]
    selves: Sequence[float]
    seconds: float


def measured(view: View) -> Measured:
    """What drawings of a view are measured with: the classic lines at rtsc's default thresholds."""
    thresholds = rtsc.plan(FILTERED_FAMILIES).thresholds
    lines = {f.value: rtsc.layer(view, f, thresholds.value(f) or 0.0) >= 0.5 for f in FILTERED_FAMILIES}
    outlines = np.maximum(rtsc.layer(view, LineFamily.CONTOURS), rtsc.layer(view, LineFamily.BOUNDARIES)) >= 0.5
    shape = view.buffers.hit
    own = Measured.of(shape, {}).band
    return Measured.of(shape, {**lines, LineFamily.CONTOURS.value: np.asarray(outlines & ~own)})


def draw_view(view: View, motif: Motif, artists: Sequence[Artist], by: Measured) -> Drawn:
    """Let a crowd draw a view, each artist twice."""
    begin = time.process_time()
    first = [by.inner(_draw(artist, motif, 0)) for artist in artists]
    again = [by.inner(_draw(artist, motif, 1)) for artist in artists]
    return Drawn(
        [by.traits(inner) for inner in first],
        [_agreement(a, b) for a, b in itertools.combinations(first, 2)],
        [_agreement(a, b) for a, b in zip(first, again, strict=True)],
        (time.process_time() - begin) / (2 * len(artists)),
    )


def figures(drawn: Sequence[Drawn]) -> dict[str, str]:
    """Figure -> its mean over all views; of what is an artist's own, its range over artists."""
    every = [traits for view in drawn for traits in view.traits]
    few = [view for view in drawn if _mean(t.along["contours"] for t in view.traits) <= FEW_CONTOURS]
    by_artist = [_mean(traits.inner for traits in artist) for artist in zip(*(v.traits for v in drawn), strict=True)]
    strokes = [_mean(traits.stroke for traits in view.traits) for view in drawn]
    low, high = np.percentile(strokes, [10, 90])
    along = {f"{name}, %": _percent(_mean(t.along[name] for t in every)) for name in every[0].along}
    return {
        "inner / outline": f"{_mean(by_artist):.2f} ({min(by_artist):.2f} to {max(by_artist):.2f})",
        "stroke, mm": f"{_mean(strokes):.0f} ({low:.0f} to {high:.0f})",
        "ink in strokes under 5 mm, %": _percent(_mean(traits.crumbs for traits in every)),
        **along,
        "none of them, %": _percent(_mean(traits.apart for traits in every)),
        "F1, two artists": _percent(_mean(f1 for view in drawn for f1 in view.others)),
        "F1, two artists, few contours": _percent(_mean(f1 for view in few for f1 in view.others)),
        "F1, one artist twice": _percent(_mean(f1 for view in drawn for f1 in view.selves)),
        "CPU seconds a drawing": f"{_mean(view.seconds for view in drawn):.2f}",
    }


def study(
    mesh_dir: Annotated[Path, typer.Argument(help="A folder of meshes.")],
    views: Annotated[int, typer.Option(help="Views of each.")] = 2,
) -> None:
    """Print what the simulated artists' drawings are like, beside real ones."""
    drawn: dict[Kind, list[Drawn]] = {kind: [] for kind in get_args(Kind)}
    for path in sorted(path for path in mesh_dir.iterdir() if path.suffix in SUFFIXES):
        mesh = clean_file(path)[0]
        surface = Surface(mesh)
        for azimuth in choose_azimuths(mesh.name, views):
            view = View(surface, camera_at(mesh, azimuth, (SIDE, SIDE)))
            motif, by = Motif(view), measured(view)
            for kind, found in drawn.items():
                found.append(draw_view(view, motif, crowd_artists(kind=kind), by))
        typer.echo(path.name, err=True)
    columns = {kind: figures(found) for kind, found in drawn.items()}
    rows = [[name, real, *(column[name] for column in columns.values())] for name, real in REAL.items()]
    typer.echo(text_table([["", "real", *columns], *rows]))


def _draw(artist: Artist, motif: Motif, time_of: int) -> Image:
    return artist.draw(motif, np.random.default_rng([artist.seed, time_of]))


def _agreement(first: Mask, second: Mask) -> float:
    return measure(first, second, DEFAULT_TOLERANCE).f1


def _mean(values: Iterable[float]) -> float:
    """Of the values that are numbers; not a number where none is."""
    numbers = [value for value in values if not math.isnan(value)]
    return math.fsum(numbers) / len(numbers) if numbers else math.nan


def _percent(value: float) -> str:
    return f"{100 * value:.0f}"


if __name__ == "__main__":
    typer.run(study)
