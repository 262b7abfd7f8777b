"""Small valid files of every kind that is read, made here."""

import io
import json
import struct
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

_CORNERS = np.array([[1.0, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]])
_FACES = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
_CAMERA = {"eye": [1, 2, 3], "target": [0, 0, 0], "up": [0, 1, 0], "width": 96, "height": 64, "focal_pixels": 120}


def _rows(rows: np.ndarray, before: str = "") -> str:
    return "".join(f"{before}{' '.join(map(str, row))}\n" for row in rows.tolist())


def _obj() -> list[bytes]:
    plain = _rows(_CORNERS, "v ") + _rows(_FACES + 1, "f ")
    rich = "mtllib a.mtl\no a\n" + _rows(_CORNERS, "v ") + "vt 0 0\nvn 0 0 1\ng b\nusemtl c\ns 1\n"
    rich += "".join(f"f {a}/1/1 {b}/1/1 {c}/1/1\n" for a, b, c in (_FACES - 4).tolist())
    return [plain.encode(), (rich + "f 1 2 \\\n 3 4\nl 1 2\n").encode()]


def _ply() -> list[bytes]:
    made = []
    for form in ("ascii", "binary_little_endian", "binary_big_endian"):
        header = f"ply\nformat {form} 1.0\ncomment made\nelement vertex 4\n"
        header += "".join(f"property float {axis}\n" for axis in "xyz")
        header += "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
        if form == "ascii":
            body = (_rows(_CORNERS) + _rows(_FACES, "3 ")).encode()
        else:
            order = "<" if "little" in form else ">"
            body = _CORNERS.astype(f"{order}f4").tobytes()
            body += b"".join(b"\3" + row.astype(f"{order}i4").tobytes() for row in _FACES)
        made.append(header.encode() + body)
    return made


def _stl() -> list[bytes]:
    text, binary = "solid a\n", bytes(80) + struct.pack("<I", len(_FACES))
    for face in _FACES:
        corners = "".join(f"vertex {x} {y} {z}\n" for x, y, z in _CORNERS[face].tolist())
        text += f"facet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\n"
        binary += bytes(12) + _CORNERS[face].astype("<f4").tobytes() + bytes(2)
    return [(text + "endsolid a\n").encode(), binary]


def _off() -> list[bytes]:
    plain = f"OFF\n4 4 0\n{_rows(_CORNERS)}{_rows(_FACES, '3 ')}"
    return [plain.encode(), plain.replace("OFF\n4", "OFF # made\n\n4").replace("3 0 1 2", "3 0 1 2 255 0 0").encode()]


def _gltf() -> tuple[bytes, bytes]:
    import base64

    data = _CORNERS.astype("<f4").tobytes() + _FACES.astype("<u2").tobytes()
    record = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0, "children": [2]}, {"mesh": 0, "translation": [3, 0, 0]}, {"mesh": 0, "scale": [2, 1, 1]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": 4}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "byteOffset": 0},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 24},
        ],
        "buffers": [{"byteLength": 72}],
    }
    text = json.dumps(record).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    uri = f"data:application/octet-stream;base64,{base64.b64encode(data).decode()}"
    alone = {**record, "buffers": [{"byteLength": 72, "uri": uri}]}
    return json.dumps(alone).encode(), struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _threemf(method: int) -> bytes:
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in _CORNERS.tolist())
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in _FACES.tolist())
    model = (
        '<?xml version="1.0"?><model unit="millimeter" '
        'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources><object id="1" type="model">'
        f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh></object>"
        '<object id="2"><components><component objectid="1" transform="1 0 0 0 1 0 0 0 1 5 0 0"/></components></object>'
        '</resources><build><item objectid="1"/><item objectid="2"/></build></model>'
    )
    relations = (
        '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Id="r" '
        'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel" Target="/3D/3dmodel.model"/>'
        "</Relationships>"
    )
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", method) as package:
        package.writestr("_rels/.rels", relations)
        package.writestr("3D/3dmodel.model", model)
    return made.getvalue()


def _collada() -> bytes:
    places = " ".join(map(str, _CORNERS.ravel().tolist()))
    ring = " ".join(map(str, _FACES.ravel().tolist()))
    return (
        '<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>'
        '<unit meter="0.01"/><up_axis>Y_UP</up_axis></asset><library_geometries><geometry id="g"><mesh><source id="s">'
        f'<float_array id="f" count="12">{places}</float_array><technique_common><accessor source="#f" count="4" '
        'stride="3"/></technique_common></source><vertices id="v"><input semantic="POSITION" source="#s"/></vertices>'
        '<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/>'
        f"<p>{ring}</p></triangles></mesh></geometry></library_geometries><library_visual_scenes>"
        '<visual_scene id="scene"><node><translate>1 2 3</translate><rotate>0 0 1 30</rotate>'
        '<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>'
        '<scene><instance_visual_scene url="#scene"/></scene></COLLADA>'
    ).encode()


def _votes() -> bytes:
    from dataset_tools.votes.votes import Vote, to_frame, write_votes

    votes = [
        Vote(
            f"w{n % 2}", f"a{n % 2}", "A", n + 1, "cow", "30", n % 9 - 1, n == 3, True if n == 3 else None, 2.5, "mturk"
        )
        for n in range(6)
    ]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "votes.csv")
        write_votes(path, to_frame(votes))
        return path.read_bytes()


def _results() -> bytes:
    answers = ",".join(f"Answer.q{n:02}" for n in range(1, 6))
    rows = "".join(
        f"w{n},a{n},Fri Nov 01 12:08:1{n} PDT 2019,60,A,Submitted,{','.join(f'v{n}{k}' for k in range(5))}\n"
        for n in range(4)
    )
    header = f"WorkerId,AssignmentId,SubmitTime,WorkTimeInSeconds,Input.questionnaire,AssignmentStatus,{answers}\n"
    return (header + rows).encode()


def _checkpoint() -> bytes:
    from ncmodel.nets.shipped import checkpoint_path

    return checkpoint_path("default").read_bytes()


def samples_of(kind: str) -> list[bytes]:
    """Valid files of a kind, named by its suffix; `votes.csv` and `results.csv` are two."""
    pair = {"shape": "cow", "view": "30", "better": 1, "worse": 0, "votes_for": 4, "votes": 5, "split": "train"}
    makers: dict[str, Callable[[], list[bytes]]] = {
        ".obj": _obj,
        ".ply": _ply,
        ".stl": _stl,
        ".off": _off,
        ".gltf": lambda: [_gltf()[0]],
        ".glb": lambda: [_gltf()[1]],
        ".3mf": lambda: [_threemf(zipfile.ZIP_STORED), _threemf(zipfile.ZIP_DEFLATED)],
        ".dae": lambda: [_collada()],
        "votes.csv": lambda: [_votes()],
        "results.csv": lambda: [_results()],
        "camera.json": lambda: [json.dumps(_CAMERA).encode()],
        "pairs.jsonl": lambda: [(json.dumps(pair) + "\n").encode() * 3],
        ".safetensors": lambda: [_checkpoint()],
    }
    return makers[kind]()


KINDS = (
    *(".obj", ".ply", ".stl", ".off", ".gltf", ".glb", ".3mf", ".dae"),
    *("votes.csv", "results.csv", "camera.json", "pairs.jsonl", ".safetensors"),
)
