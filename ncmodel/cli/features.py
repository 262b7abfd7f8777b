"""`ncontours features`: the numbers behind a drawing, in one .npz file.

Keys, in the mesh's own vertex and face order, in object space (V vertices, F faces, n segments):

    vertices (V, 3), faces (F, 3)
    normals (V, 3), point_areas (V,)
    k1 k2 (V,)            principal curvatures, |k1| >= |k2|, convex positive
    dir1 dir2 (V, 3)      their directions; dir2 = normal x dir1
    dcurv (V, 4)          derivative of curvature: C111 C112 C122 C222 along dir1, dir2
    feature_size ()       what makes thresholds dimensionless, as rtsc samples it
    n_dot_v kr sc_num (V,)    cosine to the eye; radial curvature x sin^2; its derivative x sin
    q1 (V,), t1 (V, 2), dt1q1 (V,)    squared view-dependent curvature, its direction along dir1 and dir2, its
                                      derivative along that
    FAMILY_segments (n, 2, 3), FAMILY_strength (n, 2), FAMILY_face (n,)
                          for each of contours boundaries creases intersections suggestive ridges valleys apparent: end
                          points before hidden-line removal at threshold 0; dimensionless strength there (what a
                          threshold is compared with, at most 1e30; 1 for families without a threshold); the face they
                          lie on
"""

from pathlib import Path
from typing import Annotated

import typer

from ncmodel.cli.common import emit
from ncmodel.cli.limited import MemoryGb, Seconds, limited


@limited
def features(
    mesh: Annotated[
        Path, typer.Argument(help="Mesh file: obj, ply, stl, off, gltf, glb, 3mf, dae, step, iges; points: xyz.")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="The .npz file to write.")],
    camera: Annotated[Path, typer.Option(help="Camera file (JSON).")],
    up: Annotated[str, typer.Option(help="The file's upward axis, y or z.")] = "y",
    seconds: Seconds = None,
    memory_gb: MemoryGb = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print a JSON summary.")] = False,
) -> None:
    """Write curvature, per-view quantities and raw line segments of a mesh."""
    import numpy as np

    from ncmodel.camera import Camera
    from ncmodel.errors import UsageError
    from ncmodel.files import atomic
    from ncmodel.mesh.load import load_mesh
    from ncmodel.scene.feature_arrays import features as features_of
    from ncmodel.scene.surface import Surface
    from ncmodel.scene.view import View
    from ncmodel.types import LineFamily

    if output.suffix != ".npz":
        raise UsageError(f"--output: found {output.name!r}, expected a name that ends in .npz")
    seen_from = Camera.load(camera)
    loaded = load_mesh(mesh, up)
    view = View(Surface(loaded, sizing="sampled"), seen_from)
    arrays = features_of(view)
    with atomic(output) as aside:
        np.savez(aside, **arrays)  # type: ignore[arg-type]  # its stub takes our names for its own options
    record = {
        "output": str(output),
        "shape": loaded.name,
        "vertices": len(loaded.vertices),
        "faces": len(loaded.faces),
        "notes": list(loaded.notes),
        "feature_size": view.surface.feature_size,
        "segments": {family.value: len(view.lines(family)) for family in LineFamily},
        "seconds": view.trace.seconds(),
    }
    emit(record, as_json, f"{output}: {len(arrays)} arrays of {loaded.name}, {len(loaded.faces)} faces")
