"""A surface seen from a camera, and everything that depends on the view, computed when first asked for."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

import numpy as np

from ncmodel.camera import Camera
from ncmodel.geometry import shading, view_curvature
from ncmodel.lines import contours, ridges
from ncmodel.lines.edges import bent_to
from ncmodel.scene import creases
from ncmodel.scene.surface import CREASE_ANGLE, Surface
from ncmodel.tracing import stage, timed
from ncmodel.types import Floats, Image, LineFamily, LineSet, Mask, ViewBuffers

if TYPE_CHECKING:
    from ncmodel.lines.occlusion import Smooth
    from ncmodel.scene.face_outlines import FaceOutlines

PERCENTILE = 90.0
"""Of a feature map: the unit of t in equations 1-4."""


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
        self._lines: dict[LineFamily, LineSet] = {}
        self._visible: dict[tuple[LineFamily, float], LineSet] = {}
        self._outlined: dict[float, FaceOutlines] = {}
        self._feature_maps: dict[LineFamily, Image] = {}

    @stage
    def n_dot_v(self) -> Floats:
        """(V,) cosine between normal and direction to the eye."""
        return view_curvature.facing(self.mesh.vertices, self.surface.normals, self.camera.viewpoint)

    @stage
    def radial_curvature(self) -> tuple[Floats, Floats]:
        """(V,) kr and (2, V) the direction to the eye along dir1 and dir2."""
        vertices, surface = self.mesh.vertices, self.surface
        return view_curvature.radial_curvature(
            vertices, surface.normals, surface.curvatures, surface.dir1, self.camera.viewpoint
        )

    @property
    def kr(self) -> Floats:
        """(V,) radial curvature times sin^2(theta)."""
        return self.radial_curvature[0]

    @stage
    def sc_num(self) -> Floats:
        """(V,) sin(theta) DwKr: numerator of the suggestive-contour test."""
        curvatures, derivative = self.surface.curvatures, self.surface.dcurv
        return view_curvature.radial_derivative(curvatures, derivative, self.radial_curvature[1], self.n_dot_v)

    @stage
    def view_curvature(self) -> tuple[Floats, Floats]:
        """(V,) q1 and (2, V) t1."""
        return view_curvature.view_dependent_curvature(self.surface.curvatures, self.radial_curvature[1], self.n_dot_v)

    @property
    def q1(self) -> Floats:
        """(V,) square of the largest view-dependent curvature."""
        return self.view_curvature[0]

    @property
    def t1(self) -> Floats:
        """(V, 2) its direction in (dir1, dir2)."""
        return self.view_curvature[1].T

    @stage
    def view_derivative(self) -> tuple[Floats, Floats]:
        """(V,) derivative of q1 along t1 and (V, 3) t1 in object space."""
        surface, vertices = self.surface, self.mesh.vertices
        q1, t1 = self.view_curvature
        return view_curvature.view_dependent_derivative(
            vertices, surface.normals, surface.dir1, q1, t1, self.n_dot_v, surface.rings.starts, surface.rings.around
        )

    @property
    def dt1q1(self) -> Floats:
        """(V,) derivative of q1 along t1."""
        return self.view_derivative[0]

    @stage
    def facing_slope(self) -> Floats:
        """(V,) derivative of n.v towards the eye: the sign of kr on contours, from normals alone."""
        return view_curvature.facing_slope(self.mesh.vertices, self.surface.faces, self.n_dot_v, self.camera.viewpoint)

    @stage
    def outlines(self) -> LineSet:
        """Occluding contours from normals alone.

        A solid hides them where the surface behind their front-facing side is nearer; a sheet, which can be seen from
        behind, keeps all of n.v = 0.
        """
        slope = self.facing_slope if self.surface.is_closed else None
        return contours.contours(self.mesh.vertices, self.surface.faces, self.n_dot_v, slope)

    @stage
    def buffers(self) -> ViewBuffers:
        """What each pixel sees."""
        return self.surface.scene.render(self.camera)

    @property
    def depth(self) -> Image:
        """(H, W) 0 near .. 1 far, background 1."""
        return self.buffers.depth

    @stage
    def shaded(self) -> shading.Images:
        """(6, H, W) max(n.v, 0) with normals smoothed at sigma = 0..5 median edges, background 1."""
        normals, faces = self.surface.smoothed_normals, self.surface.faces
        return shading.shade(self.buffers, faces, self.mesh.vertices, normals, self.camera.viewpoint)

    def feature_map(self, family: LineFamily) -> Image:
        """(H, W) the quantity that a filtered family's threshold is compared with, on the seen surface; background 0.

        sin(theta) DwKr for suggestive contours, k1 for ridges, -k1 for valleys, q1 for apparent ridges.

        Raises:
            KeyError: No threshold filters the family.
        """
        if family not in self._feature_maps:
            values, buffers = _FEATURES[family](self), self.buffers
            with timed(self.trace, f"feature_map_{family}"):
                self._feature_maps[family] = shading.interpolate(buffers, self.surface.faces, values)
        return self._feature_maps[family]

    def feature_percentile(self, family: LineFamily, over: Literal["view", "mesh"] = "view") -> float:
        """The unit of a filtered family's thresholds in the paper: the 90th percentile of its positive feature values.

        1 where no value is positive: no threshold then matters.

        Args:
            family: The family.
            over: The values at the pixels of the "view", or at the vertices of the "mesh", seen or not.
        """
        values = self.feature_map(family) if over == "view" else _FEATURES[family](self)
        positive = values[values > 0]
        return float(np.percentile(positive, PERCENTILE)) if positive.size else 1.0

    def lines(self, family: LineFamily) -> LineSet:
        """All lines of a family at threshold 0, hidden ones included (docs/geometry.md 7-10)."""
        if family not in self._lines:
            with timed(self.trace, f"lines_{family}"):
                self._lines[family] = _EXTRACTORS[family](self)
        return self._lines[family]

    def candidates(self, family: LineFamily) -> LineSet:
        """The lines of a family that may be seen, at threshold 0.

        They are `lines` except for occluding contours, which are `outlines`: rays tell what is hidden, so curvature
        isn't needed; for creases, of which bits of rough surfaces are left out and lines along rounded edges are some;
        for these and boundaries, where inner walls and edges of other parts touch a flat side from behind; and for
        lines of curvature on the flats of a surface with creases, which have no curvature.
        """
        if family is LineFamily.CONTOURS:
            return self.outlines
        if family in (LineFamily.CREASES, LineFamily.BOUNDARIES):
            surface, whole, angle = self.surface, self.surface.whole, self.crease_angle
            vertices = whole.mesh.vertices
            if family is LineFamily.CREASES:
                found = creases.crease_lines(surface, angle).seen_from(self.camera.viewpoint, vertices, whole.faces)
            else:
                found = surface.boundary_edges
            if len(found):
                found = bent_to(found, vertices, whole.rings, self.camera.viewpoint, math.radians(angle))
            return found.lines(family, vertices)
        return creases.off_flats(self.lines(family), self.surface)

    def beyond(self, pixels: Floats) -> Mask:
        """(N,) True for the (N, 2) pixels beyond the shape, where the background is seen."""
        return np.asarray(self.surface.scene.first_hit(*self.camera.rays(pixels))[1] < 0)

    def unhidden(self, lines: LineSet, sample_pixels: float = 1.0) -> LineSet:
        """The parts of lines that the camera sees.

        Args:
            lines: Any lines on the surface.
            sample_pixels: Distance along the picture of the points at which that is decided.
        """
        from ncmodel.lines.visibility import visible_pieces

        if len(lines) == 0:
            return lines
        smooth = self._smooth(lines.family)
        with timed(self.trace, f"visible_{lines.family}"):
            return visible_pieces(lines, self.camera, self.surface.scene, smooth, sample_pixels)

    def behind(self, lines: LineSet, sample_pixels: float = 1.0) -> LineSet:
        """The parts of lines in the frame that the surface hides: what `unhidden` takes away; arguments as there."""
        from ncmodel.lines.visibility import hidden_pieces

        if len(lines) == 0:
            return lines
        smooth = self._smooth(lines.family)
        with timed(self.trace, f"hidden_{lines.family}"):
            return hidden_pieces(lines, self.camera, self.surface.scene, smooth, sample_pixels)

    def _smooth(self, family: LineFamily) -> "Smooth | None":
        """The smooth surface, for lines that lie on it."""
        from ncmodel.lines.occlusion import Smooth
        from ncmodel.lines.visibility import FLAT

        return None if family in FLAT else Smooth(self.mesh.vertices, self.surface.faces, self.surface.normals)

    def visible(self, family: LineFamily, sample_pixels: float = 1.0) -> LineSet:
        """The lines of a family at threshold 0, hidden parts cut away.

        Contours are those along the outlines of the faces, and the outlines themselves where there is no line.

        Args:
            family: The family.
            sample_pixels: Distance along the picture of the points at which visibility is decided.
        """
        if family is LineFamily.CONTOURS:
            return self._face_outlines(sample_pixels).visible
        key = family, sample_pixels
        if key not in self._visible:
            self._visible[key] = self.unhidden(self.candidates(family), sample_pixels)
        return self._visible[key]

    def hidden(self, family: LineFamily, sample_pixels: float = 1.0) -> LineSet:
        """The lines of a family at threshold 0 that the surface hides: what is cut away of `visible`'s.

        Contours that are near no end of a face are none, here as there.

        Args:
            family: The family.
            sample_pixels: Distance along the picture of the points at which visibility is decided.
        """
        from ncmodel.scene.face_outlines import hidden_contours

        lines = self.behind(self.candidates(family), sample_pixels)
        if family is not LineFamily.CONTOURS:
            return lines
        found, boundaries = self._face_outlines(sample_pixels), self.candidates(LineFamily.BOUNDARIES)
        with timed(self.trace, "hidden_outlines"):
            return hidden_contours(lines, boundaries, found, self.surface.whole, self.camera, sample_pixels)

    def _face_outlines(self, sample_pixels: float) -> "FaceOutlines":
        """The visible contours, and what they lie on; on a surface parted at its creases, these are drawn, too."""
        from ncmodel.scene.face_outlines import face_outlines

        if sample_pixels not in self._outlined:
            whole, camera = self.surface.whole, self.camera
            contours = self.unhidden(self.outlines, sample_pixels)
            boundaries = self.visible(LineFamily.BOUNDARIES, sample_pixels)
            creases = self.visible(LineFamily.CREASES, sample_pixels) if whole is not self.surface else None
            with timed(self.trace, "polygonal_outlines"):
                found = face_outlines(contours, boundaries, creases, whole, camera, sample_pixels)
            self._outlined[sample_pixels] = found
        return self._outlined[sample_pixels]


def _contours(view: View) -> LineSet:
    return contours.contours(view.mesh.vertices, view.surface.faces, view.n_dot_v, view.kr)


def _suggestive(view: View) -> LineSet:
    vertices, faces, size = view.mesh.vertices, view.surface.faces, view.surface.feature_size
    return contours.suggestive_contours(vertices, faces, view.n_dot_v, view.kr, view.sc_num, size)


def _ridges(view: View) -> LineSet:
    return ridges.facing_only(view.surface.ridges_and_valleys[0], view.surface.faces, view.n_dot_v)


def _valleys(view: View) -> LineSet:
    return ridges.facing_only(view.surface.ridges_and_valleys[1], view.surface.faces, view.n_dot_v)


def _apparent(view: View) -> LineSet:
    vertices, faces, size = view.mesh.vertices, view.surface.faces, view.surface.feature_size
    derivative, direction = view.view_derivative
    return ridges.apparent_ridges(vertices, faces, view.q1, direction, derivative, size)


def _boundaries(view: View) -> LineSet:
    return view.surface.boundary_edges.lines(LineFamily.BOUNDARIES, view.mesh.vertices)


def _intersections(view: View) -> LineSet:
    return view.surface.intersections


def _creases(view: View) -> LineSet:
    return view.surface.creases(view.crease_angle).lines(LineFamily.CREASES, view.mesh.vertices)


_EXTRACTORS: dict[LineFamily, Callable[[View], LineSet]] = {
    LineFamily.CONTOURS: _contours,
    LineFamily.BOUNDARIES: _boundaries,
    LineFamily.CREASES: _creases,
    LineFamily.INTERSECTIONS: _intersections,
    LineFamily.SUGGESTIVE: _suggestive,
    LineFamily.APPARENT: _apparent,
    LineFamily.RIDGES: _ridges,
    LineFamily.VALLEYS: _valleys,
}

_FEATURES: dict[LineFamily, Callable[[View], Floats]] = {
    LineFamily.SUGGESTIVE: lambda view: view.sc_num,
    LineFamily.RIDGES: lambda view: np.ascontiguousarray(view.surface.k1),
    LineFamily.VALLEYS: lambda view: -view.surface.k1,
    LineFamily.APPARENT: lambda view: view.q1,
}
