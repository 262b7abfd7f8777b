"""A small data folder for the crowd's tests: real geometry on small pictures, or drawings without any."""

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import trimesh

from dataset_tools.votes.votes import Vote, read_votes
from ncmodel.camera import Camera
from ncmodel.data.item import DRAWINGS
from ncmodel.images import from_brightness, from_ink, write_png
from ncmodel.types import Image

SIZE = 96


def make_data(folder: Path, shapes: int = 12, views: int = 2, renders: int = 3, size: int = SIZE) -> Path:
    """A data folder whose candidates are scribbles, and whose meshes are bumpy boxes and balls."""
    for number in range(shapes):
        shape = f"shape_{number}"
        mesh = trimesh.creation.box() if number % 2 else trimesh.creation.icosphere(subdivisions=2, radius=0.5)
        mesh.vertices = mesh.vertices * [1.0, 0.4 + 0.05 * number, 0.7]
        (folder / "shapes" / shape).mkdir(parents=True)
        mesh.export(folder / "shapes" / shape / "mesh.ply")
        for view in range(views):
            _make_view(
                folder / "views" / f"{shape}_{view}", np.asarray(mesh.vertices), 100 * number + view, renders, size
            )
    return folder


def _make_view(folder: Path, vertices: np.ndarray, seed: int, renders: int, size: int) -> None:
    rng = np.random.default_rng(seed)
    (folder / "drawings").mkdir(parents=True)
    (folder / "renders").mkdir()
    camera = Camera.orbit(vertices, azimuth=float(rng.uniform(0, 360)), size=(size, size))
    (folder / "camera.json").write_text(camera.to_json())
    (folder / "selection.json").write_text(json.dumps({"medoids": rng.permutation(264)[:8].tolist()}))
    for index in range(DRAWINGS):
        write_png(folder / "drawings" / f"{index}.png", from_ink(scribble(rng, index + 2, size)))
    for index in range(renders):
        write_png(folder / "renders" / f"{index}.png", from_brightness(rng.random((size, size))))


def vote_rows(path: Path) -> list[Any]:
    """The votes in a file as named tuples, with None for what is missing."""
    votes = read_votes(path)
    return list(votes.astype(object).where(votes.notna(), None).itertuples(index=False, name="Row"))


def scribble(rng: np.random.Generator, lines: int, size: int = SIZE) -> Image:
    """(H, W) ink of random lines."""
    ink = np.zeros((size, size), dtype=np.float32)
    for _ in range(lines):
        ends = rng.integers(0, size, 4).tolist()
        cv2.line(ink, (ends[0], ends[1]), (ends[2], ends[3]), 1.0, 2, cv2.LINE_AA)
    return ink


def make_artists(folder: Path, data: Path, each: int = 1) -> Path:
    """A folder of artists' drawings of all views of a data folder."""
    for number, view in enumerate(sorted((data / "views").iterdir())):
        (folder / view.name).mkdir(parents=True)
        for index in range(each):
            rng = np.random.default_rng([number, index, 5])
            write_png(folder / view.name / f"{index}.png", from_ink(scribble(rng, 6)))
    return folder


def vote(worker: str, shape: str, choice: int, **more: object) -> Vote:
    """A participant's answer about a shape's one view."""
    values: dict[str, object] = {
        "worker": worker, "assignment": f"a-{worker}", "questionnaire": "q", "question": 1, "shape": shape, "view": "0",
        "choice": choice, "sentinel": False, "passed": None, "seconds": 5.0, "source": "mturk",
    }  # fmt: skip
    return Vote(**{**values, **more})  # type: ignore[arg-type]
