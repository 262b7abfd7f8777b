"""Everything that decides what a data folder holds, as `config.toml` keeps it."""

from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from fnmatch import fnmatch

from dataset_tools.candidates.candidates import CandidateThresholds
from dataset_tools.cleaning.repair import CleanSettings
from ncmodel.camera import DEFAULT_SIZE
from ncmodel.limits import Limits
from ncmodel.readers.formats import Y_UP_SUFFIXES

UPWARD = ("y", "z")


@dataclass(frozen=True)
class TaskLimits:
    """What one shape may take before it is failed; they don't change what a data folder holds.

    Attributes:
        clean_seconds: Cleaning one mesh.
        view_seconds: Making one view.
        memory_gb: Either of them.
    """

    clean_seconds: float = 300.0
    view_seconds: float = 300.0
    memory_gb: float = 8.0

    def __post_init__(self) -> None:
        if min(self.clean_seconds, self.view_seconds, self.memory_gb) <= 0:
            found = f"{self.clean_seconds} s, {self.view_seconds} s and {self.memory_gb} GB"
            raise ValueError(f"limits are {found}, expected positive numbers")

    @property
    def clean(self) -> Limits:
        """Of cleaning one mesh."""
        return Limits(self.clean_seconds, self.memory_gb)

    def making(self, views: int) -> Limits:
        """Of making some views of one shape."""
        return Limits(self.view_seconds * views, self.memory_gb)


@dataclass(frozen=True)
class BuildConfig:
    """The settings of a build.

    Attributes:
        views: Views of each shape.
        width: Pixels.
        height: Pixels.
        seed: Of the azimuths and the selection.
        up: Upward axis of the mesh files.
        up_rules: Other axes for some of them, "PATTERN=AXIS" on paths below the mesh folder; the last one that fits
            counts.
        min_faces: Shapes with fewer faces are skipped.
        duplicate_distance: Shapes whose surfaces are closer, in units of their radius, are one; 0 keeps all.
        render_size: Longer side of the pictures that participants see, pixels.
        render_azimuths: Where they are seen from, degrees around the view.
        levels: Of the candidates.
        clean: Tolerances of cleaning.
        limits: Of time and memory.
    """

    views: int = 2
    width: int = DEFAULT_SIZE
    height: int = DEFAULT_SIZE
    seed: int = 0
    up: str = "y"
    up_rules: tuple[str, ...] = ()
    min_faces: int = 2000
    duplicate_distance: float = 0.004
    render_size: int = 384
    render_azimuths: tuple[float, ...] = (-30.0, 0.0, 30.0)
    levels: CandidateThresholds = field(default_factory=CandidateThresholds)
    clean: CleanSettings = field(default_factory=CleanSettings)
    limits: TaskLimits = field(default_factory=TaskLimits)

    def __post_init__(self) -> None:
        if self.views < 1 or self.min_faces < 0 or self.seed < 0:
            raise ValueError(
                f"views {self.views}, min_faces {self.min_faces}, seed {self.seed}: expected 1, 0, 0 or more"
            )
        if min(self.width, self.height, self.render_size) < 16:
            raise ValueError(
                f"pictures of {self.width} x {self.height} and {self.render_size}, expected 16 pixels or more"
            )
        if self.duplicate_distance < 0:
            raise ValueError(f"duplicate_distance is {self.duplicate_distance}, expected 0 or more")
        if self.up not in UPWARD:
            raise ValueError(f"up is {self.up!r}, expected y or z")
        for rule in self.up_rules:
            if rule.rpartition("=")[2] not in UPWARD or not rule.rpartition("=")[0]:
                raise ValueError(f"up_rules has {rule!r}, expected PATTERN=y or PATTERN=z")

    @property
    def render_shape(self) -> tuple[int, int]:
        """(width, height) of the pictures that participants see."""
        scale = self.render_size / max(self.width, self.height)
        return round(scale * self.width), round(scale * self.height)

    def upward(self, path: str) -> str:
        """The upward axis of a mesh file, by its path below the mesh folder: a rule's, its format's, or `up`."""
        axis = "y" if path.lower().endswith(Y_UP_SUFFIXES) else self.up
        for rule in self.up_rules:
            pattern, _, ruled = rule.rpartition("=")
            axis = ruled if fnmatch(path, pattern) else axis
        return axis

    def differences(self, earlier: "BuildConfig") -> Iterator[str]:
        """The settings that make data differ, as "NAME is BEFORE; expected NOW" has them.

        Limits don't, and rules decide shape by shape: what they change is made again.
        """
        for item in fields(self):
            if item.name not in ("limits", "up_rules") and getattr(self, item.name) != getattr(earlier, item.name):
                yield item.name
