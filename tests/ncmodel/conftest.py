"""Fixtures that several folders use."""

from pathlib import Path

import pytest

from tests.helpers.training_data import make_data


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A made-up data folder with pairs, to train on in moments."""
    root = tmp_path_factory.mktemp("data")
    make_data(root, shapes=4, held_out=1)
    return root
