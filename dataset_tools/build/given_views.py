"""Views through cameras of one's own, beside those that a build chooses: where people drew from."""

import unicodedata
from collections.abc import Callable, Iterator
from pathlib import Path

from dataset_tools.build.config import BuildConfig
from dataset_tools.build.store import Store
from dataset_tools.build.tasks import files_through
from ncmodel.camera import Camera
from ncmodel.config import read_config
from ncmodel.data.item import Item
from ncmodel.errors import InputError
from ncmodel.scene.surface import Surface


def add_views(data_dir: str | Path, cameras: Path, advance: Callable[[str], None]) -> list[Item]:
    """Add the views of camera files SHAPE_VIEW.json to a data folder that has their shapes; those it has stay.

    Args:
        data_dir: A built data folder.
        cameras: The folder of camera files, in object space.
        advance: Is told about every view.

    Raises:
        InputError: It isn't a data folder, a shape isn't in it, or a camera can't be read.
    """
    store = Store(data_dir)
    if not store.config_path.is_file():
        raise InputError(data_dir, "no config.toml in it", "a folder made by `ncontours dataset build`")
    config = read_config(BuildConfig, store.config_path)
    found = list(_items(cameras))
    for item, path in found:
        if (store.shape_record(item.shape) or {}).get("status") != "done":
            raise InputError(path, f"a view of {item.shape}, which {data_dir} hasn't", "views of its shapes")
    with store.locked():
        for item, path in found:
            mesh, folder = store.mesh_checksum(item.shape), store.view_folder(item)
            camera = Camera.load(path)
            if store.origin(folder) != mesh or Camera.load(store.camera_path(item)) != camera:
                surface = Surface(store.load_mesh(item.shape))
                aside = [camera.turned(angle).resized(*_small(camera, config)) for angle in config.render_azimuths]
                store.write_folder(folder, files_through(surface, camera, aside, config), mesh)
            advance(item.name)
    return [item for item, _ in found]


def count_cameras(cameras: Path) -> int:
    """How many views a folder of camera files has.

    Raises:
        InputError: There is no such folder, or none in it.
    """
    return len(list(_items(cameras)))


def _items(cameras: Path) -> Iterator[tuple[Item, Path]]:
    paths = sorted(cameras.glob("*.json")) if cameras.is_dir() else []
    if not paths:
        raise InputError(cameras, "no camera file in it", "a folder of camera files, SHAPE_VIEW.json each")
    for path in paths:
        try:
            yield Item.named(unicodedata.normalize("NFC", path.stem)), path
        except ValueError as error:
            raise InputError(path, str(error), "a name SHAPE_VIEW.json") from error


def _small(camera: Camera, config: BuildConfig) -> tuple[int, int]:
    """The size of the pictures that participants see of a view."""
    scale = config.render_size / max(camera.width, camera.height)
    return max(1, round(scale * camera.width)), max(1, round(scale * camera.height))
