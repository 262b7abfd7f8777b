"""Reading what training looks at: what it holds, what it costs, and what is wrong with bad files."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair, read_pairs, write_pairs
from ncmodel.errors import InputError
from ncmodel.images import read_grey
from ncmodel.nets.presets import Variation
from ncmodel.training.batches import Pose, draw_poses, even_chunks, load_batch, load_pairs, pair_chunks, shrink
from ncmodel.training.dataset import ViewImages, read_training_pairs
from tests.helpers.training_data import SIDE, make_data

CPU = torch.device("cpu")


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("data")
    make_data(root, shapes=3, held_out=1)
    return root


def test_pairs_that_are_all_held_out_are_nothing_to_train_on(tmp_path: Path) -> None:
    pair = Pair(Item("s000", "0"), 1, 2, "train")
    write_pairs(tmp_path / "pairs.jsonl", [pair])
    assert read_training_pairs(tmp_path / "pairs.jsonl") == [pair]
    for count in (0, 1):
        write_pairs(tmp_path / "held", [replace(pair, split="validation")] * count)
        with pytest.raises(InputError, match=f"held: {count} pairs, none to train on"):
            read_training_pairs(tmp_path / "held")


def test_maps_and_drawings_are_fitted_into_squares(data: Path) -> None:
    folder, item = ViewImages(DataFolder(data), (32, 48)), Item("s001", "1")
    maps, drawing = folder.maps(item, 48), folder.drawing(item, 2, 32)
    assert maps.shape == (7, 48, 48)
    assert drawing.shape == (32, 32)
    assert maps[:, 0, 0].tolist() == [1.0] * 7
    assert drawing[0, 0] == 0.0
    raw = read_grey(data / "views" / "s001_1" / "depth.png")
    np.testing.assert_allclose(maps[0], raw.reshape(48, 2, 48, 2).mean(axis=(1, 3)), atol=2e-5)
    ink = 1 - read_grey(data / "views" / "s001_1" / "drawings" / "2.png")
    assert drawing.mean() == pytest.approx(ink.mean(), abs=1e-5)


def test_memory_stays_within_the_cache(data: Path) -> None:
    items = [Item(f"s{shape:03d}", str(view)) for shape in range(3) for view in range(2)]
    unbounded = ViewImages(DataFolder(data), (SIDE,))
    first = [unbounded.maps(item, SIDE) for item in items]
    kept = [len(image) for images in unbounded._cache.values() for image in images.values()]
    assert len(kept) == 7 * len(items)
    bound = 4 * max(kept)
    folder = ViewImages(DataFolder(data), (SIDE,), cache_bytes=bound)
    for _ in range(2):
        for item, maps in zip(items, first, strict=True):
            np.testing.assert_array_equal(folder.maps(item, SIDE), maps)
            np.testing.assert_array_equal(unbounded.maps(item, SIDE), maps)
            assert sum(len(image) for images in folder._cache.values() for image in images.values()) <= bound
    assert len(folder._cache) >= 4


def test_kept_views_are_compressed(data: Path) -> None:
    folder = ViewImages(DataFolder(data), (SIDE,))
    folder.drawing(Item("s000", "0"), 3, SIDE)
    (kept,) = folder._cache.values()
    assert len(kept[SIDE]) < 0.2 * 2 * SIDE * SIDE


def test_a_cache_too_small_for_anything_still_works(data: Path) -> None:
    folder = ViewImages(DataFolder(data), (16,), cache_bytes=0)
    assert folder.maps(Item("s000", "0"), 16).shape == (7, 16, 16)
    assert len(folder._cache) == 1


def test_damaged_pictures_are_named(tmp_path: Path) -> None:
    make_data(tmp_path, shapes=1, views=1)
    folder, view = ViewImages(DataFolder(tmp_path), (16,)), tmp_path / "views" / "s000_0"
    (view / "depth.png").write_bytes((view / "depth.png").read_bytes()[:200])
    with pytest.raises(InputError, match=r"s000_0/depth.png: .*damaged"):
        folder.maps(Item("s000", "0"), 16)
    (view / "drawings" / "3.png").unlink()
    with pytest.raises(InputError, match=r"s000_0/drawings/3.png: can't be read"):
        folder.drawing(Item("s000", "0"), 3, 16)


@pytest.mark.parametrize(("count", "size"), [(1, 32), (31, 32), (100, 32), (7, 2), (623, 32)])
def test_chunks_hold_everything_once_and_are_even(count: int, size: int) -> None:
    chunks = even_chunks(list(range(count)), size)
    assert [value for chunk in chunks for value in chunk] == list(range(count))
    lengths = {len(chunk) for chunk in chunks}
    assert max(lengths) - min(lengths) <= 1
    assert 0.5 * min(size, count) < max(lengths) <= 1.5 * size


def test_an_epoch_holds_every_pair_once_in_an_order_of_its_own(data: Path) -> None:
    pairs = read_pairs(data / "pairs.jsonl")
    first, again, other = (
        [pair for chunk in pair_chunks(pairs, 10, np.random.default_rng(seed)) for pair in chunk] for seed in (1, 1, 2)
    )
    assert first == again != other
    assert sorted(map(repr, first)) == sorted(map(repr, pairs))


def test_a_drawing_that_is_in_many_pairs_is_loaded_once(data: Path) -> None:
    pairs = [pair for pair in read_pairs(data / "pairs.jsonl") if pair.item.shape == "s001"]
    loaded = load_pairs(ViewImages(DataFolder(data), (16,)), pairs, 16).on(CPU)
    assert loaded.batch.maps.shape == (2, 7, 16, 16)
    assert loaded.batch.drawings.shape == (16, 1, 16, 16)
    folder = ViewImages(DataFolder(data), (16,))
    for pair, better, worse in zip(pairs, loaded.better.tolist(), loaded.worse.tolist(), strict=True):
        for index, place in ((pair.better, better), (pair.worse, worse)):
            np.testing.assert_array_equal(loaded.batch.drawings[place, 0].numpy(), folder.drawing(pair.item, index, 16))
    assert loaded.batch.view.tolist() == [0] * 8 + [1] * 8


def test_variation_moves_maps_and_drawings_together(data: Path) -> None:
    item = Item("s002", "0")
    folder = ViewImages(DataFolder(data), (SIDE,), inputs=("depth",))
    plain = load_batch(folder, [(item, 0)], SIDE).on(CPU)
    seen = set()
    for seed in range(40):
        poses = draw_poses([item], Variation(quarter_turns=True), SIDE, np.random.default_rng(seed))
        varied = load_batch(folder, [(item, 0)], SIDE, poses).on(CPU)
        for varied_one, plain_one in ((1.0 - varied.maps, 1.0 - plain.maps), (varied.drawings, plain.drawings)):
            undone = _undone(poses[item], varied_one[0, 0])
            torch.testing.assert_close(undone, plain_one[0, 0])  # the margin keeps all in frame
        seen.add(varied.drawings.numpy().tobytes())
    assert len(seen) >= 35


def _undone(pose: Pose, image: torch.Tensor) -> torch.Tensor:
    """A picture with nothing at its rim, back from its pose."""
    back = image.roll((-pose.down, -pose.right), (0, 1))
    back = back.flip(-1) if pose.mirror else back
    return back.rot90(-pose.turns, (0, 1))


@pytest.mark.parametrize(
    ("variation", "expected"),
    [
        (Variation(mirror=True, quarter_turns=True, shift=0), range(8)),
        (Variation(mirror=True, shift=0), (0, 1)),
        (Variation(mirror=False, quarter_turns=True, shift=0), (0, 2, 4, 6)),
        (Variation(mirror=False, shift=0), (0,)),
    ],
)
def test_poses_are_those_that_the_variation_allows(data: Path, variation: Variation, expected: Sequence[int]) -> None:
    folder, item = ViewImages(DataFolder(data), (32,)), Item("s002", "0")
    image = load_batch(folder, [(item, 0)], 32).on(CPU).drawings[0, 0]
    poses = [turned for turns in range(4) for turned in (image.rot90(turns), image.rot90(turns).flip(-1))]
    counts = [0] * 8
    for seed in range(80):
        drawn = draw_poses([item], variation, 32, np.random.default_rng(seed))
        varied = load_batch(folder, [(item, 0)], 32, drawn).on(CPU).drawings[0, 0]
        (found,) = [number for number, pose in enumerate(poses) if torch.equal(pose, varied)]
        counts[found] += 1
    assert [count > 0 for count in counts] == [number in expected for number in range(8)]


def test_variation_is_the_seeds() -> None:
    items = [Item(f"s{shape:03d}", "0") for shape in range(5)]
    drawn = [draw_poses(items, Variation(quarter_turns=True), 32, np.random.default_rng(seed)) for seed in (9, 9, 8)]
    assert drawn[0] == drawn[1] != drawn[2]


def test_shrinking_averages() -> None:
    images = torch.rand(2, 3, 12, 12)
    expected = images.reshape(2, 3, 4, 3, 4, 3).mean(dim=(3, 5))
    torch.testing.assert_close(shrink(images, 4), expected)
    assert shrink(images, 12) is images
    with pytest.raises(ValueError, match="12 can't be averaged to side 5"):
        shrink(images, 5)
