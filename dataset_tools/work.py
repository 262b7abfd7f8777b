"""The work of a build that runs in its workers: cleaning one shape, making the views of one shape."""

import json
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from dataset_tools.candidates import draw_candidates
from dataset_tools.chamfer import chamfer_matrix
from dataset_tools.clean_one import CleanTask, cleaned
from dataset_tools.encode import npz, png_ink, png_map, png_pixels
from dataset_tools.renders import shaded_picture
from dataset_tools.select import select
from dataset_tools.settings import BuildConfig
from dataset_tools.store import Store, ViewStatus
from dataset_tools.views import camera_at, choose_azimuths
from ncmodel.camera import Camera
from ncmodel.errors import InputError
from ncmodel.geometry.mesh import load_mesh
from ncmodel.geometry.surface import Surface
from ncmodel.geometry.view import View
from ncmodel.stages import timed
from ncmodel.types import Mesh


@dataclass(frozen=True)
class ShapeTask:
    """The views of one shape that are to be made."""

    root: str
    name: str
    views: tuple[int, ...]
    config: BuildConfig


def clean_shape(task: CleanTask) -> bool:
    """Clean one shape into the data folder."""
    store = Store(task.root)
    store.write_folder(store.shape_folder(task.name), cleaned(task), task.sha256)
    return True


def make_views(task: ShapeTask) -> list[ViewStatus]:
    """Make views of one shape; what depends on the shape alone is computed once."""
    store = Store(task.root)
    mesh = store.mesh_checksum(task.name)
    surface: Surface | None = None
    outcomes = []
    for view in task.views:
        begin = time.perf_counter()
        try:
            if surface is None:
                surface = Surface(load_shape(store, task.name))
            files = view_files(surface, view, task.config)
        except MemoryError:
            raise  # the limit's; whoever set it says so
        except Exception as error:  # whatever a strange shape makes the numbers do, the others go on
            outcomes.append(ViewStatus(task.name, view, "failed", f"{type(error).__name__}: {error}"))
            continue
        store.write_folder(store.view_folder(task.name, view), files, mesh)
        outcomes.append(ViewStatus(task.name, view, "done", "", time.perf_counter() - begin))
    return outcomes


def load_shape(store: Store, name: str) -> Mesh:
    """The cleaned mesh of a shape, under the shape's name.

    Raises:
        MeshError: There is none.
    """
    return replace(load_mesh(store.shape_folder(name) / "mesh.ply"), name=name)


def load_view(folder: Path, size: tuple[int, int] | None = None) -> View:
    """A view of a data folder, ready to be drawn.

    Args:
        folder: DATA_DIR/views/SHAPE_VIEW.
        size: (width, height) to see it at; its own by default.

    Raises:
        InputError: It isn't such a folder.
    """
    shape, _, number = folder.resolve().name.rpartition("_")
    if not shape or not number.isdigit():
        raise InputError(folder, "a name that isn't SHAPE_VIEW", "a folder DATA_DIR/views/SHAPE_VIEW")
    camera = Camera.load(folder / "camera.json")
    mesh = load_shape(Store(folder.resolve().parents[1]), shape)
    return View(Surface(mesh), camera.resized(*size) if size else camera)


def view_files(surface: Surface, number: int, config: BuildConfig) -> dict[str, bytes]:
    """All files of a view's folder.

    Args:
        surface: The shape.
        number: Which of its views.
        config: The settings.
    """
    azimuth = choose_azimuths(surface.mesh.name, number + 1, config.seed)[number]
    camera = camera_at(surface.mesh, azimuth, (config.width, config.height))
    view = View(surface, camera)
    candidates = draw_candidates(view, config.levels)
    with timed(view.trace, "chamfer"):
        distances = chamfer_matrix(candidates.masks, candidates.members)
    with timed(view.trace, "select"):
        selection = select(distances, seed=config.seed)
    files = {"camera.json": (camera.to_json() + "\n").encode()}
    with timed(view.trace, "encode maps"):
        files["depth.png"] = png_map(view.depth)
        files |= {f"shaded_{level}.png": png_map(image) for level, image in enumerate(view.shaded)}
    with timed(view.trace, "encode candidates"):
        shape = np.array([len(candidates.specs), config.height, config.width])
        files["candidates.npz"] = npz(ink=candidates.packed(), shape=shape)
        specs = [spec.to_record(index) for index, spec in enumerate(candidates.specs)]
        files["candidates.json"] = (json.dumps(specs) + "\n").encode()
        files["selection.json"] = (json.dumps(selection.to_record()) + "\n").encode()
    with timed(view.trace, "encode drawings"):
        for place, index in enumerate(selection.medoids.tolist()):
            files[f"drawings/{place}.png"] = png_ink(candidates.drawing(index))
    with timed(view.trace, "renders"):
        for place, aside in enumerate(config.render_azimuths):
            turned = camera_at(surface.mesh, azimuth + aside, config.render_shape)
            files[f"renders/{place}.png"] = png_pixels(shaded_picture(surface, turned))
    return files
