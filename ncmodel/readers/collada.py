"""COLLADA (.dae): the polygons of a document's scene where its nodes put them, y up, in metres.

Read: triangles, polylists, polygons, strips and fans; transforms; shared nodes; the upward axis and the unit. Skins and
morphs are in the pose in which they are bound.
"""

from collections.abc import Iterator
from xml.etree import ElementTree

import numpy as np

from ncmodel.readers.content import METRE, Content, Geometry, NotAMeshError, joined, placed
from ncmodel.readers.numbers import numbers
from ncmodel.readers.triangulate import triangulate
from ncmodel.readers.xml import parsed
from ncmodel.types import Floats, Ints

Element = ElementTree.Element

_UPRIGHT = {
    "X_UP": np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]),
    "Y_UP": np.eye(3),
    "Z_UP": np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]),
}
_MOST_PARTS = 100_000
"""Nodes that are shared by shared nodes may be more than there is room for."""


def read_collada(data: bytes) -> Content:
    """What is in a document's scene.

    Raises:
        NotAMeshError: It has no faces.
        ValueError: The file isn't COLLADA or is damaged, or has polygons with holes.
    """
    root = parsed(data)
    if root.tag != "COLLADA":
        raise NotAMeshError(f"an XML document of another kind ({root.tag})")
    try:
        return _Document(root).content()
    except (KeyError, IndexError, TypeError, AttributeError, RecursionError) as error:
        raise ValueError(f"damaged ({type(error).__name__}: {error})") from error


class _Document:
    """A document's elements by their ids."""

    def __init__(self, root: Element) -> None:
        self.root = root
        self.named = {element.attrib["id"]: element for element in root.iter() if "id" in element.attrib}
        self.bound = 0

    def content(self) -> Content:
        """All geometry of the scene, joined."""
        axis = (self.root.findtext("asset/up_axis") or "Y_UP").strip()
        unit = self.root.find("asset/unit")
        place = np.eye(4)
        place[:3, :3] = _UPRIGHT[axis] * float("1" if unit is None else unit.get("meter", "1"))
        parts: list[Geometry] = []
        for scene in self.root.iterfind("scene/instance_visual_scene"):
            for node in self._target(scene, "url").iterfind("node"):
                for part in self._parts(node, place):
                    parts.append(part)
                    if len(parts) > _MOST_PARTS:
                        raise ValueError(f"more than {_MOST_PARTS} parts")
        if not parts:
            raise NotAMeshError("no faces in its scene")
        notes = (f"{self.bound} skins or morphs are in the pose in which they are bound",) if self.bound else ()
        return Content(*joined(parts), notes, METRE)

    def _target(self, element: Element, attribute: str) -> Element:
        """The element of the document that an attribute refers to."""
        url = element.attrib[attribute]
        if not url.startswith("#"):
            raise ValueError(f"it refers to {url!r}, outside of the file")
        return self.named[url[1:]]

    def _parts(self, node: Element, above: Floats) -> Iterator[Geometry]:
        """The geometry of a node and of those below it."""
        place = above @ _transform(node)
        for child in node:
            if child.tag == "node":
                yield from self._parts(child, place)
            elif child.tag == "instance_node":
                yield from self._parts(self._target(child, "url"), place)
            elif child.tag == "instance_geometry":
                yield from self._geometry(self._target(child, "url"), place)
            elif child.tag == "instance_controller":
                self.bound += 1
                yield from self._controlled(self._target(child, "url"), place)

    def _controlled(self, controller: Element, place: Floats) -> Iterator[Geometry]:
        """What a skin or a morph moves, where it is before that."""
        if controller.tag == "geometry":
            yield from self._geometry(controller, place)
            return
        skin, morph = controller.find("skin"), controller.find("morph")
        control = morph if skin is None else skin
        if control is None:
            raise ValueError("a controller that is neither skin nor morph")
        matrix = control.findtext("bind_shape_matrix")
        bound = np.eye(4) if matrix is None else numbers(matrix.encode()).reshape(4, 4)
        yield from self._controlled(self._target(control, "source"), place @ bound)

    def _geometry(self, geometry: Element, place: Floats) -> Iterator[Geometry]:
        """The faces of a geometry; its lines and splines are passed over."""
        mesh = geometry.find("mesh")
        if mesh is None:
            return
        for primitive in mesh:
            corners, sizes = _polygons(primitive)
            if len(sizes):
                vertices = self._positions(primitive)
                yield placed((vertices, triangulate(vertices, corners, sizes)), place)

    def _positions(self, primitive: Element) -> Floats:
        """(V, 3) the positions that a primitive's corners are taken from."""
        found = self._target(_input(primitive, "VERTEX"), "source")
        source = self._target(_input(found, "POSITION"), "source")
        accessor = source.find("technique_common/accessor")
        if accessor is None:
            raise ValueError("a source of positions without an accessor")
        values = numbers((self._target(accessor, "source").text or "").encode())
        first, stride, count = (int(accessor.get(name, usual)) for name, usual in _ACCESSOR.items())
        return np.stack([values[first + n :: stride][:count] for n in range(3)], axis=1)


_ACCESSOR = {"offset": "0", "stride": "1", "count": "0"}


def _input(element: Element, semantic: str) -> Element:
    for child in element.iterfind("input"):
        if child.get("semantic") == semantic:
            return child
    raise ValueError(f"{element.tag} without the input {semantic}")


def _polygons(primitive: Element) -> tuple[Ints, Ints]:
    """The corners of a primitive's polygons, and how many each has; none of what has no faces."""
    none = np.zeros(0, dtype=np.int64)
    if primitive.tag not in ("triangles", "polylist", "polygons", "tristrips", "trifans"):
        return none, none
    if primitive.find("ph") is not None:
        raise ValueError("polygons with holes, which aren't read")
    offset = int(_input(primitive, "VERTEX").get("offset", "0"))
    width = 1 + max(int(child.get("offset", "0")) for child in primitive.iterfind("input"))
    lists = [numbers((p.text or "").encode()).astype(np.int64)[offset::width] for p in primitive.iterfind("p")]
    if primitive.tag == "tristrips":
        lists = [strip[[n, n + 1 + n % 2, n + 2 - n % 2]] for strip in lists for n in range(len(strip) - 2)]
    elif primitive.tag == "trifans":
        lists = [fan[[0, n + 1, n + 2]] for fan in lists for n in range(len(fan) - 2)]
    corners = np.concatenate([none, *lists])
    if primitive.tag == "triangles":
        sizes = np.full(int(primitive.get("count", len(corners) // 3)), 3)
    elif primitive.tag == "polylist":
        sizes = numbers((primitive.findtext("vcount") or "").encode()).astype(np.int64)
    else:
        sizes = np.array([len(ring) for ring in lists], dtype=np.int64)
    if sizes.sum() != len(corners):
        raise ValueError(f"{len(corners)} corners for polygons of {sizes.sum()}")
    return corners, sizes


def _transform(node: Element) -> Floats:
    """(4, 4) from a node to the one above it: its transforms in their order."""
    place = np.eye(4)
    for child in node:
        step = np.eye(4)
        if child.tag not in ("matrix", "translate", "scale", "rotate", "lookat", "skew"):
            continue
        values = numbers((child.text or "").encode())
        if child.tag == "matrix":
            step = values.reshape(4, 4)
        elif child.tag == "translate":
            step[:3, 3] = values
        elif child.tag == "scale":
            step[:3, :3] = np.diag(values)
        elif child.tag == "rotate":
            step[:3, :3] = _rotation(values[:3], np.radians(values[3]))
        else:
            raise ValueError(f"a transform by {child.tag}, which isn't read")
        place = place @ step
    return place


def _rotation(axis: Floats, angle: float) -> Floats:
    """(3, 3) by Rodrigues' formula."""
    x, y, z = axis / (np.linalg.norm(axis) or 1.0)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)
