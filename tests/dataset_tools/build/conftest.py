"""A finished build, and a copy of it to spoil."""

from pathlib import Path

import pytest

from dataset_tools.build.build import Summary
from tests.helpers.builds import build, contents, make_meshes


@pytest.fixture(scope="module")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_meshes(tmp_path_factory.mktemp("build") / "meshes")


@pytest.fixture(scope="module")
def reference(meshes: Path) -> tuple[Path, Summary]:
    """An uninterrupted build in one process."""
    folder = meshes.parent / "reference"
    return folder, build(meshes, folder)


@pytest.fixture
def copy(reference: tuple[Path, Summary], tmp_path: Path) -> Path:
    """A data folder to spoil."""
    for name, data in contents(reference[0]).items():
        path = tmp_path / "copy" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    (tmp_path / "copy" / "index.csv").write_bytes((reference[0] / "index.csv").read_bytes())
    return tmp_path / "copy"
