"""A surface seen from a camera, and everything that depends on the view, computed when first asked for."""

from collections.abc import Callable
from functools import cached_property

import numpy as np

from ncmodel.camera import Camera
from ncmodel.geometry import extrema, pixels, view_curvature, zero_sets
from ncmodel.geometry.surface import CREASE_ANGLE, Surface
from ncmodel.stages import stage, timed
from ncmodel.types import Floats, Image, LineFamily, LineSet, ViewBuffers


class View:
    """The view-dependent quantities of a surface, per vertex unless said otherwise; computed once, when asked for.

    Args:
        surface: The surface; its trace is shared.
        camera: Where it is seen from.
        crease_angle: Degrees between faces above which their edge is a crease.
    """

    def __init__(self, surface: Surface, camera: Camera, crease_angle: float = CREASE_ANGLE) -> None:
        self.surface, self.camera, self.crease_angle = surface, camera, crease_angle
        self.mesh, self.trace = surface.mesh, surface.trace
        self.eye = np.asarray(camera.eye, dtype=np.float64)
        self._lines: dict[LineFamily, LineSet] = {}
        self._visible: dict[LineFamily, LineSet] = {}
        self._feature_maps: dict[LineFamily, Image] = {}

    @stage
    def n_dot_v(self) -> Floats:
        """(V,) cosine between normal and direction to the eye."""
        return view_curvature.facing(self.mesh.vertices, self.surface.normals, self.eye)

    @stage
    def tangential_view(self) -> Floats:
        """(2, V) the direction to the eye along dir1 and dir2."""
        surface = self.surface
        return view_curvature.tangential_view(self.mesh.vertices, surface.normals, surface.dir1, self.eye)

    @stage
    def kr(self) -> Floats:
        """(V,) radial curvature times sin^2(theta)."""
        return view_curvature.radial_curvature(self.surface.curvatures, self.tangential_view)

    @stage
    def sc_num(self) -> Floats:
        """(V,) sin(theta) DwKr: numerator of the suggestive-contour test."""
        surface = self.surface
        return view_curvature.radial_derivative(surface.curvatures, surface.dcurv, self.tangential_view, self.n_dot_v)

    @stage
    def view_curvature(self) -> tuple[Floats, Floats]:
        """(V,) q1 and (V, 2) t1."""
        return view_curvature.view_dependent_curvature(self.surface.curvatures, self.tangential_view, self.n_dot_v)

    @property
    def q1(self) -> Floats:
        """(V,) square of the largest view-dependent curvature."""
        return self.view_curvature[0]

    @property
    def t1(self) -> Floats:
        """(V, 2) its direction in (dir1, dir2)."""
        return self.view_curvature[1]

    @cached_property
    def t1_in_space(self) -> Floats:
        """(V, 3) the direction t1 in object space."""
        return self.t1[:, :1] * self.surface.dir1 + self.t1[:, 1:] * self.surface.dir2

    @stage
    def dt1q1(self) -> Floats:
        """(V,) derivative of q1 along t1."""
        surface = self.surface
        return view_curvature.view_dependent_derivative(
            self.mesh.vertices, self.mesh.faces, surface.normals, surface.dir1, self.q1, self.t1, self.n_dot_v
        )

    @stage
    def silhouettes(self) -> LineSet:
        """All of n.v = 0, from normals alone: the occluding contours and what a solid always hides of them."""
        return zero_sets.contours(self.mesh.vertices, self.mesh.faces, self.n_dot_v, None)

    @stage
    def buffers(self) -> ViewBuffers:
        """What each pixel sees."""
        return self.surface.scene.render(self.camera)

    @property
    def depth(self) -> Image:
        """(H, W) 0 near .. 1 far, background 1."""
        return self.buffers.depth

    @stage
    def shaded(self) -> pixels.Images:
        """(6, H, W) max(n.v, 0) with normals smoothed at sigma = 0..5 median edges, background 1."""
        mesh = self.mesh
        return pixels.shade(self.buffers, mesh.faces, mesh.vertices, self.surface.smoothed_normals, self.eye)

    def feature_map(self, family: LineFamily) -> Image:
        """(H, W) the quantity that a filtered family's threshold is compared with, on the seen surface; background 0.

        sin(theta) DwKr for suggestive contours, k1 for ridges, -k1 for valleys, q1 for apparent ridges.

        Raises:
            KeyError: No threshold filters the family.
        """
        if family not in self._feature_maps:
            values, buffers = _FEATURES[family](self), self.buffers
            with timed(self.trace, f"feature_map_{family}"):
                self._feature_maps[family] = pixels.interpolate(buffers, self.mesh.faces, values)
        return self._feature_maps[family]

    def lines(self, family: LineFamily) -> LineSet:
        """All lines of a family at threshold 0, hidden ones included (geometry-spec 7-10)."""
        if family not in self._lines:
            with timed(self.trace, f"lines_{family}"):
                self._lines[family] = _EXTRACTORS[family](self)
        return self._lines[family]

    def visible(self, family: LineFamily) -> LineSet:
        """The lines of a family at threshold 0, hidden parts cut away.

        Occluding contours come from `silhouettes`: rays tell what is hidden, so curvature isn't needed.
        """
        from ncmodel.geometry.visibility import visible_pieces

        if family not in self._visible:
            lines = _unhidden_contours(self) if family is LineFamily.CONTOURS else self.lines(family)
            scene = self.surface.scene
            with timed(self.trace, f"visible_{family}"):
                self._visible[family] = visible_pieces(lines, self.camera, scene, self.surface.normals)
        return self._visible[family]


def _unhidden_contours(view: View) -> LineSet:
    lines = view.silhouettes
    if not view.surface.is_closed:
        return lines  # seen from behind, a sheet has contours where a solid hides them
    return lines.take(zero_sets.front_is_nearer(lines, view.mesh.vertices, view.mesh.faces, view.n_dot_v, view.eye))


def _contours(view: View) -> LineSet:
    return zero_sets.contours(view.mesh.vertices, view.mesh.faces, view.n_dot_v, view.kr)


def _suggestive(view: View) -> LineSet:
    mesh, size = view.mesh, view.surface.feature_size
    return zero_sets.suggestive_contours(mesh.vertices, mesh.faces, view.n_dot_v, view.kr, view.sc_num, size)


def _apparent(view: View) -> LineSet:
    mesh, size = view.mesh, view.surface.feature_size
    return extrema.apparent_ridges(mesh.vertices, mesh.faces, view.q1, view.t1_in_space, view.dt1q1, size)


def _ridges(view: View) -> LineSet:
    return _extremal(view, convex=True)


def _valleys(view: View) -> LineSet:
    return _extremal(view, convex=False)


def _extremal(view: View, convex: bool) -> LineSet:
    surface, mesh = view.surface, view.mesh
    everywhere = extrema.ridges(
        mesh.vertices, mesh.faces, surface.k1, surface.dir1, surface.dcurv[:, 0], surface.feature_size, convex
    )
    return extrema.facing_only(everywhere, mesh.faces, view.n_dot_v)


def _boundaries(view: View) -> LineSet:
    return view.surface.boundary_edges.lines(LineFamily.BOUNDARIES, view.mesh.vertices)


def _creases(view: View) -> LineSet:
    return view.surface.creases(view.crease_angle).lines(LineFamily.CREASES, view.mesh.vertices)


_EXTRACTORS: dict[LineFamily, Callable[[View], LineSet]] = {
    LineFamily.CONTOURS: _contours,
    LineFamily.BOUNDARIES: _boundaries,
    LineFamily.CREASES: _creases,
    LineFamily.SUGGESTIVE: _suggestive,
    LineFamily.APPARENT: _apparent,
    LineFamily.RIDGES: _ridges,
    LineFamily.VALLEYS: _valleys,
}

_FEATURES: dict[LineFamily, Callable[[View], Floats]] = {
    LineFamily.SUGGESTIVE: lambda view: view.sc_num,
    LineFamily.RIDGES: lambda view: view.surface.k1,
    LineFamily.VALLEYS: lambda view: -view.surface.k1,
    LineFamily.APPARENT: lambda view: view.q1,
}
