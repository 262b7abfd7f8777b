"""The definitions of geometric lines, written down once more: face by face, in plain NumPy, without any shortcut.

Slow and independent of the kernels: normal equations are solved as matrices, frames are rotated as vectors.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ncmodel.types import Floats, Ints

Segment = tuple[int, Floats, Floats]
"""Face, end points (2, 3), strength at the ends (2,)."""


@dataclass(frozen=True, eq=False)
class Oracle:
    """What the oracle computes for one mesh from one eye; names as in `ncontours features`."""

    normals: Floats
    corner_areas: Floats
    point_areas: Floats
    k1: Floats
    k2: Floats
    dir1: Floats
    dir2: Floats
    dcurv: Floats
    n_dot_v: Floats
    kr: Floats
    sc_num: Floats
    q1: Floats
    t1: Floats
    dt1q1: Floats


def unit(vector: Floats) -> Floats:
    return np.asarray(vector / np.linalg.norm(vector))


def edges(vertices: Floats, face: Ints) -> Floats:
    p = vertices[face]
    return np.array([p[2] - p[1], p[0] - p[2], p[1] - p[0]])


def normals(vertices: Floats, faces: Ints) -> Floats:
    total = np.zeros_like(vertices)
    for face in faces:
        for j in range(3):
            a = vertices[face[(j + 1) % 3]] - vertices[face[j]]
            b = vertices[face[(j + 2) % 3]] - vertices[face[j]]
            total[face[j]] += np.cross(a, b) / ((a @ a) * (b @ b))
    return np.asarray(total / np.linalg.norm(total, axis=1, keepdims=True))


def corner_areas(vertices: Floats, faces: Ints) -> Floats:
    result = np.zeros((len(faces), 3))
    for f, face in enumerate(faces):
        e = edges(vertices, face)
        area = np.linalg.norm(np.cross(e[0], e[1])) / 2
        square = (e**2).sum(axis=1)
        b = np.array([square[j] * (square[(j + 1) % 3] + square[(j + 2) % 3] - square[j]) for j in range(3)])
        if (b > 0).all():
            result[f] = [area * (b[(j + 1) % 3] + b[(j + 2) % 3]) / (2 * b.sum()) for j in range(3)]
            continue
        j = int(np.flatnonzero(b <= 0)[0])
        following, previous = (j + 1) % 3, (j + 2) % 3
        result[f, following] = -square[previous] * area / (4 * e[j] @ e[previous])
        result[f, previous] = -square[following] * area / (4 * e[j] @ e[following])
        result[f, j] = area - result[f, following] - result[f, previous]
    return result


def turned(vector: Floats, old: Floats, new: Floats) -> Floats:
    """`vector` rotated by the least rotation from normal `old` to normal `new`."""
    cosine = old @ new
    if cosine <= -1:
        return -vector
    return np.asarray(vector - (old + new) * (vector @ (new - cosine * old)) / (1 + cosine))


def face_frame(e: Floats) -> tuple[Floats, Floats, Floats]:
    t, n = unit(e[0]), unit(np.cross(e[0], e[1]))
    return t, np.cross(n, t), n


def curvature(vertices: Floats, faces: Ints, normal: Floats, areas: Floats) -> tuple[Floats, Floats, Floats]:
    """k1, k2 and dir1."""
    points = np.zeros(len(vertices))
    np.add.at(points, faces, areas)
    frames = [np.linalg.svd(n[None])[2][1:] for n in normal]
    frames = [x if np.cross(x[0], x[1]) @ n > 0 else x[::-1] for x, n in zip(frames, normal, strict=True)]
    tensor = np.zeros((len(vertices), 2, 2))
    for f, face in enumerate(faces):
        e = edges(vertices, face)
        t, b, n = face_frame(e)
        u, v = e @ t, e @ b
        d = np.array([normal[face[(j + 2) % 3]] - normal[face[(j + 1) % 3]] for j in range(3)])
        a, c = d @ t, d @ b
        w = np.array([[u @ u, u @ v, 0], [u @ v, u @ u + v @ v, u @ v], [0, u @ v, v @ v]])
        uu, uv, vv = np.linalg.solve(w, [a @ u, a @ v + c @ u, c @ v])
        operator = np.array([[uu, uv], [uv, vv]])
        for j in range(3):
            i = face[j]
            axes = np.array([turned(w, normal[i], n) for w in frames[i]])
            plane = axes @ np.array([t, b]).T
            tensor[i] += areas[f, j] / points[i] * plane @ operator @ plane.T
    value, vector = np.linalg.eigh(tensor)
    larger = np.abs(value).argmax(axis=1)
    rows = np.arange(len(value))
    dir1 = np.array([frames[i].T @ vector[i][:, larger[i]] for i in rows])
    return value[rows, larger], value[rows, 1 - larger], dir1


def derivative(vertices: Floats, faces: Ints, o: Oracle) -> Floats:
    result = np.zeros((len(vertices), 4))
    for f, face in enumerate(faces):
        e = edges(vertices, face)
        t, b, n = face_frame(e)
        u, v = e @ t, e @ b
        tensors = []
        for i in face:
            plane = np.array([turned(w, o.normals[i], n) for w in (o.dir1[i], o.dir2[i])]) @ np.array([t, b]).T
            tensor = plane.T @ np.diag([o.k1[i], o.k2[i]]) @ plane
            tensors.append([tensor[0, 0], tensor[0, 1], tensor[1, 1]])
        dp, dq, dr = np.array([np.subtract(tensors[(j + 2) % 3], tensors[(j + 1) % 3]) for j in range(3)]).T
        uu, uv, vv = u @ u, u @ v, v @ v
        w = np.array([[uu, uv, 0, 0], [uv, 2 * uu + vv, 2 * uv, 0], [0, 2 * uv, uu + 2 * vv, uv], [0, 0, uv, vv]])
        c = np.linalg.solve(w, [u @ dp, v @ dp + 2 * u @ dq, 2 * v @ dq + u @ dr, v @ dr])
        cubic = np.array([[[c[0], c[1]], [c[1], c[2]]], [[c[1], c[2]], [c[2], c[3]]]])
        for j, i in enumerate(face):
            x, y = np.array([turned(w, o.normals[i], n) for w in (o.dir1[i], o.dir2[i])]) @ np.array([t, b]).T
            values = [np.einsum("ijk,i,j,k", cubic, *axes) for axes in ((x, x, x), (x, x, y), (x, y, y), (y, y, y))]
            result[i] += o.corner_areas[f, j] / o.point_areas[i] * np.array(values)
    return result


def q1_derivative(vertices: Floats, faces: Ints, o: Oracle) -> Floats:
    result = np.zeros(len(vertices))
    for i in range(len(vertices)):
        t1 = o.t1[i, 0] * o.dir1[i] + o.t1[i, 1] * o.dir2[i]
        t2 = np.cross(o.normals[i], t1)
        hits = []
        for face in faces:
            if i not in face:
                continue
            place = list(face).index(i)
            a, b = face[(place + 1) % 3], face[(place + 2) % 3]
            w = ((vertices[b] - vertices[i]) @ t2) / ((vertices[b] - vertices[a]) @ t2)
            if 0 <= w < 1:
                point, value = w * vertices[a] + (1 - w) * vertices[b], w * o.q1[a] + (1 - w) * o.q1[b]
                hits.append((value - o.q1[i]) / (((point - vertices[i]) @ t1) * abs(o.n_dot_v[i])))
        result[i] = np.mean(hits[:2]) if hits else 0.0
    return result


def evaluate(vertices: Floats, faces: Ints, eye: Floats) -> Oracle:
    normal, corners = normals(vertices, faces), corner_areas(vertices, faces)
    points = np.zeros(len(vertices))
    np.add.at(points, faces, corners)
    k1, k2, dir1 = curvature(vertices, faces, normal, corners)
    dir2 = np.cross(normal, dir1)
    nothing = np.zeros(len(vertices))
    o = Oracle(normal, corners, points, k1, k2, dir1, dir2, *([nothing] * 7))
    o = _with(o, dcurv=derivative(vertices, faces, o))
    toward = np.array([unit(eye - p) for p in vertices])
    nv, u, v = ((toward * axis).sum(axis=1) for axis in (normal, dir1, dir2))
    s2 = u**2 + v**2
    c = o.dcurv.T
    tau = (k2 - k1) * u * v / s2
    num = (c[0] * u**3 + 3 * c[1] * u**2 * v + 3 * c[2] * u * v**2 + c[3] * v**3) / s2 - 2 * nv * tau**2
    o = _with(o, n_dot_v=nv, kr=k1 * u**2 + k2 * v**2, sc_num=num)
    q1, t1 = np.zeros(len(vertices)), np.zeros((len(vertices), 2))
    for i in range(len(vertices)):
        w = np.array([u[i], v[i]]) / np.sqrt(s2[i])
        q = np.diag([k1[i], k2[i]]) @ (np.eye(2) + (1 / abs(nv[i]) - 1) * np.outer(w, w))
        value, vector = np.linalg.eigh(q.T @ q)
        q1[i], t1[i] = value[1], vector[:, 1]
    o = _with(o, q1=q1, t1=t1)
    return _with(o, dt1q1=q1_derivative(vertices, faces, o))


def _with(oracle: Oracle, **fields: Floats) -> Oracle:
    return Oracle(**{**oracle.__dict__, **fields})


def zero_set(
    vertices: Floats, faces: Ints, value: Floats, num: Floats, den: Floats | None, n_dot_v: Floats | None
) -> list[Segment]:
    """Contours (`den` and `n_dot_v` None) or suggestive contours, with num/den at the ends."""
    result = []
    for f, face in enumerate(faces):
        if not ((value[face] > 0).any() and (value[face] < 0).any()):
            continue
        if n_dot_v is not None and (n_dot_v[face] <= 0).all():
            continue
        d = np.ones(3) if den is None else den[face]
        n = num[face]
        if ((n <= 0) & (d >= 0)).all() or ((n >= 0) & (d <= 0)).all():
            continue
        lone = next(j for j in range(3) if _lone(value[face], j))
        ends = []
        for other in ((lone + 1) % 3, (lone + 2) % 3):
            s = value[face[lone]] / (value[face[lone]] - value[face[other]])
            ends.append([(1 - s) * q[lone] + s * q[other] for q in (vertices[face], n, d)])
        (p0, n0, d0), (p1, n1, d1) = ends
        cuts = sorted({0.0, 1.0} | {a / (a - b) for a, b in ((n0, n1), (d0, d1)) if (a >= 0) != (b >= 0)})
        for start, end in pairwise(cuts):
            middle = (start + end) / 2
            if (n0 + middle * (n1 - n0) >= 0) != (d0 + middle * (d1 - d0) >= 0):
                continue
            at = np.array([start, end])
            with np.errstate(divide="ignore"):
                strength = (n0 + at * (n1 - n0)) / (d0 + at * (d1 - d0))
            result.append((f, p0 + at[:, None] * (p1 - p0), strength))
    return result


def _lone(v: Floats, j: int) -> bool:
    a, b, c = v[j], v[(j + 1) % 3], v[(j + 2) % 3]
    return bool((a < 0 and b >= 0 and c >= 0) or (a > 0 and b <= 0 and c <= 0))


def extrema(
    vertices: Floats, faces: Ints, e: Floats, direction: Floats, k: Floats, n_dot_v: Floats | None, g: float
) -> list[Segment]:
    """Ridges (`g` 1) and valleys (-1) with `n_dot_v`; apparent ridges without."""
    apparent = n_dot_v is None
    m = g * e[:, None] * direction
    result = []
    for f, face in enumerate(faces):
        if n_dot_v is not None and ((n_dot_v[face] <= 0).all() or not (g * k[face] > 0).all()):
            continue
        crossed = {}
        for j in range(3):
            a, b = face[j], face[(j + 1) % 3]
            run = vertices[b] - vertices[a]
            crossed[j] = m[a] @ m[b] <= 0 and (apparent or m[a] @ run >= 0 or m[b] @ run <= 0)
        sides = [j for j in range(3) if crossed[j]]
        if len(sides) < 2:
            continue
        points = {j: _crossing(vertices, face, j, e, k) for j in sides}
        centroid = (vertices[face].mean(axis=0), abs(k[face].mean()))
        starts = sides if len(sides) == 3 else [j for j in sides if (j + 1) % 3 in sides]
        for j in starts:
            a, b, c = face[j], face[(j + 1) % 3], face[(j + 2) % 3]
            (p, first), (q, second) = points[j], centroid if len(sides) == 3 else points[(j + 1) % 3]
            area = np.cross(vertices[b] - vertices[a], vertices[c] - vertices[a])
            across = np.cross(area, p - q)
            if apparent and not (m[a] @ across > 0 and m[b] @ across < 0 and m[c] @ across > 0):
                continue
            result.append((f, np.array([p, q]), np.array([first, second])))
    return result


def _crossing(vertices: Floats, face: Ints, j: int, e: Floats, k: Floats) -> tuple[Floats, float]:
    a, b = face[j], face[(j + 1) % 3]
    w = abs(e[a]) / (abs(e[a]) + abs(e[b]))
    return (1 - w) * vertices[a] + w * vertices[b], float(abs((1 - w) * k[a] + w * k[b]))
