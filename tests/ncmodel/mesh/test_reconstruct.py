"""Points into surfaces."""

from pathlib import Path

import numpy as np
import pytest

from ncmodel.mesh.load import load_mesh
from ncmodel.mesh.reconstruct import reconstruct
from ncmodel.types import Floats
from tests.helpers import analytic
from tests.helpers.dirty import signed_volume
from tests.helpers.mesh_files import PLY_HEADER


def test_point_clouds_become_surfaces(tmp_path: Path) -> None:
    """Points of a torus: a surface of its volume, outwards, said in the notes."""
    points, _ = analytic.torus(60, 30)
    rows = "\n".join(f"{x:.9g} {y:.9g} {z:.9g}" for x, y, z in points)
    header = PLY_HEADER.format(format="ascii", v=len(points), f=0).split("element face")[0] + "end_header\n"
    (tmp_path / "cloud.ply").write_text(header + rows)
    mesh = load_mesh(tmp_path / "cloud.ply")
    assert signed_volume(mesh.vertices, mesh.faces) == pytest.approx(2 * np.pi**2 * 0.355 * 0.145**2, rel=0.03)
    assert mesh.notes == (f"reconstructed {len(mesh.faces)} faces from points (screened Poisson)",)
    (tmp_path / "cloud.xyz").write_text("# x y z nx ny nz\n" + rows.replace("\n", " 0 0 1\n\n") + " 0 0 1 # last")
    np.testing.assert_array_equal(load_mesh(tmp_path / "cloud.xyz").vertices, mesh.vertices)
    (tmp_path / "cloud.obj").write_text("v " + rows.replace("\n", "\nv "))
    np.testing.assert_array_equal(load_mesh(tmp_path / "cloud.obj").vertices, mesh.vertices)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.zeros((100, 3)), "1 distinct points"),
        (np.linspace(0, 1, 300).reshape(-1, 1) * np.ones(3), "on a line"),
        (np.full((100, 3), np.nan), "finite"),
    ],
)
def test_points_without_a_surface(points: Floats, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        reconstruct(points)
