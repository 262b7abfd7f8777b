"""Where everything in a data folder lies, which items it has, and how their views are opened."""

from pathlib import Path

import pytest

from ncmodel.camera import Camera
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.errors import InputError, MeshError
from tests.helpers.crowd_data import make_data


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> DataFolder:
    return DataFolder(make_data(tmp_path_factory.mktemp("data"), shapes=2, views=2))


@pytest.mark.parametrize(("name", "shape", "view"), [("cow_0", "cow", "0"), ("gear_2_11", "gear_2", "11")])
def test_a_name_is_its_shape_and_view(name: str, shape: str, view: str) -> None:
    assert Item.named(name) == Item(shape, view)
    assert Item.named(name).name == name


@pytest.mark.parametrize("name", ["cow", "cow_", "_0", "_", ""])
def test_other_names_are_no_items(name: str) -> None:
    with pytest.raises(ValueError, match="isn't SHAPE_VIEW"):
        Item.named(name)


def test_what_lies_in_a_data_folder_is_found(data: DataFolder) -> None:
    items = data.items()
    assert [item.name for item in items] == ["shape_0_0", "shape_0_1", "shape_1_0", "shape_1_1"]
    for item in items:
        paths = [data.mesh_path(item.shape), data.camera_path(item), data.selection_path(item)]
        paths += [*data.drawing_paths(item), *data.render_paths(item)]
        assert [path for path in paths if not path.is_file()] == []
        assert data.own_render(item).name == "1.png"
    assert [path.name for path in data.map_paths(items[0])] == ["depth.png", *(f"shaded_{i}.png" for i in range(6))]


def test_views_that_are_not_finished_are_no_items(tmp_path: Path) -> None:
    data = DataFolder(make_data(tmp_path, shapes=1, views=2))
    data.selection_path(Item("shape_0", "1")).unlink()
    for name in (".hidden_0", "notes", "_0", "shape_"):
        (data.views_folder / name).mkdir()
        (data.views_folder / name / "selection.json").touch()
    assert data.items() == [Item("shape_0", "0")]


def test_folders_without_items_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no finished view"):
        DataFolder(tmp_path).items()
    with pytest.raises(InputError, match="no such folder"):
        DataFolder(tmp_path / "nowhere").items()


def test_unknown_items_and_folders_are_named(data: DataFolder, tmp_path: Path) -> None:
    data.require(data.items(), "pairs.jsonl")
    with pytest.raises(InputError, match=r"pairs.jsonl: item 'x_0' is unknown"):
        data.require([Item("x", "0")], "pairs.jsonl")
    with pytest.raises(InputError, match="no folder 'views' in it"):
        DataFolder(tmp_path).require([], "pairs.jsonl")


def test_a_view_is_opened_with_its_mesh_and_camera(data: DataFolder) -> None:
    item = Item("shape_1", "0")
    view = data.open_view(item)
    assert view.camera == Camera.load(data.camera_path(item))
    assert view.surface.mesh.name == "shape_1"
    large = data.open_view(item, (192, 192))
    assert (large.camera.width, large.camera.height) == (192, 192)
    with pytest.raises(MeshError, match=r"shapes/nobody/mesh.ply"):
        data.load_mesh("nobody")


def test_a_view_folder_tells_its_data_folder_and_item(data: DataFolder) -> None:
    found, item = DataFolder.of_view(data.view_folder(Item("shape_1", "0")))
    assert (found.root, item) == (data.root, Item("shape_1", "0"))
    with pytest.raises(InputError, match="views/cow: a name that isn't SHAPE_VIEW"):
        DataFolder.of_view(data.views_folder / "cow")


def test_no_renders_are_an_error(data: DataFolder) -> None:
    with pytest.raises(InputError, match="no picture"):
        data.render_paths(Item("nobody", "0"))
