"""Make the pictures of the documentation, from meshes that pymeshlab bundles and two that are made here.

python docs/make_pictures.py [FOLDER]      FOLDER is docs/pictures unless given
"""

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ncmodel import Layout, draw_shape, draw_sheet, load_mesh, make_mesh
from ncmodel.images import Pixels, from_ink, write_png
from ncmodel.mesh.weld import weld
from ncmodel.report.contact_sheet import Tile, contact_sheet
from ncmodel.types import Floats, Image, LineFamily, Mesh

SIDE = 512
"""Pixels of a drawing before it is scaled down."""
THUMB = 240
"""Pixels of a drawing on a sheet."""
WIDTH = 4.0
"""Line width, at 768, of drawings that are to be scaled down: thinner lines would turn grey."""
CONTEXT = 0.3
"""Ink of the contours that show where a family's lines run."""
SHADES = 16
"""Grey levels of the pictures: lines need no more, and the files are half as large."""

LADDERS = {
    LineFamily.SUGGESTIVE: (0.001, 0.01, 0.1),
    LineFamily.RIDGES: (0.03, 0.1, 0.3),
    LineFamily.VALLEYS: (0.03, 0.1, 0.3),
    LineFamily.APPARENT: (0.01, 0.1, 1.0),
}
"""Family -> three thresholds, the default in the middle."""
CREASE_ANGLES = (20.0, 40.0)


def main(folder: Path) -> None:
    """Write all pictures."""
    folder.mkdir(parents=True, exist_ok=True)
    bunny, cow, airplane = (load_mesh(sample(name)) for name in ("bunny.obj", "cow.obj", "airplane.obj"))
    for family, ladder in LADDERS.items():
        tiles = [ladder_tile(mesh, family, threshold) for mesh in (bunny, cow) for threshold in ladder]
        save(folder / f"{family}.png", tiles, columns=3)
    save(folder / "contours.png", [tile(mesh, "contours", mesh.name) for mesh in (bunny, cow, airplane)])
    bowl = open_bowl()
    angles = (10.0, 40.0, -40.0)
    save(
        folder / "boundaries.png",
        [tile(bowl, "contours,boundaries", f"--elevation {angle:g}", elevation=angle) for angle in angles],
    )
    save(
        folder / "creases.png",
        [tile(prism(), "contours,creases", crease_caption(angle), crease_angle=angle) for angle in CREASE_ANGLES],
    )
    views = ((0.0, 0.0), (30.0, 30.0), (90.0, 0.0), (0.0, 89.0))
    save(
        folder / "views.png",
        [tile(cow, None, f"--azimuth {a:g} --elevation {e:g}", azimuth=a, elevation=e) for a, e in views],
    )
    write_png(folder / "sheet.png", views_sheet(airplane))


def views_sheet(mesh: Mesh) -> Pixels:
    """What `ncontours draw --views front,top,right,iso --size 800x600` draws."""
    return few_shades(from_ink(draw_sheet(mesh, Layout(("front", "top", "right", "iso"), size=(800, 600))).ink()))


def sample(name: str) -> Path:
    """The path of a mesh that pymeshlab bundles."""
    import pymeshlab

    return Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / name


def ladder_tile(mesh: Mesh, family: LineFamily, threshold: float) -> Tile:
    """A family's lines at a threshold, with contours in grey."""
    lines = draw_shape(mesh, lines=[family], thresholds={family.value: threshold}, size=SIDE)
    context = draw_shape(mesh, lines="contours", size=SIDE)
    ink: Image = np.maximum(lines.ink(WIDTH), CONTEXT * context.ink(WIDTH))
    default = " (default)" if threshold == LADDERS[family][1] else ""
    return Tile(from_ink(ink), f"{family}={threshold:g}{default}")


def tile(mesh: Mesh, lines: str | None, caption: str, **options: float) -> Tile:
    """A drawing; `options` are those of `draw_shape`."""
    drawing = draw_shape(mesh, lines=lines, size=SIDE, **options)  # type: ignore[arg-type]
    return Tile(from_ink(drawing.ink(WIDTH)), caption)


def crease_caption(angle: float) -> str:
    """What is under a picture of creases."""
    return f"--crease-angle {angle:g}" + (" (default)" if angle == CREASE_ANGLES[1] else "")


def lathe(radii: Floats, heights: Floats, around: int, name: str) -> Mesh:
    """A profile turned about the vertical axis, beginning on it below; where it doesn't end there, it is open."""
    angles, count = 2 * np.pi * np.arange(around)[:, None] / around, len(radii)
    rows = np.stack([radii * np.sin(angles), np.broadcast_to(heights, (around, count)), radii * np.cos(angles)], -1)
    corner = np.arange(around)[:, None] * count + np.arange(count - 1)
    beside = np.roll(corner, -1, axis=0)
    halves = [np.stack([corner, beside, corner + 1], -1), np.stack([beside, beside + 1, corner + 1], -1)]
    return make_mesh(*weld(rows.reshape(-1, 3), np.concatenate(halves).reshape(-1, 3)), name)


def open_bowl() -> Mesh:
    """The lower half of a sphere, open at the top."""
    polar = np.linspace(0.0, np.pi / 2, 24)
    return lathe(np.sin(polar), -np.cos(polar), 96, "bowl")


def prism() -> Mesh:
    """Twelve sides that meet at 30 degrees, and two flat ends at 90."""
    return lathe(np.array([0.0, 1.0, 1.0, 0.0]), np.array([-0.6, -0.6, 0.6, 0.6]), 12, "prism")


def save(path: Path, tiles: Sequence[Tile], columns: int | None = None) -> None:
    """Write a contact sheet in few shades of grey."""
    sheet = contact_sheet(tiles, columns or len(tiles), THUMB)
    write_png(path, few_shades(sheet[..., 0]))


def few_shades(grey: Pixels) -> Pixels:
    """(H, W) grey pixels rounded to `SHADES` levels."""
    step = 255 / (SHADES - 1)
    return np.asarray(np.rint(np.rint(grey / step) * step), dtype=np.uint8)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "pictures")
