"""A batch folder with a key."""

import json
from pathlib import Path

import pytest

from tests.helpers.results_files import KEY


@pytest.fixture
def batch(tmp_path: Path) -> Path:
    (tmp_path / "key.json").write_text(json.dumps(KEY.record()))
    return tmp_path
