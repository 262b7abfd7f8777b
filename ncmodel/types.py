"""The plain types that the whole project hands along, and its conventions.

Conventions, stated once:

* Ink is a float in [0, 1], 1 = line, 0 = paper; PNG files show it as black on white. Images are (H, W), row 0 on top,
  pixel centres at +0.5.
* Depth is 0 near .. 1 far, background 1. Angles are radians inside, degrees at the command line.
* Object space: the longest bounding-box side is 1, the box centre is the origin, +y is up.
* Thresholds are dimensionless, as rtsc's (multiplied by powers of the feature size), or in units of the 90th percentile
  of a feature map where the neural model is concerned; `Thresholds.unit` says which.
* Score: higher is a better drawing. Ranking pairs are (better, worse).

Letters in array shapes: V vertices, F faces, S segments, H rows, W columns, K channels.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Image = NDArray[np.float32]
Mask = NDArray[np.bool_]


class LineFamily(StrEnum):
    """The eight families of lines, by the names used in files and at the command line."""

    CONTOURS = "contours"
    BOUNDARIES = "boundaries"
    CREASES = "creases"
    INTERSECTIONS = "intersections"
    SUGGESTIVE = "suggestive"
    RIDGES = "ridges"
    VALLEYS = "valleys"
    APPARENT = "apparent"


FILTERED_FAMILIES = (LineFamily.SUGGESTIVE, LineFamily.RIDGES, LineFamily.VALLEYS, LineFamily.APPARENT)
"""The families that a threshold filters, in the order of t = (t_S, t_R, t_V, t_A)."""

LENGTHS = {LineFamily.SUGGESTIVE: 2, LineFamily.RIDGES: 1, LineFamily.VALLEYS: 1, LineFamily.APPARENT: 2}
"""The power of the feature size that makes a family's feature dimensionless."""

HIDDEN_GROUP = "hidden"
"""The layer of lines behind the surface, of whatever family."""

SUGGESTIVE_FADE = 0.03
"""rtsc's fade of suggestive contours: alpha is 1/2 this far above the threshold (docs/geometry.md 7)."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh in object space.

    Attributes:
        vertices: (V, 3) float64.
        faces: (F, 3) int64 vertex indices, counter-clockwise seen from outside.
        name: What to call the shape in messages and file names.
        notes: What the reader did on the way (normalised, triangulated, reconstructed from points, ...).
        millimetres: The longest side of its bounding box by the file; None if nothing tells it.
    """

    vertices: Floats
    faces: Ints
    name: str = "mesh"
    notes: tuple[str, ...] = ()
    millimetres: float | None = None

    def __post_init__(self) -> None:
        if self.vertices.ndim != 2 or self.vertices.shape[1] != 3:
            raise ValueError(f"vertices have shape {self.vertices.shape}, expected (V, 3)")
        if self.faces.ndim != 2 or self.faces.shape[1] != 3:
            raise ValueError(f"faces have shape {self.faces.shape}, expected (F, 3)")
        if len(self.faces) and (self.faces.min() < 0 or self.faces.max() >= len(self.vertices)):
            raise ValueError(
                f"faces use vertices {self.faces.min()}..{self.faces.max()}, the mesh has {len(self.vertices)}"
            )

    @property
    def used_vertices(self) -> Floats:
        """(U, 3) the vertices that faces use: a stray one far away must not decide how large the shape is."""
        used = np.zeros(len(self.vertices), dtype=np.bool_)
        used[self.faces] = True
        return self.vertices if used.all() else self.vertices[used]


Unit = Literal["rtsc", "p90", "published"]
"""What a threshold is measured in: rtsc's dimensionless strength, the 90th percentile of a feature map, or rtsc's
strength as the published code has it, from features that count as at most their 90th percentile."""


@dataclass(frozen=True)
class Threshold:
    """How strong a family's lines must be to be drawn.

    Attributes:
        value: At least 0, in `unit`; an infinite one leaves no line.
        unit: "rtsc": compared with `LineSet.strength`; "p90": t of the paper's equations 1-4; "published": compared
            with the strength that the published code gives lines.
        scale: What one of a "p90" threshold is: the 90th percentile of the family's feature map; and what makes
            features dimensionless in the unit "published".
        most: In the unit "published", the feature above which all count as this.
    """

    value: float
    unit: Unit = "rtsc"
    scale: float = 1.0
    most: float = math.inf

    def measured(self, lines: "LineSet") -> "LineSet":
        """The lines with features and scale as this threshold sees them."""
        if self.unit != "published" or lines.family not in FILTERED_FAMILIES:
            return lines
        return replace(lines, feature=np.minimum(lines.feature, self.most), scale=self.scale)

    def limit(self, lines: "LineSet") -> float:
        """The value of feature / denominator at which this makes lines vanish."""
        return self.value * self.scale if self.unit == "p90" else self.value / lines.scale


EVERYTHING = Threshold(0.0)
"""The threshold that leaves all lines there are, and the one of families that no threshold filters."""


@dataclass(frozen=True)
class Thresholds:
    """One threshold a filtered family; `None` leaves the family out.

    Attributes:
        suggestive: t_S, and so on.
        unit: Of all four.
        p90: In the units "p90" and "published", family -> the 90th percentile of its feature, where it is known.
        feature_size: In the unit "published", the length that makes features dimensionless.
    """

    suggestive: float | None = 0.01
    ridges: float | None = 0.1
    valleys: float | None = 0.1
    apparent: float | None = 0.1
    unit: Unit = "rtsc"
    p90: Mapping[LineFamily, float] = field(default_factory=dict)
    feature_size: float = 1.0

    families: ClassVar[tuple[LineFamily, ...]] = FILTERED_FAMILIES

    def value(self, family: LineFamily) -> float | None:
        """The number that `family` got; 0 for the families that have none."""
        value: float | None = getattr(self, family.value, 0.0)
        return value

    def of(self, family: LineFamily) -> Threshold | None:
        """The threshold of `family`, or None if it is left out.

        Raises:
            KeyError: It is in units of a 90th percentile that isn't known.
        """
        value = self.value(family)
        if value is None or family not in FILTERED_FAMILIES:
            return None if value is None else EVERYTHING
        if self.unit == "published":
            return Threshold(value, self.unit, self.feature_size ** LENGTHS[family], self.p90[family])
        return Threshold(value, self.unit, self.p90[family] if self.unit == "p90" else 1.0)

    def with_values(self, **values: float | None) -> Self:
        """A copy with some thresholds replaced."""
        return replace(self, **values)  # type: ignore[arg-type]


@dataclass(frozen=True, eq=False)
class Segments:
    """Straight pieces of lines with their opacity, in object space.

    Attributes:
        family: The family they belong to.
        points: (S, 2, 3) end points.
        alpha: (S, 2) opacity at the ends, in (0, 1].
        face: (S,) the face that each piece lies on.
    """

    family: LineFamily
    points: Floats
    alpha: Floats
    face: Ints

    def __len__(self) -> int:
        return len(self.points)


@dataclass(frozen=True, eq=False)
class LineSet:
    """All lines of one family on a mesh from one eye, at threshold 0. Thresholds only ever take away from it.

    Attributes:
        family: The family.
        points: (S, 2, 3) end points in object space.
        face: (S,) the face that each segment lies on (for boundaries and creases, one of the adjacent faces).
        feature: (S, 2) the quantity that the paper's equations 1-4 filter, at the ends: sin(theta) DwKr for suggestive
            contours, |k1| for ridges and valleys, q1 for apparent ridges, 1 for the others.
        denominator: (S, 2) n.v for suggestive contours, 1 for the others.
        scale: What makes feature / denominator dimensionless: fs^2, fs, fs^2, 1.
    """

    family: LineFamily
    points: Floats
    face: Ints
    feature: Floats
    denominator: Floats
    scale: float = 1.0

    def __len__(self) -> int:
        return len(self.points)

    @property
    def strength(self) -> Floats:
        """(S, 2) dimensionless strength that rtsc's thresholds are compared with (infinite where n.v = 0)."""
        if self.family not in FILTERED_FAMILIES:
            return np.ones_like(self.feature)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = self.scale * self.feature / self.denominator
        return np.where(np.isnan(ratio), 0.0, np.where(self.denominator == 0.0, np.inf, ratio))

    def take(self, keep: Mask | Ints) -> "LineSet":
        """The segments selected by a mask or by indices."""
        index = np.flatnonzero(keep) if keep.dtype == np.bool_ else keep
        # `take` is twice as fast as square brackets.
        return replace(
            self,
            points=self.points.take(index, axis=0),
            face=self.face.take(index),
            feature=self.feature.take(index, axis=0),
            denominator=self.denominator.take(index, axis=0),
        )

    def between(self, index: Ints, start: Floats, end: Floats) -> "LineSet":
        """Pieces of segments: piece i runs from `start[i]` to `end[i]` (in 0..1) along segment `index[i]`."""

        def cut(values: Floats) -> Floats:
            a, b = values[index, 0], values[index, 1]
            shape = (-1,) + (1,) * (a.ndim - 1)
            return np.stack([a + start.reshape(shape) * (b - a), a + end.reshape(shape) * (b - a)], axis=1)

        return replace(
            self,
            points=cut(self.points),
            face=self.face[index],
            feature=cut(self.feature),
            denominator=cut(self.denominator),
        )


@dataclass(frozen=True, eq=False)
class ViewBuffers:
    """What each pixel of a view sees, from one ray a pixel.

    Attributes:
        face: (H, W) int64 face index, -1 on the background.
        barycentric: (H, W, 3) float64 weights of the face's three corners; 0 on the background.
        depth: (H, W) float32, 0 near .. 1 far, background 1 (see `ncmodel.geometry.raycast`).
    """

    face: Ints
    barycentric: Floats
    depth: Image

    @property
    def hit(self) -> Mask:
        """(H, W) True where the object is seen."""
        return np.asarray(self.face >= 0)


@dataclass(frozen=True, eq=False)
class Stroke:
    """A polyline on the picture plane.

    Attributes:
        family: The family's name; "image" for lines that the image translation branch adds.
        points: (n, 2) pixel coordinates (u right, v down).
        alpha: (n,) opacity in [0, 1], linear between points.
        depth: (n,) distance in front of the camera plane; None for lines that don't come from the mesh.
        hidden: Whether it lies behind the surface.
    """

    family: str
    points: Floats
    alpha: Floats
    depth: Floats | None = None
    hidden: bool = False

    @property
    def group(self) -> str:
        """The layer of a drawing that it belongs to: its family's, or that of all hidden lines."""
        return HIDDEN_GROUP if self.hidden else self.family

    def moved(self, right: float, down: float) -> Self:
        """The same stroke elsewhere."""
        return replace(self, points=self.points + (right, down))

    def reversed(self) -> Self:
        """The same stroke, drawn from its other end."""
        depth = None if self.depth is None else self.depth[::-1]
        return replace(self, points=self.points[::-1], alpha=self.alpha[::-1], depth=depth)


@dataclass(frozen=True)
class Timing:
    """One stage of a computation and how long it took."""

    stage: str
    seconds: float


@dataclass
class Trace:
    """What was computed and how long each stage took, in the order the stages ended."""

    timings: list[Timing] = field(default_factory=list)

    def record(self, stage: str, seconds: float) -> None:
        """Add one finished stage."""
        self.timings.append(Timing(stage, seconds))

    def seconds(self) -> dict[str, float]:
        """Stage name -> total seconds."""
        total: dict[str, float] = {}
        for timing in self.timings:
            total[timing.stage] = total.get(timing.stage, 0.0) + timing.seconds
        return total
