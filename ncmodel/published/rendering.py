"""A view of a mesh of ours in the terms of the published code."""

from dataclasses import replace

import numpy as np

from ncmodel.camera import Camera
from ncmodel.geometry.feature_size import enclosing_radius, sampled_feature_size
from ncmodel.geometry.shading import interpolate
from ncmodel.model.maps import clipped_features, network_maps, unfiltered
from ncmodel.published.folder import HEIGHT, WIDTH, PublishedView
from ncmodel.scene.surface import Surface
from ncmodel.scene.view import View
from ncmodel.types import FILTERED_FAMILIES, LineFamily


def published_view(view: View) -> PublishedView:
    """Everything that the published code reads of a view, at the view's size."""
    hit, p90 = view.buffers.hit, np.array([view.feature_percentile(family, "mesh") for family in FILTERED_FAMILIES])
    lines = np.stack([unfiltered(view, family)[0] for family in FILTERED_FAMILIES])
    features = [clipped_features(view, f, unit) for f, unit in zip(FILTERED_FAMILIES, p90.tolist(), strict=True)]
    facing = interpolate(view.buffers, view.surface.faces, view.n_dot_v)
    n_dot_v = np.where(hit, np.clip(facing, 0.0, 1.0), 1.0).astype(np.float32)
    base = np.maximum(*(unfiltered(view, family)[0] for family in (LineFamily.CONTOURS, LineFamily.CREASES)))
    boundaries = unfiltered(view, LineFamily.BOUNDARIES)[0]
    size = published_feature_size(view.surface)
    return PublishedView(lines, np.stack(features), base, boundaries, n_dot_v, network_maps(view), p90, size)


def published_feature_size(surface: Surface) -> float:
    """Rtsc's feature size, from the vertices that its fixed random sequence picks."""
    return sampled_feature_size(surface.curvatures, enclosing_radius(surface.mesh.vertices))


def framed(camera: Camera) -> Camera:
    """The camera in the frame of the published pictures: as large as it fits in there, and in the middle."""
    scale = min(WIDTH / camera.width, HEIGHT / camera.height)
    return replace(camera.zoomed(camera.focal_pixels * scale), width=WIDTH, height=HEIGHT)
