"""Shapes as they are drawn: read, their seams sewn, their faces turned outwards; and what may be wrong with them."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from ncmodel.errors import UsageError
from ncmodel.mesh.load import load_mesh, make_mesh
from ncmodel.mesh.objects import as_mesh
from ncmodel.scene.orientation import turn_outwards
from ncmodel.scene.seams import sew_seams
from ncmodel.scene.stray_parts import stray_parts
from ncmodel.scene.surface import Surface
from ncmodel.scene.terraces import without_terraces
from ncmodel.scene.upright import looks_z_up
from ncmodel.tracing import timed
from ncmodel.types import Mesh, Trace


def surface_of(shape: Any, up: str = "y", eye: tuple[float, float, float] | None = None) -> Surface:
    """The surface of a shape as `draw` takes it, for several views.

    Args:
        shape: As `draw` takes it; a surface stays as it is.
        up: Likewise.
        eye: Where it is seen from, if a camera says so.

    Raises:
        MeshError: The file can't be read.
        UsageError: `up` stands beside what is in object space already.
    """
    if up != "y" and isinstance(shape, (Surface, Mesh)):
        found = f"{up!r} beside a {type(shape).__name__}, which is drawn as it is"
        raise UsageError(f"up: found {found}, expected what isn't in object space yet")
    if isinstance(shape, Surface):
        return shape
    trace = Trace()
    if isinstance(shape, Mesh):
        placed = make_mesh(shape.vertices, shape.faces, shape.name, shape.notes)
        mesh = replace(placed, millimetres=shape.millimetres) if eye is None else shape
    else:
        with timed(trace, "load"):
            mesh = load_mesh(shape, up) if isinstance(shape, (str, Path)) else as_mesh(shape, up)
    return without_terraces(turn_outwards(sew_seams(Surface(mesh, trace)), eye))


def hints(surface: Surface, shape: Any, up: str) -> tuple[str, ...]:
    """What may be wrong with a shape that is drawn without a camera; nothing of a surface, which its caller knows.

    Args:
        surface: Of the shape.
        shape: As `draw` takes it.
        up: Likewise.
    """
    if isinstance(shape, Surface):
        return ()
    with timed(surface.trace, "hints"):
        sideways = looks_z_up(surface.whole) if up == "y" and not isinstance(shape, Mesh) else ()
        return (*stray_parts(surface.whole), *sideways)
