"""Rows of measures, one a view of each surface, and their means."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields
from typing import TypeVar

from ncmodel.camera import Camera
from ncmodel.scene.surface import Surface

VIEWS = ((30.0, 20.0), (110.0, -10.0), (200.0, 45.0), (285.0, 5.0), (340.0, 75.0))
"""Azimuth and elevation, degrees."""


@dataclass(frozen=True)
class ViewRow:
    """What is measured of one view; the measures are fields of its own.

    Attributes:
        shape: Its name.
        azimuth: Degrees.
        elevation: Degrees.
    """

    shape: str
    azimuth: float
    elevation: float

    @classmethod
    def measures(cls) -> tuple[str, ...]:
        """The names of the measures."""
        return tuple(field.name for field in fields(cls) if field not in fields(ViewRow))


Row = TypeVar("Row", bound=ViewRow)


def measure_views(
    kind: type[Row],
    measure: Callable[[Surface, Camera], tuple[float, ...]],
    surfaces: Iterable[Surface],
    advance: Callable[[str], None],
    views: Sequence[tuple[float, float]],
    size: int,
) -> list[Row]:
    """Measure every surface from every view.

    Args:
        kind: Of the rows.
        measure: Gives the measures of a surface from a camera, in the order of the row's fields.
        surfaces: What to look at.
        advance: Called after each surface.
        views: Azimuth and elevation, degrees.
        size: Side of the pictures, pixels.
    """
    found = []
    for surface in surfaces:
        for azimuth, elevation in views:
            camera = Camera.orbit(surface.mesh.used_vertices, azimuth, elevation, size=(size, size))
            found.append(kind(surface.mesh.name, azimuth, elevation, *measure(surface, camera)))
        advance(surface.mesh.name)
    return found


def mean_rows(found: Sequence[Row]) -> list[Row]:
    """One row a shape, the means over its views, and one over all shapes; none of none."""
    if not found:
        return []
    by_shape = {shape: [row for row in found if row.shape == shape] for shape in dict.fromkeys(r.shape for r in found)}
    means = [_mean(shape, mine) for shape, mine in by_shape.items()]
    return [*means, _mean("mean", means)]


def _mean(shape: str, rows: Sequence[Row]) -> Row:
    kind = type(rows[0])
    means = (math.fsum(getattr(row, name) for row in rows) / len(rows) for name in kind.measures())
    return kind(shape, math.nan, math.nan, *means)
