"""glTF 2.0 (.gltf, .glb): the triangles of a scene where its nodes put them.

Read: buffers inside, beside (percent-encoded names, too) and as data URIs; strided, normalised and sparse accessors;
triangles, strips and fans, indexed or not; transforms; skins, in the pose of the file; morph targets, by their default
weights; visibility of nodes. Where nothing has faces, the points are those of a point cloud.
"""

import base64
import json
import os
import struct
from pathlib import Path
from typing import Any
from urllib.parse import unquote, unquote_to_bytes

import numpy as np
from numpy.typing import NDArray

from ncmodel.readers.content import METRE, Content, Geometry, NotAMeshError, joined, placed
from ncmodel.types import Floats, Ints

Record = dict[str, Any]

_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_POINTS, _TRIANGLES, _STRIP, _FAN = 0, 4, 5, 6
_VISIBILITY = "KHR_node_visibility"
_SPLATS = "KHR_gaussian_splatting"
_INSTANCES = "EXT_mesh_gpu_instancing"
_JSON, _BINARY = 0x4E4F534A, 0x004E4942
_MAGIC = b"glTF"


def read_gltf(path: Path, data: bytes) -> Content:
    """What is in a scene: the default one, or the first, or all nodes.

    Args:
        path: The file's, beside which its buffers lie.
        data: What is in it.

    Raises:
        NotAMeshError: It holds lines or Gaussian splats, and no faces.
        ValueError: The file isn't glTF 2.0, is damaged, lacks a buffer, or needs an extension that isn't read.
        OSError: A buffer can't be read.
    """
    try:
        return _Scene(path, data).content()
    except (KeyError, IndexError, TypeError, AttributeError, RecursionError, struct.error) as error:
        raise ValueError(f"damaged ({type(error).__name__}: {error})") from error


class _Scene:
    """A file's records, and its buffers when they are needed."""

    def __init__(self, path: Path, data: bytes) -> None:
        self.path = path
        self.inside, text, self.behind = _chunks(data) if path.suffix.lower() == ".glb" else (b"", data, 0)
        self.root: Record = json.loads(text)
        version = self.root["asset"]["version"]
        if not str(version).startswith("2."):
            raise ValueError(f"glTF {version}, where 2.0 is read")
        unread = [name for name in self.root.get("extensionsRequired", []) if "compression" in name]
        unread += [name for name in self.root.get("extensionsUsed", []) if name == _INSTANCES]
        if unread:
            raise ValueError(f"written with {unread[0]}, which isn't read")
        self.buffers: dict[int, bytes] = {}
        # Of primitives by their targets' weights: thousands of nodes may show the same mesh.
        self.shared: dict[tuple[int, tuple[float, ...]], Geometry] = {}

    def content(self) -> Content:
        """All meshes of the scene, joined."""
        self.placed, hidden = self._placements()
        found = [
            (primitive, index, self.root["meshes"][node["mesh"]])
            for index, node in ((index, self.root["nodes"][index]) for index in self.placed if index not in hidden)
            if "mesh" in node
            for primitive in self.root["meshes"][node["mesh"]]["primitives"]
        ]
        located = [parts for parts in found if "POSITION" in parts[0]["attributes"]]
        shown = [self._part(*parts) for parts in located]
        if any(len(faces) for _, faces in shown):
            shown = [part for part in shown if len(part[1])]
        else:
            shown = [part for part, (primitive, *_) in zip(shown, located, strict=True) if _is_cloud(primitive)]
            if located and not shown:
                splats = any(_is_splats(primitive) for primitive, *_ in located)
                raise NotAMeshError(f"{'Gaussian splats' if splats else 'lines'} and no faces")
        notes = [f"{len(hidden)} hidden nodes aren't drawn"] if hidden else []
        if len(located) < len(found):
            notes.append(f"{len(found) - len(located)} parts without positions are passed over")
        if self.behind:
            notes.append(f"a second file in it, of {self.behind} bytes, is passed over")
        return Content(*joined(shown), tuple(notes), METRE)

    def _placements(self) -> tuple[dict[int, Floats], set[int]]:
        """The (4, 4) transform of each node of the scene, and the nodes that are hidden, as all below them are."""
        nodes = self.root.get("nodes", [])
        scenes = self.root.get("scenes", [])
        if scenes:
            roots = scenes[self.root.get("scene", 0)].get("nodes", [])
        else:
            children = {child for node in nodes for child in node.get("children", [])}
            roots = [index for index in range(len(nodes)) if index not in children]
        placed: dict[int, Floats] = {}
        hidden: set[int] = set()
        waiting = [(index, np.eye(4)) for index in reversed(roots)]
        while waiting:
            index, above = waiting.pop()
            if index in placed:
                raise ValueError(f"node {index} has two places in the scene")
            placed[index] = above @ _transform(nodes[index])
            children_here = nodes[index].get("children", [])
            if index in hidden or not nodes[index].get("extensions", {}).get(_VISIBILITY, {}).get("visible", True):
                hidden.update((index, *children_here))
            waiting += [(child, placed[index]) for child in reversed(children_here)]
        return placed, hidden

    def _part(self, primitive: Record, index: int, mesh: Record) -> Geometry:
        """The vertices and faces of one primitive of a mesh, where its node puts them."""
        attributes, node = primitive["attributes"], self.root["nodes"][index]
        weights = tuple(node.get("weights", mesh.get("weights", [])))
        key = id(primitive), weights
        if key not in self.shared:
            self.shared[key] = self._geometry(primitive, weights)
        vertices, faces = self.shared[key]
        if "skin" in node and "JOINTS_0" in attributes:
            places = self._skin(attributes, self.root["skins"][node["skin"]])
            vertices = np.einsum("vij,vj->vi", places[:, :3, :3], vertices) + places[:, :3, 3]
            return vertices, faces
        return placed((vertices, faces), self.placed[index])

    def _geometry(self, primitive: Record, weights: tuple[float, ...]) -> Geometry:
        """The vertices and faces of a primitive, its targets weighted, before a node puts them anywhere."""
        vertices = self._accessor(primitive["attributes"]["POSITION"]).astype(np.float64)
        for weight, target in zip(weights, primitive.get("targets", []), strict=False):
            if weight and "POSITION" in target:
                vertices = vertices + weight * self._accessor(target["POSITION"])
        if "indices" in primitive:
            corners = self._accessor(primitive["indices"]).astype(np.int64).ravel()
        else:
            corners = np.arange(len(vertices))
        if len(corners) and corners.max() >= len(vertices):
            raise ValueError(f"faces use vertices 0..{corners.max()}, the mesh has {len(vertices)}")
        return vertices, _faces(corners, primitive.get("mode", _TRIANGLES))

    def _skin(self, attributes: Record, skin: Record) -> Floats:
        """(V, 4, 4) where a skin's joints put each vertex; its node's own place doesn't count."""
        joints = np.stack([self.placed[joint] for joint in skin["joints"]])
        if "inverseBindMatrices" in skin:
            joints = joints @ self._accessor(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
        numbers = self._accessor(attributes["JOINTS_0"]).astype(np.int64)
        weights = self._accessor(attributes["WEIGHTS_0"]).astype(np.float64)
        total = np.maximum(weights.sum(axis=1), 1e-12)
        return np.asarray(np.einsum("vk,vkij->vij", weights / total[:, None], joints[numbers]))

    def _accessor(self, index: int) -> NDArray[Any]:
        """(count, width) the numbers of an accessor; normalised integers as fractions."""
        accessor = self.root["accessors"][index]
        kind, count, width = np.dtype(_TYPES[accessor["componentType"]]), accessor["count"], _WIDTHS[accessor["type"]]
        if "bufferView" in accessor:
            values = self._view(accessor["bufferView"], kind, count, width, accessor.get("byteOffset", 0))
        else:
            values = np.zeros((count, width), kind)
        if "sparse" in accessor:
            sparse, values = accessor["sparse"], values.copy()
            at, new, some = sparse["indices"], sparse["values"], sparse["count"]
            numbers = np.dtype(_TYPES[at["componentType"]])
            rows = self._view(at["bufferView"], numbers, some, 1, at.get("byteOffset", 0)).ravel()
            values[rows] = self._view(new["bufferView"], kind, some, width, new.get("byteOffset", 0))
        if accessor.get("normalized") and kind.kind != "f":
            return np.maximum(values / np.iinfo(kind).max, -1.0)
        return values

    def _view(self, index: int, kind: np.dtype[Any], count: int, width: int, offset: int) -> NDArray[Any]:
        """(count, width) numbers of a part of a buffer."""
        view = self.root["bufferViews"][index]
        buffer, row = self._buffer(view["buffer"]), kind.itemsize * width
        first, stride = view.get("byteOffset", 0) + offset, view.get("byteStride", row)
        if count < 0 or first < 0 or stride < row or (count and first + stride * (count - 1) + row > len(buffer)):
            raise ValueError(f"the data end after {len(buffer)} bytes")
        return np.ndarray((count, width), kind, buffer, first, (stride, kind.itemsize))

    def _buffer(self, index: int) -> bytes:
        if index not in self.buffers:
            uri = self.root["buffers"][index].get("uri")
            self.buffers[index] = self.inside if uri is None else _fetched(uri, self.path)
        return self.buffers[index]


def _chunks(data: bytes) -> tuple[bytes, bytes, int]:
    """The binary and the JSON chunk of a .glb file, and how many bytes of another one lie behind it."""
    if data[:4] != _MAGIC:
        raise ValueError("no glTF header")
    version, at = struct.unpack_from("<I", data, 4)[0], 12
    if version != 2:
        raise ValueError(f"glTF {version}, where 2.0 is read")
    found: dict[int, bytes] = {}
    while at + 8 <= len(data) and data[at : at + 4] != _MAGIC:
        length, kind = struct.unpack_from("<II", data, at)
        found.setdefault(kind, data[at + 8 : at + 8 + length])
        at += 8 + length
    # Chunks are padded to four bytes, by blanks as they should be or by zeros.
    behind = len(data) - at if data[at : at + 4] == _MAGIC else 0
    return found.get(_BINARY, b""), found[_JSON].rstrip(b"\0"), behind


def beside(uri: str, model: Path) -> Path:
    """The file that a URI of a model names, in the model's folder, as a mesh has no business in other places.

    The file may be a link. Stores of data sets keep files under their checksums, and link models and buffers to them:
    where the model's own link leads, and in the folder that holds both ends of that, its buffers may lie, too.

    Raises:
        ValueError: It isn't there.
    """
    folder = model.parent.resolve()
    path = Path(os.path.normpath(folder / unquote(uri)))
    # Where model and link have nothing in common but the root of all, only the two folders themselves count.
    stored = model.resolve().parent
    common = Path(os.path.commonpath([folder, stored]))
    allowed = [folder, stored] if common == Path(common.anchor) else [common]
    inside = path.is_relative_to(folder) and any(path.resolve().is_relative_to(place) for place in allowed)
    if not inside or (path.exists() and not path.is_file()):
        raise ValueError(f"its buffer {uri!r} is no file in the folder of the mesh")
    return path


def _fetched(uri: str, model: Path) -> bytes:
    """What a URI names: a file beside, or itself."""
    if not uri.startswith("data:"):
        try:
            return beside(uri, model).read_bytes()
        except OSError as error:
            raise ValueError(f"its buffer {uri!r} can't be read ({error.strerror})") from error
    head, _, content = uri.partition(",")
    return base64.b64decode(content) if head.endswith(";base64") else unquote_to_bytes(content)


def _is_splats(primitive: Record) -> bool:
    names = (*primitive.get("extensions", {}), *primitive["attributes"])
    return any(name.startswith(_SPLATS) for name in names)


def _is_cloud(primitive: Record) -> bool:
    """Whether a primitive without faces holds points of a surface."""
    return primitive.get("mode", _TRIANGLES) == _POINTS and not _is_splats(primitive)


def _transform(node: Record) -> Floats:
    """(4, 4) from a node to the one above it."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    place = np.eye(4)
    place[:3, :3] = turn * np.array(node.get("scale", (1.0, 1.0, 1.0)), dtype=np.float64)
    place[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return place


def _faces(corners: Ints, mode: int) -> Ints:
    """(F, 3) the triangles of a primitive; none of points and lines."""
    if mode == _TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    if mode not in (_STRIP, _FAN) or len(corners) < 3:
        return np.zeros((0, 3), dtype=np.int64)
    if mode == _FAN:
        return np.stack([np.full(len(corners) - 2, corners[0]), corners[1:-1], corners[2:]], axis=1)
    faces = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    faces[1::2] = faces[1::2][:, [1, 0, 2]]
    i, j, k = faces.T
    return np.asarray(faces[(i != j) & (j != k) & (k != i)])
