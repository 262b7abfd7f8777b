"""The API pages show the docstrings."""

from pathlib import Path

import pytest

from docs.build_api import build


@pytest.mark.filterwarnings("ignore:Error parsing type annotation")
def test_public_names_are_documented_where_users_import_them(tmp_path: Path) -> None:
    build(tmp_path, "ncmodel", r"!ncmodel\..+")
    page = (tmp_path / "ncmodel.html").read_text(encoding="utf-8")
    assert "learned line drawings of 3D shapes" in page
    assert 'id="draw_shape"' in page
    assert "that has the shape in its frame" in page
    assert 'id="Drawing.save"' in page
