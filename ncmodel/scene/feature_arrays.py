"""Everything that a view's lines are made from, as named arrays."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ncmodel.scene.view import View
from ncmodel.types import LineFamily

MOST = 1e30
"""Strengths are held within this: a suggestive contour that runs into an occluding one has an infinite strength."""


def features(view: View) -> dict[str, NDArray[Any]]:
    """Arrays by name: the quantities per vertex, and segments, strength and face per family of lines.

    Lines are those at threshold 0, before hidden-line removal; their order is that of the faces.
    """
    surface = view.surface
    arrays: dict[str, NDArray[Any]] = {
        "vertices": view.mesh.vertices,
        "faces": view.mesh.faces,
        "normals": surface.normals,
        "point_areas": surface.point_areas,
        "k1": surface.k1,
        "k2": surface.k2,
        "dir1": surface.dir1,
        "dir2": surface.dir2,
        "dcurv": surface.dcurv,
        "feature_size": np.asarray(surface.feature_size),
        "n_dot_v": view.n_dot_v,
        "kr": view.kr,
        "sc_num": view.sc_num,
        "q1": view.q1,
        "t1": view.t1,
        "dt1q1": view.dt1q1,
    }
    for family in LineFamily:
        lines = view.lines(family)
        arrays[f"{family}_segments"] = lines.points
        arrays[f"{family}_strength"] = np.clip(lines.strength, -MOST, MOST)
        arrays[f"{family}_face"] = lines.face
    return arrays
