"""3MF, COLLADA and STEP files of a box of 4 x 2 x 1, made by script."""

import io
import zipfile
from collections.abc import Mapping, Sequence

import numpy as np

from ncmodel.types import Floats

BOX = np.array([[x, y, z] for x in (0.0, 4) for y in (0.0, 2) for z in (0.0, 1)])
QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
"""Of the box, counter-clockwise from outside."""

RELATIONS = (
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Id="r" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel" Target="/3D/3dmodel.model"/></Relationships>'
)
_3MF = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_PRODUCTION = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"


def box_object(number: int, kind: str = "model") -> str:
    """The box as a 3MF object."""
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in BOX)
    triangles = [t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))]
    faces = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in triangles)
    mesh = f"<mesh><vertices>{vertices}</vertices><triangles>{faces}</triangles></mesh>"
    return f'<object id="{number}" type="{kind}">{mesh}</object>'


def as_3mf(objects: str, items: str, unit: str = "millimeter", others: Mapping[str, str] | None = None) -> bytes:
    """A package of one model; `others` are objects in other parts, by the part's name."""
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as package:
        package.writestr("_rels/.rels", RELATIONS)
        for part, content in {"3D/3dmodel.model": objects, **(others or {})}.items():
            build = items if part == "3D/3dmodel.model" else ""
            package.writestr(
                part,
                f'<?xml version="1.0"?><model unit="{unit}" xmlns="{_3MF}" xmlns:p="{_PRODUCTION}">'
                f"<resources>{content}</resources><build>{build}</build></model>",
            )
    return made.getvalue()


def as_collada(nodes: str, asset: str = "", primitives: str | None = None) -> bytes:
    """A document with the box as geometry `box` and a scene of some nodes; corners carry a normal's number, too."""
    ring = " ".join(f"{corner} 0" for quad in QUADS for corner in quad)
    usual = (
        f'<polylist count="6"><input semantic="VERTEX" source="#v" offset="0"/><input semantic="NORMAL" source="#n" '
        f'offset="1"/><vcount>{"4 " * 6}</vcount><p>{ring}</p></polylist>'
    )
    return (
        '<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
        f'<asset>{asset}</asset><library_geometries><geometry id="box"><mesh><source id="s"><float_array id="f" '
        f'count="24">{" ".join(map(str, BOX.ravel()))}</float_array><technique_common><accessor source="#f" count="8" '
        'stride="3"/></technique_common></source><vertices id="v"><input semantic="POSITION" source="#s"/></vertices>'
        f"{usual if primitives is None else primitives}</mesh></geometry></library_geometries>"
        f'<library_visual_scenes><visual_scene id="scene">{nodes}</visual_scene></library_visual_scenes>'
        '<scene><instance_visual_scene url="#scene"/></scene></COLLADA>'
    ).encode()


def as_step(polygons: Sequence[Sequence[int]] = QUADS) -> bytes:
    """The box as a faceted solid in millimetres (ISO 10303-214)."""
    rows: list[str] = []

    def add(text: str) -> str:
        rows.append(f"#{len(rows) + 1}={text};")
        return f"#{len(rows)}"

    def triple(values: Floats) -> str:
        return ",".join(repr(float(value)) for value in values)

    points = [add(f"CARTESIAN_POINT('',({triple(point)}))") for point in BOX]
    faces = []
    for ring in polygons:
        a, b, c = BOX[list(ring[:3])]
        normal = add(f"DIRECTION('',({triple(np.cross(b - a, c - b))}))")
        side = add(f"DIRECTION('',({triple(b - a)}))")
        plane = add(f"PLANE('',{add(f'AXIS2_PLACEMENT_3D($,{points[ring[0]]},{normal},{side})')})")
        loop = add(f"POLY_LOOP('',({','.join(points[corner] for corner in ring)}))")
        bound = add(f"FACE_OUTER_BOUND('',{loop},.T.)")
        faces.append(add(f"FACE_SURFACE('',({bound}),{plane},.T.)"))
    shell = add(f"CLOSED_SHELL('',({','.join(faces)}))")
    solid = add(f"FACETED_BREP('',{shell})")
    length = add("(LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.))")
    angle = add("(NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.))")
    units = f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle}))"
    space = add(f"(GEOMETRIC_REPRESENTATION_CONTEXT(3) {units} REPRESENTATION_CONTEXT('',''))")
    shape = add(f"FACETED_BREP_SHAPE_REPRESENTATION('',({solid}),{space})")
    application = add("APPLICATION_CONTEXT('mechanical design')")
    context = add(f"PRODUCT_CONTEXT('',{application},'mechanical')")
    product = add(f"PRODUCT('box','box','',({context}))")
    formation = add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
    design = add(f"PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')")
    definition = add(f"PRODUCT_DEFINITION('design','',{formation},{design})")
    defined = add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
    add(f"SHAPE_DEFINITION_REPRESENTATION({defined},{shape})")
    header = "FILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN'));"
    data = "\n".join(rows)
    return f"ISO-10303-21;\nHEADER;\n{header}\nENDSEC;\nDATA;\n{data}\nENDSEC;\nEND-ISO-10303-21;\n".encode()
