"""`ncontours draw --maps` and `ncontours score --maps`: folders of maps in place of meshes."""

import math
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ncmodel.cli.common import emit
from ncmodel.errors import UsageError

if TYPE_CHECKING:
    from ncmodel.published.pictures import PictureDrawing


@dataclass(frozen=True)
class MapsJob:
    """What is asked of a folder of maps.

    Attributes:
        maps: The folder, or an .npz file that `ncontours dataset import` wrote.
        output: The file to write.
        style: Line width and background.
        options: As `draw_maps` takes them.
    """

    maps: Path
    output: Path
    style: dict[str, Any]
    options: dict[str, Any]

    def run(self, as_json: bool) -> None:
        """Draw and write."""
        from ncmodel.export.files import PICTURES, check_output
        from ncmodel.published.folder import read_maps
        from ncmodel.published.pictures import draw_maps

        check_output(self.output, PICTURES)
        begin = time.perf_counter()
        drawing = draw_maps(read_maps(self.maps), **self.options)
        drawing.save(self.output, **self.style)
        emit(self._record(drawing, time.perf_counter() - begin), as_json)

    def _record(self, drawing: "PictureDrawing", seconds: float) -> dict[str, Any]:
        plan, (height, width) = drawing.plan, drawing.ink.shape
        values = {name: None if t is None or math.isinf(t) else t for name, t in plan.filtered.items()}
        return {
            "maps": str(self.maps),
            "output": str(self.output),
            "width": width,
            "height": height,
            "families": [family.value for family in plan.drawn],
            "thresholds": values,
            "threshold_unit": plan.thresholds.unit,
            "score": plan.score,
            "score_evaluations": plan.evaluations,
            "seconds_total": seconds,
        }


def alone(maps: Path, **others: object) -> None:
    """Check that nothing is given beside a folder of maps that only a mesh has.

    Raises:
        UsageError: Something is.
    """
    given = [name for name, value in others.items() if value not in (None, [], False)]
    if given:
        raise UsageError(f"--maps: found {given[0]} beside {maps}, expected only the maps, which fix the view")
