"""A collection as a folder of references: pictures by name; meshes, cameras, silhouettes and provenance beside.

DIR/references/SHAPE_VIEW/ARTIST.png   black lines on white
DIR/meshes/SHAPE.*                     the mesh files as they are
DIR/cameras/SHAPE_VIEW.json            in object space
DIR/silhouettes/SHAPE_VIEW.png         what is seen of the mesh through the camera
DIR/references.json                    layout, licence, every drawing's file and checksum, every camera's origin
"""

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import Any

from eval.measures.references import INDEX, PARTS
from eval.people.collections import COLLECTIONS, PersonsDrawing
from eval.people.fitting import fit_drawing
from eval.people.opensketch_camera import camera_file, placed
from ncmodel.camera import Camera
from ncmodel.errors import InputError, NeuralContoursError
from ncmodel.files import write_bytes, write_text
from ncmodel.geometry.raycast import RayScene
from ncmodel.images import from_ink, png_ink, write_png
from ncmodel.mesh.load import SUFFIXES, load_mesh
from ncmodel.types import Image

FIT, GIVEN = "fit", "given"
"""What `cameras` may be in place of a folder: found by outlines, or those that the collection has."""


@dataclass(frozen=True)
class Wanted:
    """What goes with the pictures.

    Attributes:
        source: The collection.
        layout: Its layout.
        meshes: Folder of mesh files SHAPE.*, or `None`.
        cameras: A folder of camera files SHAPE_VIEW.json, `FIT`, `GIVEN` or `None`.
        licence: What the owner says of the licence; what is published by default.
    """

    source: Path
    layout: str
    meshes: Path | None = None
    cameras: str | None = None
    licence: str | None = None


@dataclass
class Written:
    """What was written.

    Attributes:
        drawings: Records of the pictures.
        cameras: SHAPE_VIEW -> where its camera is from.
        failures: One line for each view that couldn't be written.
        notes: What the reader should know.
    """

    drawings: list[dict[str, Any]] = field(default_factory=list)
    cameras: dict[str, dict[str, Any]] = field(default_factory=dict)
    failures: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def write_references(
    drawings: Sequence[PersonsDrawing], out: Path, wanted: Wanted, advance: Callable[[str], None]
) -> Written:
    """Write a collection's drawings as references.

    Args:
        drawings: In order of their names.
        out: The folder, new or of an earlier run.
        wanted: What goes with them.
        advance: Is told about every view.

    Raises:
        NeuralContoursError: No view could be written: what was wrong with the first.
    """
    written, errors = Written(), list[NeuralContoursError]()
    meshes = _meshes(wanted.meshes)
    for part in PARTS:
        (out / part).mkdir(parents=True, exist_ok=True)
    for name, group in groupby(drawings, key=lambda drawing: drawing.name):
        same = list(group)
        try:
            _write_view(same, out, wanted, meshes.get(same[0].shape), written)
        except NeuralContoursError as error:
            errors.append(error)
            written.failures.append(f"{name}: {error}")
        else:
            advance(name)
    if not written.drawings:
        raise errors[0]
    if not written.cameras:
        written.notes.append("no mesh and camera is known: no silhouettes to take away")
    write_text(out / INDEX, json.dumps(_record(written, wanted), indent=1, ensure_ascii=False) + "\n")
    return written


def _write_view(
    drawings: Sequence[PersonsDrawing], out: Path, wanted: Wanted, mesh: Path | None, written: Written
) -> None:
    """All drawings of one view, with its camera and silhouette."""
    first = drawings[0]
    inks = {drawing: _checked(drawing, wanted.layout) for drawing in drawings}
    camera: Camera | None = None
    if mesh is not None and wanted.cameras is not None:
        camera, origin, inks = _camera(drawings, inks, mesh, wanted)
        sizes = {ink.shape for ink in inks.values()}
        if sizes != {(camera.height, camera.width)}:
            found = ", ".join(f"{width} x {height}" for height, width in sorted(sizes))
            raise InputError(
                first.source, f"pictures of {found}", f"{camera.width} x {camera.height}, as the camera has"
            )
        written.cameras[first.name] = origin
    for name, (drawing, ink) in zip(_file_names(drawings), inks.items(), strict=True):
        path = out / "references" / first.name / name
        path.parent.mkdir(exist_ok=True)
        write_bytes(path, png_ink(ink))
        written.drawings.append(_drawing_record(drawing, path.relative_to(out), wanted.source))
    if mesh is not None:
        write_bytes(out / "meshes" / f"{first.shape}{mesh.suffix.lower()}", mesh.read_bytes())
    if mesh is not None and camera is not None:
        write_text(out / "cameras" / f"{first.name}.json", camera.to_json() + "\n")
        seen = RayScene(load_mesh(mesh)).render(camera).hit
        write_png(out / "silhouettes" / f"{first.name}.png", from_ink(seen))


def _camera(
    drawings: Sequence[PersonsDrawing], inks: dict[PersonsDrawing, Image], mesh: Path, wanted: Wanted
) -> tuple[Camera, dict[str, Any], dict[PersonsDrawing, Image]]:
    """A view's camera, where it is from, and its drawings as that camera frames them."""
    first = drawings[0]
    if wanted.cameras == FIT:
        found = fit_drawing(load_mesh(mesh), first.source, ink=inks[first])
        return found.camera, {"from": f"fitted to {first.artist}'s outline", **found.to_record()}, inks
    if wanted.cameras == GIVEN:
        if wanted.layout != "opensketch" or first.strokes is None:
            lacking = f"{GIVEN}, and no public page tells of cameras in the layout {wanted.layout}"
            raise InputError(wanted.source, lacking, "a folder of camera files, or cameras that are fitted")
        path = camera_file(wanted.source, first.artist, first.shape, first.view[-1])
        view = placed(first.strokes(), path, mesh)
        return view.camera, {"from": path.relative_to(wanted.source).as_posix()}, {first: view.drawing.ink()}
    path = Path(str(wanted.cameras)) / f"{first.name}.json"
    return Camera.load(path), {"from": str(path)}, inks


def _checked(drawing: PersonsDrawing, layout: str) -> Image:
    ink, size = drawing.read(), COLLECTIONS[layout].size
    if size is not None and ink.shape[::-1] != size:
        found = f"{ink.shape[1]} x {ink.shape[0]} pixels"
        raise InputError(drawing.source, found, f"{size[0]} x {size[1]}, as the registered scans of {layout} have")
    return ink


def _meshes(folder: Path | None) -> Mapping[str, Path]:
    """Shape -> mesh file."""
    if folder is None:
        return {}
    if not folder.is_dir():
        raise InputError(
            folder, "is a file" if folder.exists() else "doesn't exist", "a folder of meshes, SHAPE.* each"
        )
    return {path.stem: path for path in sorted(folder.rglob("*")) if path.suffix.lower() in SUFFIXES}


def _file_names(drawings: Sequence[PersonsDrawing]) -> Iterator[str]:
    """ARTIST.png, numbered where an artist drew a view several times."""
    seen: dict[str, int] = {}
    for drawing in drawings:
        count = seen[drawing.artist] = seen.get(drawing.artist, 0) + 1
        yield f"{drawing.artist}.png" if count == 1 else f"{drawing.artist}-{count}.png"


def _drawing_record(drawing: PersonsDrawing, path: Path, source: Path) -> dict[str, Any]:
    return {
        "name": drawing.name,
        "shape": drawing.shape,
        "view": drawing.view,
        "artist": drawing.artist,
        "file": path.as_posix(),
        "source": drawing.source.relative_to(source).as_posix(),
        "sha256": hashlib.sha256(drawing.source.read_bytes()).hexdigest(),
    }


def _record(written: Written, wanted: Wanted) -> dict[str, Any]:
    collection = COLLECTIONS[wanted.layout]
    return {
        "layout": wanted.layout,
        "title": collection.title,
        "page": collection.page,
        "licence": wanted.licence or collection.licence,
        "drawings": written.drawings,
        "cameras": written.cameras,
        "failures": written.failures,
        "notes": written.notes,
    }
