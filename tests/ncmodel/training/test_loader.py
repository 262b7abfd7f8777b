"""Pictures read ahead by workers: in order, the same, errors as they are; training with them gives the same bytes."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import torch

from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair, read_pairs
from ncmodel.errors import InputError
from ncmodel.training.batches import PairPart, StoredPairs
from ncmodel.training.dataset import ViewImages
from ncmodel.training.loader import Loader
from tests.helpers.micro_training import run

pytestmark = pytest.mark.usefixtures("one_thread")


def tensors(loaded: StoredPairs) -> list[torch.Tensor]:
    return [loaded.batch.maps, loaded.batch.drawings, loaded.batch.view, loaded.better, loaded.worse, loaded.emphasis]


def test_workers_give_the_same_in_the_same_order_pass_after_pass(data: Path) -> None:
    images = ViewImages(DataFolder(data), (16, 32))
    pairs = read_pairs(data / "pairs.jsonl")
    parts = [PairPart(tuple(pairs[begin : begin + 5]), 32, {}) for begin in range(0, 40, 5)]
    missing = PairPart((Pair(Item("ghost", "0"), 0, 1, "train"),), 32, {})
    with Loader(images, 2) as loader:
        for order in (parts, parts[::-1]):
            for part, found in zip(order, loader.load(order), strict=True):
                for ours, plain in zip(tensors(found), tensors(part.load(images)), strict=True):
                    assert torch.equal(ours, plain)
        # A pass that is left early doesn't leak into the next one.
        next(loader.load(parts))
        (found,) = loader.load(parts[3:4])
        assert torch.equal(found.batch.maps, parts[3].load(images).batch.maps)
        with pytest.raises(InputError, match=r"ghost_0/depth.png: can't be read"):
            list(loader.load([*parts, missing]))


def test_training_with_workers_ends_in_the_same_bytes(data: Path, tmp_path: Path) -> None:
    for name, workers in (("without", 0), ("with", 1)):
        run(data, tmp_path / name, stages=("ranker",), epochs=2, workers=workers)
    for suffix in ("", ".ranker.state", ".history.json"):
        assert (tmp_path / f"without{suffix}").read_bytes() == (tmp_path / f"with{suffix}").read_bytes()


def test_workers_share_the_memory(data: Path) -> None:
    images = ViewImages(DataFolder(data), (32,), cache_bytes=900)
    images.maps(Item("s000", "0"), 32)
    one = images.for_one_of(3)
    assert not one._cache
    assert one.cache_bytes == 300
    assert settings_of(one) == settings_of(images)


def settings_of(images: ViewImages) -> tuple[object, ...]:
    return images.data.root, images.sizes, images.inputs, images.percentile


ENDLESS = """
import os, sys, time
from pathlib import Path
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.pairs import read_pairs
from ncmodel.training.batches import PairPart
from ncmodel.training.dataset import ViewImages
from ncmodel.training.loader import Loader

if __name__ == "__main__":
    data = Path(sys.argv[1])
    part = PairPart(tuple(read_pairs(data / "pairs.jsonl")[:5]), 16, {})
    loader = Loader(ViewImages(DataFolder(data), (16,)), 1)
    for _ in loader.load([part] * 10**6):
        children = [w.pid for w in loader._ahead._iterator._workers]
        print(*children, flush=True)
        time.sleep(1000)
"""


@pytest.mark.slow
def test_workers_end_with_a_training_that_was_killed(data: Path, tmp_path: Path) -> None:
    script = tmp_path / "endless.py"
    script.write_text(ENDLESS)
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[3])}
    with subprocess.Popen([sys.executable, script, data], env=environment, stdout=subprocess.PIPE) as training:
        assert training.stdout is not None
        worker = int(training.stdout.readline())
        os.kill(worker, 0)  # it is there
        training.send_signal(signal.SIGKILL)
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and Path(f"/proc/{worker}").exists():
        time.sleep(0.2)
    assert not Path(f"/proc/{worker}").exists()
