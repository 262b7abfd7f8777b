"""`ncontours features`: its keys, its numbers, its errors."""

import json
from pathlib import Path

import numpy as np
import pytest

from ncmodel.camera import Camera
from ncmodel.cli.main import main
from ncmodel.scene.feature_arrays import features
from ncmodel.types import LineFamily
from tests.helpers import analytic
from tests.helpers.golden_features import GOLDEN, golden_view
from tests.helpers.mesh_files import write_obj
from tests.helpers.segments import agreement

PER_MESH = {
    "vertices": ("V", 3),
    "faces": ("F", 3),
    "normals": ("V", 3),
    "point_areas": ("V",),
    "k1": ("V",),
    "k2": ("V",),
    "dir1": ("V", 3),
    "dir2": ("V", 3),
    "dcurv": ("V", 4),
    "feature_size": (),
    "n_dot_v": ("V",),
    "kr": ("V",),
    "sc_num": ("V",),
    "q1": ("V",),
    "t1": ("V", 2),
    "dt1q1": ("V",),
}
UP_TO_SIGN = {"dir1", "dir2", "dcurv", "t1", "dt1q1"}


@pytest.fixture
def files(tmp_path: Path) -> Path:
    write_obj(tmp_path / "torus.obj", analytic.torus(24, 12))
    (tmp_path / "camera.json").write_text(Camera((1.3, 1.1, 2.4)).to_json())
    return tmp_path


def test_keys_and_shapes(files: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = files / "f.npz"
    arguments = ["features", str(files / "torus.obj"), "--camera", str(files / "camera.json"), "-o", str(out), "--json"]
    assert main(arguments) == 0
    summary = json.loads(capsys.readouterr().out)
    arrays = dict(np.load(out))
    sizes: dict[str | int, int] = {"V": 24 * 12, "F": 2 * 24 * 12, 2: 2, 3: 3, 4: 4}
    for key, shape in PER_MESH.items():
        assert arrays.pop(key).shape == tuple(sizes[n] for n in shape), key
    for family in LineFamily:
        count = summary["segments"][family.value]
        assert arrays.pop(f"{family}_segments").shape == (count, 2, 3)
        strength, face = arrays.pop(f"{family}_strength"), arrays.pop(f"{family}_face")
        assert strength.shape == (count, 2)
        assert face.shape == (count,)
        assert np.isfinite(strength).all()
        assert (strength >= 0).all()
    assert arrays == {}
    assert (summary["vertices"], summary["faces"]) == (288, 576)
    assert summary["seconds"]["curvature"] > 0


def test_same_input_same_bytes(files: Path) -> None:
    for name in ("a.npz", "b.npz"):
        arguments = ["features", str(files / "torus.obj"), "--camera", str(files / "camera.json")]
        assert main([*arguments, "-o", str(files / name)]) == 0
    assert (files / "a.npz").read_bytes() == (files / "b.npz").read_bytes()


def test_up(files: Path) -> None:
    arguments = ["features", str(files / "torus.obj"), "--camera", str(files / "camera.json"), "--up", "z"]
    assert main([*arguments, "-o", str(files / "f.npz")]) == 0
    extent = np.ptp(np.load(files / "f.npz")["vertices"], axis=0)
    np.testing.assert_allclose(extent, [1, 1, 0.29], atol=1e-12)


def test_strength_is_made_dimensionless() -> None:
    """fs^2 DwKr tan(theta), fs |k1| and fs^2 q1: scaled meshes from scaled eyes have the same."""
    arrays = features(golden_view())
    size = float(arrays["feature_size"])
    for family in ("ridges", "valleys"):
        assert arrays[f"{family}_strength"].max() <= size * np.abs(arrays["k1"]).max() * (1 + 1e-12)
    assert arrays["apparent_strength"].max() <= size**2 * arrays["q1"].max() * (1 + 1e-12)
    assert (arrays["contours_strength"] == 1).all()


def test_golden_numbers() -> None:
    """What was stored once, in single precision: quantities by value, segments one for one; nothing is pierced."""
    found, expected = features(golden_view()), dict(np.load(GOLDEN))
    assert [len(found.pop(f"intersections_{what}")) for what in ("segments", "strength", "face")] == [0, 0, 0]
    assert set(found) == set(expected)
    for key in PER_MESH:
        a, b = found[key], expected[key]
        if key in UP_TO_SIGN:
            a, b = np.abs(a), np.abs(b)
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-6 * np.abs(b).max(), err_msg=key)
    for family in set(LineFamily) - {LineFamily.INTERSECTIONS}:
        pairs = [(arrays[f"{family}_face"], arrays[f"{family}_segments"]) for arrays in (found, expected)]
        assert len(pairs[1][0]) > 0, family
        assert agreement(*pairs[0], *pairs[1], 1e-6) == 1, family


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("features absent.obj --camera camera.json -o f.npz", "absent.obj: no such file"),
        ("features torus.obj --camera absent.json -o f.npz", "absent.json"),
        ("features torus.obj --camera torus.obj -o f.npz", "torus.obj: not JSON"),
        ("features torus.obj --camera camera.json -o f.txt", "expected a name that ends in .npz"),
        ("features torus.obj --camera camera.json -o absent/f.npz", "absent"),
        ("features torus.obj --camera camera.json -o f.npz --up x", "--up: found 'x'"),
        ("features torus.obj -o f.npz", "--camera"),
    ],
)
def test_bad_input(
    arguments: str,
    message: str,
    files: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(files)
    assert main(arguments.split()) == 2
    captured = capsys.readouterr()
    assert message in captured.err
    assert captured.out == ""
    assert len(captured.err.strip().splitlines()) == 1
    assert not (files / "f.npz").exists()
