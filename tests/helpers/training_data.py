"""A made-up data folder: views of blobs, eight drawings each, and votes that follow a known rule.

A drawing is the blob's outline plus a number of inner strokes; the "participants" like the drawing whose number of
strokes is nearest to what the view's shading calls for. So the best drawing can be told neither by its index nor by its
amount of ink alone.
"""

import json
from pathlib import Path

import cv2
import numpy as np

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.types import Floats, Image
from tests.helpers.mesh_files import as_ply
from tests.helpers.views import bumpy

SIDE = 96
STROKES = (0, 1, 2, 4, 6, 9, 13, 18)


def make_data(root: Path, shapes: int, views: int = 2, held_out: int = 0, seed: int = 0, side: int = SIDE) -> Path:
    """Write DATA_DIR/views and DATA_DIR/pairs.jsonl; return the latter's path."""
    rng = np.random.default_rng(seed)
    lines = []
    for shape in range(shapes):
        for view in range(views):
            best = write_view(root / "views" / f"s{shape:03d}_{view}", rng, side)
            split = "validation" if shape < held_out else "train"
            for worse in (index for index in range(8) if index != best):
                record = {"shape": f"s{shape:03d}", "view": view, "better": best, "worse": worse}
                lines.append(json.dumps({**record, "votes_for": 2, "votes": 3, "split": split}))
    path = root / "pairs.jsonl"
    path.write_text("\n".join(lines) + "\n")
    return path


def add_meshes(root: Path) -> None:
    """A mesh for every shape of a made-up data folder, for what needs one; the views' pictures don't show it."""
    data = DataFolder(root)
    for number, shape in enumerate(sorted({Item.named(path.name).shape for path in data.views_folder.iterdir()})):
        data.shape_folder(shape).mkdir(parents=True)
        data.mesh_path(shape).write_bytes(as_ply(*bumpy(frequency=9.0 + number)))


def write_view(folder: Path, rng: np.random.Generator, side: int = SIDE) -> int:
    """Write one view folder; return the index of the drawing that people would choose."""
    (folder / "drawings").mkdir(parents=True)
    wanted = int(rng.choice([2, 6]))
    height, inside = blob(rng, side, bumps=wanted)
    depth = np.where(inside, 0.6 - 0.4 * height, 1.0)
    write_png16(folder / "depth.png", depth)
    rows, columns = np.gradient(height * side / 4)
    shade = np.where(inside, 1 / np.sqrt(1 + rows**2 + columns**2), 1.0)
    for level in range(6):
        smooth = cv2.GaussianBlur(shade, (0, 0), 0.1 + 0.01 * side * level)
        write_png16(folder / f"shaded_{level}.png", np.where(inside, smooth, 1.0))
    camera = {
        "eye": [0, 0, 3],
        "target": [0, 0, 0],
        "up": [0, 1, 0],
        "width": side,
        "height": side,
        "focal_pixels": side,
    }
    (folder / "camera.json").write_text(json.dumps(camera))
    order = rng.permutation(8)
    for index, kind in enumerate(order):
        ink = draw_strokes(inside, STROKES[kind], rng)
        cv2.imwrite(str(folder / "drawings" / f"{index}.png"), np.rint(255 * (1 - ink)).astype(np.uint8))
    distance = [abs(STROKES[kind] - wanted) for kind in order]
    return int(np.argmin(distance))


def blob(rng: np.random.Generator, side: int, bumps: int) -> tuple[Floats, Image]:
    """Height field in 0..1 and mask of a random blob with some bumps on it."""
    v, u = (np.mgrid[:side, :side] + 0.5) / side * 2 - 1
    a, b, turn = rng.uniform(0.45, 0.8), rng.uniform(0.45, 0.8), rng.uniform(0, np.pi)
    x, y = u * np.cos(turn) + v * np.sin(turn), v * np.cos(turn) - u * np.sin(turn)
    inside = (x / a) ** 2 + (y / b) ** 2 < 1
    height = np.sqrt(np.clip(1 - (x / a) ** 2 - (y / b) ** 2, 0, 1)) * 0.7
    for _ in range(bumps):
        at = rng.uniform(-0.45, 0.45, 2)
        height = height + 0.3 * np.exp(-((u - at[0]) ** 2 + (v - at[1]) ** 2) / 0.01)
    return np.clip(height, 0, 1), inside


def draw_strokes(inside: Image, count: int, rng: np.random.Generator) -> Floats:
    """Ink of the mask's outline and of some arcs inside it."""
    side = inside.shape[0]
    canvas = np.zeros(inside.shape, np.uint8)
    outline, _ = cv2.findContours(inside.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    cv2.drawContours(canvas, outline, -1, 255, 1, cv2.LINE_AA)
    for _ in range(count):
        centre = (rng.uniform(0.3, 0.7, 2) * side).astype(int)
        axes = (rng.uniform(0.05, 0.2, 2) * side).astype(int) + 1
        start = float(rng.uniform(0, 360))
        cv2.ellipse(canvas, centre.tolist(), axes.tolist(), start, 0, 150, 255, 1, cv2.LINE_AA)
    return canvas / 255.0


def write_png16(path: Path, levels: Floats) -> None:
    cv2.imwrite(str(path), np.rint(np.clip(levels, 0, 1) * 65535).astype(np.uint16))
