"""A page of scribbles."""

import pytest

from ncmodel.export.page import Picture
from tests.helpers.pictures import scribbles


@pytest.fixture
def picture() -> Picture:
    return Picture(200, 200, scribbles(), line_width=6.0)
