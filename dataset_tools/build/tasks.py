"""The work of a build that runs in its workers: cleaning one shape, making the views of one shape."""

import json
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dataset_tools.build.config import BuildConfig
from dataset_tools.build.encoding import npz
from dataset_tools.build.store import Store, ViewStatus
from dataset_tools.candidates.candidates import draw_candidates
from dataset_tools.candidates.k_medoids import select
from dataset_tools.candidates.renders import shaded_picture
from dataset_tools.candidates.viewpoints import camera_at, choose_azimuths
from dataset_tools.cleaning.repair import CleanSettings, clean_file
from dataset_tools.cleaning.shape_distance import invariants
from ncmodel.camera import Camera
from ncmodel.chamfer import chamfer_matrix
from ncmodel.data.data_folder import MAPS
from ncmodel.data.item import Item
from ncmodel.errors import InputError
from ncmodel.images import png_ink, png_map, png_shaded
from ncmodel.readers.ply import ply_bytes
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.tracing import timed


@dataclass(frozen=True)
class CleanTask:
    """One shape to clean.

    Attributes:
        root: The data folder.
        source: The mesh file.
        place: Its path below the mesh folder, by which the shape's name is found again.
        sha256: Of its content, by which a file that was changed is told.
        name: The shape's name.
        up: The file's upward axis.
        min_faces: Shapes with fewer are skipped.
        settings: Tolerances.
    """

    root: str
    source: str
    place: str
    sha256: str
    name: str
    up: str
    min_faces: int
    settings: CleanSettings


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
    store.write_folder(store.shape_folder(task.name), clean_files(task), task.sha256)
    return True


def clean_files(task: CleanTask) -> dict[str, bytes]:
    """Clean a shape.

    Returns:
        The files of the shape's folder: `clean.json`, whose "status" is "done", "failed" or "skipped" with a
        "reason", and where it is done the mesh.
    """
    try:
        mesh, report = clean_file(task.source, task.up, task.settings)
    except InputError as error:
        return failed_files(task, f"{error.found}; expected {error.expected}")  # wherever the file lies, the same words
    except OSError as error:
        return failed_files(task, f"can't be read ({error.strerror})")
    if report.resolution < task.min_faces:
        reason = f"low resolution: {report.resolution} faces, expected at least {task.min_faces}"
        return {"clean.json": _record(task, "skipped", reason, **report.to_record())}
    moments = [float(f"{moment:.6g}") for moment in invariants(mesh)]
    record = _record(task, "done", "", **report.to_record(), invariants=moments)
    return {"clean.json": record, "mesh.ply": ply_bytes(mesh)}


def failed_files(task: CleanTask, reason: str) -> dict[str, bytes]:
    """The files of a shape that can't be made."""
    return {"clean.json": _record(task, "failed", reason)}


def _record(task: CleanTask, status: str, reason: str, **more: Any) -> bytes:
    source = {"source": Path(task.source).name, "place": task.place, "sha256": task.sha256, "up": task.up}
    settings = {name: getattr(task.settings, name) for name in ("weld", "snap", "remove_hidden", "support")}
    record = {"status": status, "reason": reason, **source, **more, "settings": settings}
    return (json.dumps(record, indent=1) + "\n").encode()


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
                surface = Surface(store.load_mesh(task.name))
            files = view_files(surface, view, task.config)
        except MemoryError:
            raise  # the limit's; whoever set it says so
        except Exception as error:  # whatever a strange shape makes the numbers do, the others go on
            outcomes.append(ViewStatus(task.name, view, "failed", f"{type(error).__name__}: {error}"))
            continue
        store.write_folder(store.view_folder(Item(task.name, str(view))), files, mesh)
        outcomes.append(ViewStatus(task.name, view, "done", "", time.perf_counter() - begin))
    return outcomes


def view_files(surface: Surface, number: int, config: BuildConfig) -> dict[str, bytes]:
    """All files of a view's folder.

    Args:
        surface: The shape.
        number: Which of its views.
        config: The settings.
    """
    azimuth = choose_azimuths(surface.mesh.name, number + 1, config.seed)[number]
    camera = camera_at(surface.mesh, azimuth, (config.width, config.height))
    aside = [camera_at(surface.mesh, azimuth + angle, config.render_shape) for angle in config.render_azimuths]
    return files_through(surface, camera, aside, config)


def files_through(surface: Surface, camera: Camera, aside: Sequence[Camera], config: BuildConfig) -> dict[str, bytes]:
    """All files of a view's folder.

    Args:
        surface: The shape.
        camera: Where it is drawn from.
        aside: The cameras of the pictures that participants see.
        config: The settings.
    """
    view = View(surface, camera)
    candidates = draw_candidates(view, config.levels)
    with timed(view.trace, "chamfer"):
        distances = chamfer_matrix(candidates.masks, candidates.members)
    with timed(view.trace, "select"):
        selection = select(distances, seed=config.seed)
    files = {"camera.json": (camera.to_json() + "\n").encode()}
    with timed(view.trace, "encode maps"):
        files |= {name: png_map(image) for name, image in zip(MAPS, (view.depth, *view.shaded), strict=True)}
    with timed(view.trace, "encode candidates"):
        shape = np.array([len(candidates.specs), camera.height, camera.width])
        files["candidates.npz"] = npz(ink=candidates.packed(), shape=shape)
        specs = [spec.to_record(index) for index, spec in enumerate(candidates.specs)]
        files["candidates.json"] = (json.dumps(specs) + "\n").encode()
        files["selection.json"] = (json.dumps(selection.to_record()) + "\n").encode()
    with timed(view.trace, "encode drawings"):
        for place, index in enumerate(selection.medoids.tolist()):
            files[f"drawings/{place}.png"] = png_ink(candidates.drawing(index))
    with timed(view.trace, "renders"):
        for place, turned in enumerate(aside):
            files[f"renders/{place}.png"] = png_shaded(shaded_picture(surface, turned))
    return files
