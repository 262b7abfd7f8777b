"""Published collections of people's drawings, as their owners have them on disk: which drawing shows what, by whom.

What public pages and repositories tell of a layout is in its `Collection`; what they don't is asked for:

* Cole et al. 2008 ("Where do people draw lines?") and the paper's own extension: registered scans of 1024 x 768 whose
  names tell shape, view and artist in an order that no public page tells: `names`.
* DifferSketching (Xiao et al. 2022): CATEGORY/FOLDER/NAME.json or .png, on a canvas of 800; NAME begins with the
  participant (P.. professional, N.. novice), what else is in it is told nowhere: `names`.
* Tracing versus Freehand (Wang et al. 2021): png/GROUP/IMAGE&PARTICIPANT.png, svg/ alike, or GROUP.json alone, on 800.
* OpenSketch (Gryaditskaya et al. 2019): sketches_json_first_viewpoint/DESIGNER/OBJECT/view1_KIND.json.
* named: pictures of one's own, named as `names` says.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from eval.measures.references import PICTURES
from eval.measures.scans import read_lines
from eval.people.strokes import StrokeDrawing, differsketching, opensketch, polylines_of_svg, tracing_freehand
from ncmodel.errors import ArgumentError, InputError
from ncmodel.files import is_clutter
from ncmodel.types import Image

SCAN_SIZE = (1024, 768)
"""Of the registered scans of Cole et al. and of the paper's extension."""

_FIELDS = ("shape", "view", "artist")


@dataclass(frozen=True, eq=False)
class PersonsDrawing:
    """One drawing of a collection.

    Attributes:
        shape: What it shows.
        view: From where, as a name.
        artist: Who drew it.
        source: The file it is in.
        read: Reads its ink.
        strokes: Reads it as strokes, where the collection has them.
    """

    shape: str
    view: str
    artist: str
    source: Path
    read: Callable[[], Image]
    strokes: Callable[[], StrokeDrawing] | None = None

    @property
    def name(self) -> str:
        """SHAPE_VIEW, by which drawings are matched."""
        return f"{self.shape}_{self.view}"


@dataclass(frozen=True)
class Collection:
    """What is known of a collection.

    Attributes:
        title: What to cite.
        page: Where it is told of.
        licence: Its terms, as far as they are published.
        size: (width, height) that all pictures must have; any if `None`.
        groups: Names of the parts that one can choose, the default first; none if there is one part.
        needs_names: Whether `names` must say what is in a file's name.
        find: Its drawings.
    """

    title: str
    page: str
    licence: str
    find: "Callable[[Path, Asked], Iterator[PersonsDrawing]]"
    size: tuple[int, int] | None = None
    groups: tuple[str, ...] = ()
    needs_names: bool = True


@dataclass(frozen=True)
class Asked:
    """What only the owner can tell.

    Attributes:
        names: A file's name without its suffix, as "{shape}_{view}_{artist}"; {} stands for anything else.
        group: Which part of the collection.
    """

    names: str | None = None
    group: str | None = None

    def parts(self, path: Path) -> Mapping[str, str]:
        """Shape, view and artist of a file.

        Raises:
            InputError: Its name doesn't fit.
        """
        assert self.names is not None, "layouts that need names are asked for them"
        found = _pattern(self.names).fullmatch(path.stem)
        if found is None:
            raise InputError(path, f"the name {path.stem!r}", f"{self.names}, as was said of names")
        return {"view": "0", **found.groupdict()}


def find_drawings(source: Path, layout: str, asked: Asked) -> list[PersonsDrawing]:
    """All drawings of a collection, in order of their names.

    Raises:
        ArgumentError: There is no such layout or group, or names are missing or don't say what they must.
        InputError: The folder isn't in that layout.
    """
    if layout not in COLLECTIONS:
        raise ArgumentError("layout", repr(layout), f"one of {', '.join(COLLECTIONS)}")
    collection = COLLECTIONS[layout]
    if not source.is_dir():
        raise InputError(source, "is a file" if source.exists() else "doesn't exist", "the collection's folder")
    if collection.needs_names:
        _check_names(asked.names, layout)
    if asked.group is not None and collection.groups and asked.group not in collection.groups:
        raise ArgumentError("group", repr(asked.group), f"one of {', '.join(collection.groups)}")
    chosen = Asked(asked.names, asked.group or next(iter(collection.groups), None))
    found = sorted(collection.find(source, chosen), key=lambda drawing: (drawing.name, drawing.artist, drawing.source))
    if not found:
        raise InputError(source, "no drawing in it", f"the layout {layout}: {collection.title}")
    return found


def _check_names(names: str | None, layout: str) -> None:
    told = "no public page tells what is in its files' names" if layout != "named" else "names are your own"
    if names is None:
        raise ArgumentError("names", f"none, and {told}", 'one such as "{shape}_{view}_{artist}"')
    unknown = set(re.findall(r"\{(\w+)\}", names)) - set(_FIELDS)
    if unknown or not {"shape", "artist"} <= set(re.findall(r"\{(\w+)\}", names)):
        raise ArgumentError("names", repr(names), "{shape} and {artist} in it, {view} if there is one, {} for the rest")


def _pattern(names: str) -> re.Pattern[str]:
    """What a template such as "{shape}_{view}_{artist}" matches; a view and an artist hold no underscore."""
    parts = re.split(r"(\{\w*\})", names)
    fields = {"{}": ".*?", "{shape}": "(?P<shape>.+)", "{view}": "(?P<view>[^_]+)", "{artist}": "(?P<artist>[^_]+)"}
    return re.compile("".join(fields.get(part, re.escape(part)) for part in parts))


def _files(folder: Path, suffixes: tuple[str, ...]) -> Iterator[Path]:
    for path in sorted(folder.rglob("*")):
        clutter = any(is_clutter(part) for part in path.relative_to(folder).parts)
        if not clutter and path.suffix.lower() in suffixes and path.is_file():
            yield path


def _named(source: Path, asked: Asked) -> Iterator[PersonsDrawing]:
    for path in _files(source, PICTURES):
        parts = asked.parts(path)
        yield PersonsDrawing(parts["shape"], parts["view"], parts["artist"], path, _reader(path))


def _differsketching(source: Path, asked: Asked) -> Iterator[PersonsDrawing]:
    for folder in sorted(path for path in source.glob(f"*/{asked.group}") if path.is_dir()):
        for path in _files(folder, (".json", *PICTURES)):
            parts = asked.parts(path)
            shape = f"{folder.parent.name}-{parts['shape']}"
            if path.suffix.lower() == ".json":
                yield _of_strokes(shape, parts["view"], parts["artist"], path, differsketching)
            else:
                yield PersonsDrawing(shape, parts["view"], parts["artist"], path, _reader(path))


def _tracing_freehand(source: Path, asked: Asked) -> Iterator[PersonsDrawing]:
    for kind, suffixes in (("png", (".png",)), ("svg", (".svg",))):
        folder = source / kind / str(asked.group)
        if folder.is_dir():
            for path in _files(folder, suffixes):
                image, mark, participant = path.stem.rpartition("&")
                if not mark:
                    raise InputError(path, f"the name {path.stem!r}", "IMAGE&PARTICIPANT")
                if kind == "png":
                    yield PersonsDrawing(image, "0", participant, path, _reader(path))
                else:
                    yield _of_strokes(image, "0", participant, path, polylines_of_svg)
            return
    path = source / f"{asked.group}.json"
    if path.is_file():
        for image, drawings in tracing_freehand(path).items():
            for participant, drawing in drawings.items():
                shape = image.removesuffix(".png")
                yield PersonsDrawing(shape, "0", participant, path, drawing.ink, drawing.itself)


def _opensketch(source: Path, asked: Asked) -> Iterator[PersonsDrawing]:
    for number, which in ((1, "first"), (2, "second")):
        for path in sorted((source / f"sketches_json_{which}_viewpoint").glob(f"*/*/view{number}_{asked.group}.json")):
            if is_clutter(path.name):
                continue
            designer, shape = path.parts[-3], path.parts[-2]
            # Each designer chose where to stand: a view is one designer's.
            yield _of_strokes(shape, f"{designer}-view{number}", designer, path, opensketch)


def _of_strokes(
    shape: str, view: str, artist: str, path: Path, read: Callable[[Path], StrokeDrawing]
) -> PersonsDrawing:
    return PersonsDrawing(shape, view, artist, path, lambda: read(path).ink(), lambda: read(path))


def _reader(path: Path) -> Callable[[], Image]:
    return lambda: read_lines(path)


COLLECTIONS = {
    "cole2008": Collection(
        "Cole et al. 2008, Where Do People Draw Lines?",
        "https://gfx.cs.princeton.edu/proj/ld3d/",
        "not stated on public pages; ask its authors",
        _named,
        SCAN_SIZE,
    ),
    "extension": Collection(
        "Liu et al. 2020, Neural Contours: drawings of 44 more shapes",
        "https://github.com/DifanLiu/NeuralContours",
        "not stated on public pages; ask its authors",
        _named,
        SCAN_SIZE,
    ),
    "differsketching": Collection(
        "Xiao et al. 2022, DifferSketching: How Differently Do People Sketch 3D Objects?",
        "https://chufengxiao.github.io/DifferSketching/",
        "not stated on public pages; ask its authors",
        _differsketching,
        groups=("reg_json", "global_json", "stroke_json", "tracing"),
    ),
    "tracing-freehand": Collection(
        "Wang et al. 2021, Tracing Versus Freehand for Evaluating Computer-Generated Drawings",
        "https://github.com/zachzeyuwang/tracing-vs-freehand",
        "CC BY-NC-SA 4.0, for academic research only",
        _tracing_freehand,
        groups=("drawings_registered", "tracings", "drawings"),
        needs_names=False,
    ),
    "opensketch": Collection(
        "Gryaditskaya et al. 2019, OpenSketch: A Richly-Annotated Dataset of Product Design Sketches",
        "https://ns.inria.fr/d3/OpenSketch/",
        "as its page states; ask its authors before you pass it on",
        _opensketch,
        groups=("presentation", "concept"),
        needs_names=False,
    ),
    "named": Collection("drawings of your own", "", "yours", _named),
}
"""Layout -> what is known of it."""
