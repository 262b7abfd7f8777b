"""A mesh and everything about it that doesn't depend on the view, computed when first asked for."""

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ncmodel.geometry import curvature
from ncmodel.geometry.feature_size import enclosing_radius, percentile_feature_size, sampled_feature_size
from ncmodel.stages import stage
from ncmodel.types import Floats, Mesh, Trace

if TYPE_CHECKING:
    from ncmodel.geometry.raycast import RayScene


class Surface:
    """The view-independent quantities of a mesh, per vertex unless said otherwise; each is computed once, when asked for.

    Args:
        mesh: The mesh, in object space.
        trace: Where to record what was computed; a new one by default.
    """

    def __init__(self, mesh: Mesh, trace: Trace | None = None) -> None:
        self.mesh = mesh
        self.trace = trace if trace is not None else Trace()

    @stage
    def normals(self) -> Floats:
        """(V, 3) unit normals."""
        return curvature.vertex_normals(self.mesh.vertices, self.mesh.faces)

    @stage
    def point_areas(self) -> Floats:
        """(V,) area that belongs to each vertex."""
        return curvature.point_areas(self.mesh.vertices, self.mesh.faces)

    @stage
    def curvature(self) -> tuple[Floats, Floats]:
        """(V, 2) principal curvatures and (V, 3) the first principal direction."""
        return curvature.curvature_tensor(self.mesh.vertices, self.mesh.faces, self.normals, self.point_areas)

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
        mesh = self.mesh
        return curvature.curvature_derivative(
            mesh.vertices, mesh.faces, self.normals, self.point_areas, self.curvatures, self.dir1
        )

    @stage
    def enclosing_radius(self) -> float:
        """Radius of the smallest sphere around the vertices."""
        return enclosing_radius(self.mesh.vertices)

    @stage
    def feature_size(self) -> float:
        """rtsc's feature size, which its thresholds are multiplied with."""
        return sampled_feature_size(self.curvatures, self.enclosing_radius)

    @stage
    def percentile_feature_size(self) -> float:
        """A feature size that depends neither on vertex order nor on how densely parts are meshed."""
        return percentile_feature_size(self.curvatures, self.point_areas, self.enclosing_radius)

    @stage
    def scene(self) -> "RayScene":
        """The mesh, ready for rays."""
        from ncmodel.geometry.raycast import RayScene

        return RayScene(self.mesh)
