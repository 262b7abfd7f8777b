"""A view for all tests of lines."""

import pytest

from ncmodel.scene.view import View
from tests.helpers.views import bumpy, seen


@pytest.fixture(scope="module")
def view() -> View:
    """A mesh with lines of every family."""
    return seen(bumpy(0.3, 20.0))
