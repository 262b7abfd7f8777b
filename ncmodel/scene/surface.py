"""A mesh and everything about it that doesn't depend on the view, computed when first asked for."""

import math
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np

from ncmodel.geometry import curvature, normals_areas
from ncmodel.geometry.adjacency import Rings, components, rings_of
from ncmodel.geometry.feature_size import enclosing_radius, feature_size_of_all, sampled_feature_size
from ncmodel.geometry.normal_smoothing import smoothed_normals
from ncmodel.lines import edges, intersections, ridges
from ncmodel.tracing import stage, timed
from ncmodel.types import Floats, Ints, LineSet, Mesh, Trace

if TYPE_CHECKING:
    from ncmodel.geometry.raycast import RayScene


Sizing = Literal["all", "sampled"]

CREASE_ANGLE = 40.0
"""Degrees between the normals of adjacent faces above which their edge is a crease."""


class Surface:
    """The view-independent quantities of a mesh, per vertex unless said otherwise; computed once, when asked for.

    Args:
        mesh: The mesh, in object space.
        trace: Where to record what was computed; a new one by default.
        sizing: What the feature size is found from: "all" vertices of faces, or those "sampled" by their numbers in
            rtsc's fixed random sequence. They differ by some 20 %; only the latter agrees with rtsc's numbers.
    """

    def __init__(self, mesh: Mesh, trace: Trace | None = None, sizing: Sizing = "all") -> None:
        self.mesh, self.sizing = mesh, sizing
        self.trace = trace if trace is not None else Trace()
        self._creases: dict[float, edges.Edges] = {}
        self.parted: dict[float, Surface] = {}  # crease angle -> this surface parted there

    @property
    def whole(self) -> "Surface":
        """The surface that this one is a parted copy of; itself unless it is parted."""
        return self

    @stage
    def faces(self) -> normals_areas.Indices:
        """(F, 3) the mesh's faces with half the memory to read."""
        return self.mesh.faces.astype(np.uint32)

    @stage
    def normals(self) -> Floats:
        """(V, 3) unit normals."""
        return normals_areas.vertex_normals(self.mesh.vertices, self.faces)

    @stage
    def point_areas(self) -> Floats:
        """(V,) area that belongs to each vertex."""
        return normals_areas.point_areas(self.mesh.vertices, self.faces)

    @stage
    def curvature(self) -> tuple[Floats, Floats]:
        """(V, 2) principal curvatures and (V, 3) the first principal direction."""
        return curvature.curvature_tensor(self.mesh.vertices, self.faces, self.normals, self.point_areas)

    @property
    def curvatures(self) -> Floats:
        """(V, 2) k1 and k2."""
        return self.curvature[0]

    @property
    def k1(self) -> Floats:
        """(V,) principal curvature of largest absolute value; convex is positive."""
        return self.curvature[0][:, 0]

    @property
    def k2(self) -> Floats:
        """(V,) the other principal curvature."""
        return self.curvature[0][:, 1]

    @property
    def dir1(self) -> Floats:
        """(V, 3) direction of k1."""
        return self.curvature[1]

    @cached_property
    def dir2(self) -> Floats:
        """(V, 3) direction of k2: normal x dir1."""
        return np.cross(self.normals, self.dir1)

    @stage
    def dcurv(self) -> Floats:
        """(V, 4) derivative of curvature: C111, C112, C122, C222 along (dir1, dir2)."""
        vertices, faces, normals, point_areas = self.mesh.vertices, self.faces, self.normals, self.point_areas
        return curvature.curvature_derivative(vertices, faces, normals, point_areas, self.curvatures, self.dir1)

    @stage
    def enclosing_radius(self) -> float:
        """Radius of the smallest sphere around the vertices; for rtsc, those that no face uses count, too."""
        return enclosing_radius(self.mesh.vertices if self.sizing == "sampled" else self.mesh.used_vertices)

    @stage
    def feature_size(self) -> float:
        """The length that makes thresholds dimensionless."""
        if self.sizing == "all":
            inhabited = self.point_areas > 0.0
            curvatures = self.curvatures if inhabited.all() else self.curvatures[inhabited]
            return feature_size_of_all(curvatures, self.enclosing_radius)
        return sampled_feature_size(self.curvatures, self.enclosing_radius)

    @stage
    def ridges_and_valleys(self) -> tuple[LineSet, LineSet]:
        """Ridges and valleys at threshold 0, on back faces too."""
        # In one piece each, they are read faster.
        k1, derivative = np.ascontiguousarray(self.k1), np.ascontiguousarray(self.dcurv[:, 0])
        return ridges.ridges_and_valleys(self.mesh.vertices, self.faces, k1, self.dir1, derivative, self.feature_size)

    @stage
    def is_closed(self) -> bool:
        """Whether every side of every face is matched by an opposite one."""
        return edges.is_closed(self.faces)

    @stage
    def rings(self) -> Rings:
        """Which faces meet at each vertex."""
        return rings_of(self.faces, len(self.mesh.vertices))

    @stage
    def shells(self) -> Ints:
        """(F,) a number for each face, equal for connected ones."""
        return components(self.faces, len(self.mesh.vertices))[self.faces[:, 0]]

    @stage
    def boundary_edges(self) -> edges.Edges:
        """Sides without an opposite twin; a closed mesh is told apart without a search."""
        if self.is_closed:
            return edges.Edges(np.zeros((0, 2), dtype=np.int64), np.zeros(0, dtype=np.int64))
        return edges.boundary_edges(self.rings)

    def creases(self, angle_degrees: float = CREASE_ANGLE) -> edges.Edges:
        """Edges where the surface bends by more than `angle_degrees`."""
        if angle_degrees not in self._creases:
            rings = self.rings
            with timed(self.trace, "creases"):
                self._creases[angle_degrees] = edges.creases(self.mesh.vertices, rings, math.radians(angle_degrees))
        return self._creases[angle_degrees]

    @stage
    def intersections(self) -> LineSet:
        """Where the surface passes through itself, or one of its parts through another."""
        return intersections.intersections(self.mesh.vertices, self.faces, self.rings)

    @stage
    def smoothed_normals(self) -> Floats:
        """(6, V, 3) unit normals, diffused at sigma = 0..5 median side lengths."""
        return smoothed_normals(self.mesh.vertices, self.normals, self.point_areas, self.rings)

    @stage
    def scene(self) -> "RayScene":
        """The mesh, ready for rays."""
        from ncmodel.geometry.raycast import RayScene

        return RayScene(self.mesh)
