"""3MF (.3mf): what a package says is to be built, with all components in their places.

Models in other parts of the package (the production extension), units and mirrored instances are read; z is up by
definition. Supports and modifiers are passed over.
"""

import io
import zipfile
import zlib
from collections.abc import Iterator
from xml.etree import ElementTree

import numpy as np

from ncmodel.readers.content import Content, Geometry, NotAMeshError, joined, placed
from ncmodel.readers.xml import parsed
from ncmodel.types import Floats

_MILLIMETRES = {
    "micron": 1e-3,
    "millimeter": 1.0,
    "centimeter": 10.0,
    "meter": 1e3,
    "inch": 25.4,
    "foot": 304.8,
}
_BUILT = ("model", "surface", "solidsupport")
_MOST_PARTS = 100_000
"""Components of components may be more than there is room for."""
_Z_UP = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])


def read_3mf(data: bytes) -> Content:
    """The items of a package's build, in millimetres, y up.

    Raises:
        NotAMeshError: It has no faces.
        ValueError: The file isn't a 3MF package, is damaged, or is encrypted.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as package:
            return _Package(package).content()
    except (zipfile.BadZipFile, zlib.error, EOFError, KeyError, TypeError, RuntimeError, NotImplementedError) as error:
        raise ValueError(f"damaged ({type(error).__name__}: {error})") from error


class _Package:
    """The models of a package, and the objects in them by part and id."""

    def __init__(self, package: zipfile.ZipFile) -> None:
        self.package = package
        self.models: dict[str, ElementTree.Element] = {}
        self.objects: dict[str, dict[str, ElementTree.Element]] = {}
        self.left_out = 0

    def content(self) -> Content:
        """All that is built, joined."""
        relations = parsed(self.package.read("_rels/.rels"))
        roots = [e.get("Target", "") for e in relations if e.get("Type", "").endswith("/3dmodel")]
        if not roots:
            raise ValueError("a package without a 3D model")
        root = roots[0]
        parts: list[Geometry] = []
        for item in self._model(root).iterfind("build/item"):
            for part in self._instances(item, root, _Z_UP):
                parts.append(part)
                if len(parts) > _MOST_PARTS:
                    raise ValueError(f"more than {_MOST_PARTS} parts")
        if not any(len(faces) for _, faces in parts):
            raise NotAMeshError("nothing with faces is built in it")
        notes = (f"{self.left_out} supports and modifiers are passed over",) if self.left_out else ()
        return Content(*joined(parts), notes)

    def _model(self, part: str) -> ElementTree.Element:
        if part not in self.models:
            model = parsed(self.package.read(part.lstrip("/")))
            self.models[part] = model
            self.objects[part] = {e.attrib["id"]: e for e in model.iterfind("resources/object")}
        return self.models[part]

    def _instances(self, reference: ElementTree.Element, part: str, above: Floats) -> Iterator[Geometry]:
        """The meshes that an item or a component stands for, where it puts them."""
        part = next((value for name, value in reference.items() if name.rpartition("}")[2] == "path"), part)
        model = self._model(part)
        named = self.objects[part][reference.attrib["objectid"]]
        if named.get("type", "model") not in _BUILT:
            self.left_out += 1
            return
        place = above @ _transform(reference)
        mesh = named.find("mesh")
        if mesh is not None:
            scale = _MILLIMETRES[model.get("unit", "millimeter")]
            vertices, faces = _mesh(mesh)
            # The numbers of a transform are in the model's unit, too.
            vertices, faces = placed((vertices, faces), place)
            yield vertices * scale, faces
        for component in named.iterfind("components/component"):
            yield from self._instances(component, part, place)


def _mesh(mesh: ElementTree.Element) -> Geometry:
    points = [float(e.attrib[axis]) for e in mesh.iterfind("vertices/vertex") for axis in "xyz"]
    corners = [int(e.attrib[name]) for e in mesh.iterfind("triangles/triangle") for name in ("v1", "v2", "v3")]
    vertices = np.array(points, dtype=np.float64).reshape(-1, 3)
    faces = np.array(corners, dtype=np.int64).reshape(-1, 3)
    if faces.size and not 0 <= faces.min() <= faces.max() < len(vertices):
        raise ValueError(f"faces use vertices {faces.min()}..{faces.max()}, the mesh has {len(vertices)}")
    return vertices, faces


def _transform(reference: ElementTree.Element) -> Floats:
    """(4, 4) of columns; the file has four rows of three numbers."""
    place = np.eye(4)
    if "transform" in reference.attrib:
        place[:3] = np.array(reference.attrib["transform"].split(), dtype=np.float64).reshape(4, 3).T
    return place
