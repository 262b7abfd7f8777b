"""A small batch, and a site that serves it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from starlette.applications import Starlette

from dataset_tools.questionnaires.batch import make_batch
from dataset_tools.questionnaires.batch_folder import Look
from dataset_tools.questionnaires.questionnaire import Key, Scheme
from dataset_tools.questionnaires.sentinels import ArtistsFolder
from ncmodel.data.data_folder import DataFolder
from tests.helpers.crowd_data import make_artists, make_data
from tests.helpers.site_browser import ARGUMENTS, CHROMIUM
from tests.helpers.site_client import app


@pytest.fixture(scope="package")
def batch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Made once for all; who changes it changes a copy."""
    folder = tmp_path_factory.mktemp("site")
    data = make_data(folder / "data", shapes=6, views=1)
    artists = make_artists(folder / "artists", data)
    scheme = Scheme(real=3, sentinels=2, pool=4, votes=2)
    make_batch(
        data, folder / "batch", dict.fromkeys(DataFolder(data).items(), 2), scheme, Look(32, 32), ArtistsFolder(artists)
    )
    return folder / "batch"


@pytest.fixture
def key(batch: Path) -> Key:
    return Key.load(batch)


@pytest.fixture
def site(batch: Path, tmp_path: Path) -> Iterator[Starlette]:
    made = app(batch, tmp_path, completion_code="C0DE")
    yield made
    made.state.store.close()


@pytest.fixture(scope="package")
def browser() -> Iterator[Any]:
    import playwright.sync_api as playwright

    assert CHROMIUM.exists(), "these tests need chromium: apt-get install chromium"
    with playwright.sync_playwright() as runner:
        chromium = runner.chromium.launch(executable_path=str(CHROMIUM), args=ARGUMENTS)
        yield chromium
        chromium.close()


@pytest.fixture(scope="package")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("browser")
    data = make_data(folder / "data", shapes=8, views=1)
    make_artists(folder / "artists", data)
    return data
