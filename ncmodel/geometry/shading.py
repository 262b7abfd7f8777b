"""Per-vertex quantities on the part of a surface that each pixel sees."""

import math

import numpy as np
from numpy.typing import NDArray

from ncmodel.geometry.normals_areas import Indices
from ncmodel.geometry.view_vectors import toward
from ncmodel.jit import kernel
from ncmodel.types import Floats, Image, Ints, ViewBuffers

Images = NDArray[np.float32]


def interpolate(buffers: ViewBuffers, faces: Indices, values: Floats) -> Image:
    """(H, W) values (V,) interpolated linearly at the seen points; 0 on the background."""
    return np.asarray(_interpolated(buffers.face, buffers.barycentric, faces, values))


def shade(buffers: ViewBuffers, faces: Indices, vertices: Floats, normals: Floats, viewpoint: Floats) -> Images:
    """(K, H, W) headlight shading max(n.v, 0) under K fields of normals (K, V, 3); 1 on the background."""
    return np.asarray(_shaded(buffers.face, buffers.barycentric, faces, vertices, normals, viewpoint))


@kernel
def _interpolated(face: Ints, barycentric: Floats, faces: Indices, values: Floats) -> Image:
    image = np.zeros(face.shape, dtype=np.float32)
    for row in range(face.shape[0]):
        for column in range(face.shape[1]):
            f = face[row, column]
            if f >= 0:
                value = 0.0
                for c in range(3):
                    value += barycentric[row, column, c] * values[faces[f, c]]
                image[row, column] = value
    return image


@kernel
def _shaded(
    face: Ints, barycentric: Floats, faces: Indices, vertices: Floats, normals: Floats, viewpoint: Floats
) -> Images:
    images = np.ones((len(normals), face.shape[0], face.shape[1]), dtype=np.float32)
    for row in range(face.shape[0]):
        for column in range(face.shape[1]):
            f = face[row, column]
            if f < 0:
                continue
            weights = barycentric[row, column]
            x, y, z = blended(vertices, faces, f, weights)
            x, y, z = toward(viewpoint, x, y, z)
            distance = math.sqrt(x * x + y * y + z * z)
            for level in range(len(normals)):
                nx, ny, nz = blended(normals[level], faces, f, weights)
                length = distance * math.sqrt(nx * nx + ny * ny + nz * nz)
                cosine = (nx * x + ny * y + nz * z) / length if length > 0.0 else 0.0
                images[level, row, column] = max(cosine, 0.0)
    return images


@kernel
def blended(vectors: Floats, faces: Indices, f: int, weights: Floats) -> tuple[float, float, float]:
    """The weighted sum of the vectors at a face's corners."""
    i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
    a, b, c = weights[0], weights[1], weights[2]
    return (
        a * vectors[i, 0] + b * vectors[j, 0] + c * vectors[k, 0],
        a * vectors[i, 1] + b * vectors[j, 1] + c * vectors[k, 1],
        a * vectors[i, 2] + b * vectors[j, 2] + c * vectors[k, 2],
    )
