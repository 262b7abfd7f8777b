"""Everything that decides what a data folder holds, as `config.toml` keeps it."""

from dataclasses import dataclass, field

from dataset_tools.candidates import Levels
from dataset_tools.clean import CleanSettings
from ncmodel.camera import DEFAULT_SIZE


@dataclass(frozen=True)
class BuildConfig:
    """The settings of a build.

    Attributes:
        views: Views of each shape.
        width: Pixels.
        height: Pixels.
        seed: Of the azimuths and the selection.
        up: Upward axis of the mesh files.
        min_faces: Shapes with fewer faces are skipped.
        duplicate_distance: Shapes whose surfaces are closer, in units of their radius, are one; 0 keeps all.
        render_size: Longer side of the pictures that participants see, pixels.
        render_azimuths: Where they are seen from, degrees around the view.
        levels: Of the candidates.
        clean: Tolerances and limits of cleaning.
    """

    views: int = 2
    width: int = DEFAULT_SIZE
    height: int = DEFAULT_SIZE
    seed: int = 0
    up: str = "y"
    min_faces: int = 2000
    duplicate_distance: float = 0.004
    render_size: int = 384
    render_azimuths: tuple[float, ...] = (-30.0, 0.0, 30.0)
    levels: Levels = field(default_factory=Levels)
    clean: CleanSettings = field(default_factory=CleanSettings)

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
        if self.up not in ("y", "z"):
            raise ValueError(f"up is {self.up!r}, expected y or z")

    @property
    def render_shape(self) -> tuple[int, int]:
        """(width, height) of the pictures that participants see."""
        scale = self.render_size / max(self.width, self.height)
        return round(scale * self.width), round(scale * self.height)
