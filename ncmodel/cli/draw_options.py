"""What `ncontours draw` may be asked for, as one object; the command's options are its fields."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import wraps
from pathlib import Path
from typing import Annotated, Any

import typer

from ncmodel.errors import UsageError


@dataclass(frozen=True)
class DrawOptions:
    """How to draw, whatever the shape. What is None is left to the library's defaults."""

    camera: Annotated[Path | None, typer.Option(help="Camera file (JSON), not beside --azimuth, --elevation.")] = None
    azimuth: Annotated[float | None, typer.Option(help="Degrees round the shape from its front (default 30)")] = None
    elevation: Annotated[float | None, typer.Option(help="Degrees above the ground (default 30)")] = None
    view: Annotated[
        str | None,
        typer.Option(help="front, back, left, right, top, bottom or iso, in place of --azimuth and --elevation."),
    ] = None
    projection: Annotated[
        str | None,
        typer.Option(help="perspective or orthographic: along parallel lines (default perspective, or the camera's)."),
    ] = None
    views: Annotated[
        str | None,
        typer.Option(help="Such as front,top,right,iso: these views on one sheet, without perspective by default."),
    ] = None
    angle: Annotated[
        str | None, typer.Option(help="third or first: how --views lie on their sheet (default third).")
    ] = None
    page: Annotated[
        str | None,
        typer.Option(help="A4, letter, A3-landscape, 200x300mm, ...: paper that an .svg, .pdf or .dxf file is for."),
    ] = None
    margin: Annotated[
        str | None, typer.Option(help="Empty along the edges of a --page: 10mm, 0.5in, ... (default 10mm).")
    ] = None
    scale: Annotated[
        str | None, typer.Option(help="Size on a --page to real size, such as 1:2 (default as large as fits).")
    ] = None
    size: Annotated[str | None, typer.Option(help="N or WxH in pixels (default 768, or the camera's)")] = None
    lines: Annotated[
        str | None,
        typer.Option(
            help="Families, of contours,boundaries,creases,intersections,suggestive,ridges,valleys,apparent. "
            "(default all but ridges and valleys)"
        ),
    ] = None
    thresholds: Annotated[
        str | None, typer.Option(help="FAMILY=VALUE,... in rtsc's units (default suggestive=0.01, others 0.1)")
    ] = None
    detail: Annotated[
        float,
        typer.Option(help="Share of the lines inside the outline, most important first: 0 outline alone, 1 all lines."),
    ] = 1.0
    min_length: Annotated[
        float, typer.Option(help="Pixels, at 768; shorter strokes are left out, except the outline's.")
    ] = 0.0
    hidden: Annotated[
        str, typer.Option(help="none, dashed or layer: lines behind the surface, in a group of their own.")
    ] = "none"
    width: Annotated[
        float | None, typer.Option(help="Line width in pixels, at 768; lines grow with the picture (default 2.5).")
    ] = None
    background: Annotated[
        str | None, typer.Option(help="#rrggbb, white, black or transparent (default none; white in a .png)")
    ] = None
    colors: Annotated[
        bool, typer.Option("--colors", help="A pure colour for each family, and no fading: for pens and layers.")
    ] = False
    curves: Annotated[
        bool, typer.Option("--curves", help="Smooth curves in place of polylines, in .svg and .pdf files.")
    ] = False
    sort: Annotated[bool, typer.Option("--sort", help="Order strokes so that a plotter's pen travels little.")] = False
    tolerance: Annotated[
        float | None, typer.Option(help="Pixels that simplified strokes may be off (default the preset's, 0.25)")
    ] = None
    up: Annotated[str, typer.Option(help="The files' upward axis, y or z.")] = "y"
    crease_angle: Annotated[
        float | None, typer.Option(help="Degrees between faces above which their edge is a crease (default 40).")
    ] = None
    model: Annotated[
        Path | None, typer.Option(help="Checkpoint that chooses what to draw, or default: the one that ships.")
    ] = None
    variant: Annotated[
        str | None, typer.Option(help="full, geometry or image: the model's branches that take part (default all)")
    ] = None
    mode: Annotated[
        str | None,
        typer.Option(help="paper or published: whose way a model draws (default published for imported weights)"),
    ] = None
    preset: Annotated[
        str, typer.Option(help="instant, draft, balanced or accurate; matters with --model and in large pictures.")
    ] = "balanced"
    device: Annotated[str, typer.Option(help="Where the model computes: cpu, cuda, ...")] = "cpu"

    def __post_init__(self) -> None:
        turned = {"--azimuth": self.azimuth, "--elevation": self.elevation}
        if self.view is not None:
            refuse_beside("--view", {"--camera": self.camera, **turned})
        if self.camera is not None and any(value is not None for value in turned.values()):
            raise UsageError("--camera: found --azimuth or --elevation beside it, expected one or the other")
        if self.views is not None:
            refuse_beside("--views", {"--camera": self.camera, "--view": self.view, **turned})
        if self.page is not None:
            refuse_beside("--page", {"--size": self.size})
        alone = {"--angle": (self.angle, self.views, "--views")}
        alone |= {f"--{name}": (getattr(self, name), self.page, "--page") for name in ("margin", "scale")}
        for name, (value, other, needed) in alone.items():
            if value is not None and other is None:
                raise UsageError(f"{name}: found no {needed} beside it, expected both")

    @property
    def angles(self) -> tuple[float | None, float | None]:
        """Azimuth and elevation, those of a named view if there is one."""
        from ncmodel.camera import VIEWS

        if self.view is None:
            return self.azimuth, self.elevation
        if self.view not in VIEWS:
            raise UsageError(f"--view: found {self.view!r}, expected one of {', '.join(VIEWS)}")
        return VIEWS[self.view]


def refuse_beside(name: str, others: dict[str, object]) -> None:
    """Raise if an option stands beside one of some others.

    Raises:
        UsageError: One of them is given: not None.
    """
    beside = next((other for other, value in others.items() if value is not None), None)
    if beside is not None:
        raise UsageError(f"{name}: found {beside} beside it, expected one or the other")


def takes(settings: type[Any]) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command whose last parameter is a dataclass an option for each of that class's fields instead."""

    def decorate(function: Callable[..., None]) -> Callable[..., None]:
        *own, last = inspect.signature(function).parameters.values()
        names = [field.name for field in fields(settings)]

        @wraps(function)
        def command(**given: Any) -> None:
            chosen = {name: given.pop(name) for name in names if name in given}
            function(**given, **{last.name: settings(**chosen)})

        options = [
            inspect.Parameter(
                field.name, inspect.Parameter.POSITIONAL_OR_KEYWORD, default=field.default, annotation=field.type
            )
            for field in fields(settings)
        ]
        shown = [*own, *options]
        command.__signature__ = inspect.Signature(shown, return_annotation=None)  # type: ignore[attr-defined]
        command.__annotations__ = {one.name: one.annotation for one in shown}
        del command.__wrapped__  # its parameters aren't these
        return command

    return decorate
