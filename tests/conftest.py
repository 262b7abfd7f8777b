"""Fixtures that several test modules use."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

# How long an example takes depends on what else the machine does.
settings.register_profile("unhurried", deadline=None)
settings.load_profile("unhurried")

SHARED = Path(__file__).resolve().parents[2] / "shared"


def pytest_addoption(parser: pytest.Parser) -> None:
    """An option to draw the stored drawings anew."""
    parser.addoption("--update-golden", action="store_true", help="Write the drawings in tests/golden anew.")


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of reference numbers and real meshes beside the project; tests that need it skip without it."""
    if not (SHARED / "reference").is_dir():
        pytest.skip("the folder of reference material is not beside the project")
    return SHARED


@pytest.fixture(scope="session")
def bundled() -> Path:
    """The folder of sample meshes inside the installed pymeshlab."""
    import pymeshlab

    folder = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes"
    assert folder.is_dir(), f"pymeshlab bundles its sample meshes at {folder}"
    return folder


@pytest.fixture(scope="module")
def one_thread() -> Iterator[None]:
    """Tests run side by side; threads of networks that wait for each other would make all of them slow."""
    import torch

    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)
