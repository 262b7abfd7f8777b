"""Views through cameras of one's own, in a data folder that was built."""

from pathlib import Path

import pytest

from dataset_tools.build.given_views import add_views
from ncmodel.camera import Camera
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.errors import InputError
from ncmodel.images import read_grey
from tests.helpers.builds import build, contents, make_meshes
from tests.helpers.commands import printed


def test_cameras_become_views_beside_those_that_were_chosen(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    build(make_meshes(tmp_path / "meshes"), tmp_path / "data")
    data = DataFolder(tmp_path / "data")
    before = contents(data.views_folder)
    camera = Camera.orbit(data.load_mesh("ball").used_vertices, 77.0, 12.0, size=(80, 60))
    (tmp_path / "cameras").mkdir()
    (tmp_path / "cameras" / "ball_ann-2.json").write_text(camera.to_json())
    assert printed(capsys, "dataset", "views", data.root, tmp_path / "cameras") == {"views": ["ball_ann-2"]}
    item = Item("ball", "ann-2")
    assert Camera.load(data.camera_path(item)) == camera
    assert item in data.items()
    assert read_grey(data.drawing_path(item, 0)).shape == (60, 80)
    after = contents(data.views_folder)
    assert {name: data for name, data in after.items() if not name.startswith("ball_ann-2")} == before
    made = data.selection_path(item).stat().st_mtime_ns
    add_views(data.root, tmp_path / "cameras", lambda _: None)
    assert data.selection_path(item).stat().st_mtime_ns == made, "what is there stays"
    build(tmp_path / "meshes", data.root)
    assert contents(data.views_folder) == after, "another build leaves it alone"
    (tmp_path / "cameras" / "teapot_0.json").write_text(camera.to_json())
    with pytest.raises(InputError, match="a view of teapot"):
        add_views(data.root, tmp_path / "cameras", lambda _: None)
