"""Shapes to test on that a data folder has already, turned and scaled, are told."""

from pathlib import Path

import numpy as np
import pytest

from ncmodel.readers.ply import ply_bytes
from ncmodel.types import Mesh
from tests.helpers.builds import build, make_meshes
from tests.helpers.commands import complaint, printed
from tests.helpers.dirty import sphere


def test_a_shape_that_is_there_again_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    build(make_meshes(tmp_path / "meshes"), tmp_path / "data")
    (tmp_path / "test").mkdir()
    vertices, faces = sphere(fineness=2)
    pear = vertices * (1 + 0.4 * vertices[:, 1:2] ** 3) * [1.0, 1.5, 0.8]
    (tmp_path / "test" / "pear.ply").write_bytes(ply_bytes(Mesh(pear, faces)))
    record = printed(capsys, "dataset", "disjoint", tmp_path / "test", tmp_path / "data")
    assert record == {"meshes": 1, "duplicates": []}
    bumpy = vertices * (1 + 0.2 * np.sin(5 * vertices[:, :1]))
    c, s = np.cos(0.7), np.sin(0.7)
    turned = 3.0 * bumpy @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]) + [1.0, 2.0, 3.0]
    (tmp_path / "test" / "zeppelin.ply").write_bytes(ply_bytes(Mesh(turned, faces)))
    said = complaint(capsys, "dataset", "disjoint", tmp_path / "test", tmp_path / "data", status=1)
    assert "zeppelin is odd_bumpy again (" in said
    assert "pear" not in said
