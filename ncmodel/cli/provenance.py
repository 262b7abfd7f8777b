"""How a drawing was made, as its file says it: the mesh, the options, the camera, the thresholds, the version.

`ncontours draw --again FILE` reads it and draws the same once more.
"""

import hashlib
import json
import re
from dataclasses import dataclass, fields
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args, get_type_hints

from ncmodel.cli.draw_options import DrawOptions
from ncmodel.errors import InputError
from ncmodel.parsing import parse_json

if TYPE_CHECKING:
    from ncmodel.camera import Camera
    from ncmodel.drawing.plan import Plan

_EXPECTED = "an .svg or .pdf file that ncontours draw has written"


@dataclass(frozen=True)
class Provenance:
    """How a drawing was made.

    Attributes:
        mesh: The mesh file, from the drawing's folder.
        checksum: SHA-256 of its contents.
        options: How it was drawn.
        camera: Through what.
    """

    mesh: str
    checksum: str
    options: DrawOptions
    camera: "Camera"

    def text(self, plan: "Plan") -> str:
        """As JSON, with the thresholds that the drawing has."""
        defaults = DrawOptions()
        given = {field.name: getattr(self.options, field.name) for field in fields(DrawOptions)}
        record = {
            "program": f"neural-contours {version('neural-contours')}",
            "mesh": self.mesh,
            "sha256": self.checksum,
            "options": {name: _plain(value) for name, value in given.items() if value != getattr(defaults, name)},
            "camera": json.loads(self.camera.to_json()),
            "thresholds": {name: _plain(value) for name, value in plan.filtered.items()},
        }
        return json.dumps(record, separators=(",", ":"))


def checksum(path: Path) -> str:
    """SHA-256 of a file's contents."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def provenance(path: Path) -> Provenance:
    """How a drawing's file says that it was made.

    Raises:
        InputError: It says nothing, or what can't be read.
    """
    from ncmodel.camera import Camera

    try:
        record: Any = parse_json(_record(path))
        known = get_type_hints(DrawOptions)
        options = {name: _typed(value, known[name]) for name, value in record["options"].items()}
        camera = Camera.of_record(path, record["camera"])
        return Provenance(str(record["mesh"]), str(record["sha256"]), DrawOptions(**options), camera)
    except OSError as error:
        raise InputError(path, f"can't be read ({error.strerror})", _EXPECTED) from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(path, f"nothing that tells how it was drawn ({error})", _EXPECTED) from error


def _record(path: Path) -> str:
    """The record in a file.

    Raises:
        ValueError: There is none.
    """
    from ncmodel.readers.xml import parsed

    data = path.read_bytes()
    if path.suffix.lower() == ".svg":
        text = parsed(data).findtext("metadata")
    else:
        found = re.search(rb"/NeuralContours \(((?:[^()\\]|\\.)*)\)", data)
        text = None if found is None else re.sub(r"\\(.)", r"\1", found[1].decode("ascii"))
    if not text:
        raise ValueError("no record")
    return text


def _plain(value: Any) -> Any:
    """As JSON has it; None for what it has no word for."""
    if isinstance(value, float) and value in (float("inf"), float("-inf")):
        return None
    return str(value) if isinstance(value, Path) else value


def _typed(value: Any, expected: Any) -> Any:
    """A value of an option of that type.

    Raises:
        ValueError: It has another one.
    """
    kinds = get_args(expected) or (expected,)
    if isinstance(value, str) and Path in kinds:
        return Path(value)
    if not isinstance(value, tuple(kind for kind in kinds if kind is not type(None))):
        if isinstance(value, int) and float in kinds:
            return float(value)
        raise ValueError(f"{value!r}")
    return value
