"""Training: it learns, it resumes exactly, its checkpoints say what they hold, and bad ones are refused in one line."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import safetensors.torch
import torch

from ncmodel.cli.main import main
from ncmodel.errors import InputError, UsageError
from ncmodel.nets.blocks import initialise
from ncmodel.nets.checkpoints import (
    MODEL_KIND,
    Checkpoint,
    load_checkpoint,
    load_tensors,
    save_checkpoint,
    save_tensors,
)
from ncmodel.nets.presets import PRESETS, Preset, RankingDims, Rates, TranslationDims
from ncmodel.nets.ranking import RankingModule
from ncmodel.nets.translation import TranslationBranch
from ncmodel.progress import Advance
from ncmodel.training import train as training
from ncmodel.training.batches import load_pairs
from ncmodel.training.dataset import DataFolder, read_pairs
from ncmodel.training.loop import STATE_KIND
from ncmodel.training.objectives import finetune_losses
from ncmodel.training.train import TrainOptions, run_training
from tests.helpers.training_data import make_data

MICRO = Preset(
    "micro",
    TranslationDims(size=32, width=2, levels=2, blocks=1),
    RankingDims(size=32, width=2, blocks=(1, 1)),
    ranker=Rates(1e-3, batch=16, epochs=3),
    translator=Rates(1e-3, batch=2, epochs=3),
    finetune=Rates(1e-4, batch=16, epochs=2),
)
"""Small enough to train in moments; what is tested with it doesn't depend on size."""


@pytest.fixture(autouse=True, scope="module")
def one_thread() -> Iterator[None]:
    """Tests run side by side; threads that wait for each other would make all of them slow."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("data")
    make_data(root, shapes=4, held_out=1)
    return root


@pytest.fixture
def micro(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(PRESETS, "micro", MICRO)


def run(data: Path, out: Path, **options: object) -> training.TrainReport:
    return run_training(data, data / "pairs.jsonl", out, MICRO, TrainOptions(**options))  # type: ignore[arg-type]


class Interrupted(Exception):
    pass


@contextmanager
def stop_after(passes: int) -> Iterator[Advance]:
    """Progress that breaks off after some passes, as a kill would: after the state has been written."""
    left = passes

    def advance(note: str = "") -> None:
        nonlocal left
        left -= 1
        if left == 0:
            raise Interrupted

    yield advance


def test_all_stages_write_a_checkpoint_a_history_and_states(data: Path, tmp_path: Path) -> None:
    out = tmp_path / "m.ckpt"
    report = run(data, out)
    assert [(stage.stage, stage.epochs) for stage in report.stages] == [
        ("ranker", 3),
        ("translator", 3),
        ("finetune", 2),
    ]
    assert report.pairs == {"train": 3 * 2 * 7, "validation": 2 * 7}
    loaded = load_checkpoint(out)
    assert loaded.preset == MICRO
    assert list(loaded.networks) == ["ranker", "translator"]
    assert set(loaded.training["stages"]) == {"ranker", "translator", "finetune"}
    history = json.loads((tmp_path / "m.ckpt.history.json").read_text())
    assert history == report.history
    assert [record["epoch"] for record in history["ranker"]] == [1, 2, 3]
    assert set(history["finetune"][0]) == {"epoch", "loss", "accuracy", "hinge", "cross_entropy"}
    assert not list(tmp_path.glob(".tmp*"))


def test_the_same_seed_gives_the_same_bytes_and_another_one_others(data: Path, tmp_path: Path) -> None:
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        run(data, tmp_path / name, stages=("ranker",), seed=seed)
    a, b, c = ((tmp_path / name).read_bytes() for name in "abc")
    assert a == b != c


@pytest.mark.parametrize("stage", ["ranker", "translator", "finetune"])
def test_interrupted_and_resumed_equals_uninterrupted(data: Path, tmp_path: Path, stage: str) -> None:
    whole, broken = tmp_path / "whole", tmp_path / "broken"
    before = ("ranker", "translator") if stage == "finetune" else ()
    for out in (whole, broken):
        if before:
            run(data, out, stages=before)
    run(data, whole, stages=(stage,))
    options = TrainOptions(stages=(stage,))
    with pytest.raises(Interrupted):
        run_training(data, data / "pairs.jsonl", broken, MICRO, options, lambda title, total: stop_after(1))
    run(data, broken, stages=(stage,))
    for suffix in ("", ".history.json", f".{stage}.state"):
        assert whole.with_name(f"whole{suffix}").read_bytes() == broken.with_name(f"broken{suffix}").read_bytes()


def test_more_epochs_go_on_where_fewer_ended(data: Path, tmp_path: Path) -> None:
    run(data, tmp_path / "whole", stages=("ranker",), epochs=4)
    for epochs in (1, 3, 4):
        report = run(data, tmp_path / "steps", stages=("ranker",), epochs=epochs)
        assert report.stages[0].epochs == epochs
    assert (tmp_path / "whole").read_bytes() == (tmp_path / "steps").read_bytes()


def test_a_finished_training_is_left_as_it_is(data: Path, tmp_path: Path) -> None:
    out = tmp_path / "m.ckpt"
    first = run(data, out)
    files = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    again = run(data, out)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == files
    assert again.history == first.history
    # A stage on its own doesn't take back what was finetuned after it.
    run(data, out, stages=("ranker",))
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == files


def test_training_a_stage_further_voids_what_was_finetuned_on_it(data: Path, tmp_path: Path) -> None:
    out = tmp_path / "m.ckpt"
    run(data, out)
    run(data, out, stages=("ranker",), epochs=4)
    assert set(load_checkpoint(out).training["stages"]) == {"ranker", "translator"}
    assert not out.with_name("m.ckpt.finetune.state").exists()


def test_stages_can_be_trained_one_by_one(data: Path, tmp_path: Path) -> None:
    run(data, tmp_path / "once", epochs=1)
    for stage in ("ranker", "translator", "finetune"):
        run(data, tmp_path / "steps", stages=(stage,), epochs=1)
    assert (tmp_path / "once").read_bytes() == (tmp_path / "steps").read_bytes()


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs cuda")
def test_a_gpu_learns_what_a_cpu_learns(data: Path, tmp_path: Path) -> None:
    on_cpu, on_gpu = (run(data, tmp_path / device, device=device) for device in ("cpu", "cuda"))
    for stage in ("ranker", "translator"):
        losses = [[record["loss"] for record in report.history[stage]] for report in (on_cpu, on_gpu)]
        np.testing.assert_allclose(losses[0], losses[1], rtol=0.05)
    assert next(iter(load_checkpoint(tmp_path / "cuda").networks["ranker"].parameters())).device.type == "cpu"


def test_a_time_budget_ends_training_early(data: Path, tmp_path: Path) -> None:
    report = run(data, tmp_path / "m.ckpt", epochs=10**6, seconds=0.2)
    assert all(1 <= stage.epochs < 10**5 for stage in report.stages)


def test_finetuning_that_does_not_help_keeps_what_it_started_from(data: Path, tmp_path: Path) -> None:
    preset = replace(MICRO, finetune=Rates(0.3, batch=16, epochs=2))
    report = run_training(data, data / "pairs.jsonl", tmp_path / "m", preset, TrainOptions())
    ranker, translator, finetune = report.stages
    assert finetune.best_epoch == 0
    assert finetune.validation == pytest.approx({**ranker.validation, **translator.validation})
    assert min(r["hinge"] + r["cross_entropy"] for r in report.history["finetune"]) > sum(
        finetune.validation[name] for name in ("hinge", "cross_entropy")
    )


def test_a_training_that_diverges_ends_in_one_line(data: Path, tmp_path: Path) -> None:
    preset = replace(MICRO, ranker=Rates(1e30, batch=16, epochs=3))
    with pytest.raises(UsageError, match=r"training of the ranker diverged in pass \d: the loss is (nan|inf)"):
        run_training(data, data / "pairs.jsonl", tmp_path / "m", preset, TrainOptions(stages=("ranker",)))


def test_without_held_out_items_the_last_pass_is_kept(tmp_path: Path) -> None:
    make_data(tmp_path / "data", shapes=2)
    report = run(tmp_path / "data", tmp_path / "m.ckpt")
    assert [(stage.best_epoch, stage.validation) for stage in report.stages] == [(3, {}), (3, {}), (2, {})]


def test_the_kept_weights_are_those_of_the_best_pass(data: Path, tmp_path: Path) -> None:
    run(data, tmp_path / "m.ckpt", stages=("translator",), epochs=4)
    tensors, header = load_tensors(tmp_path / "m.ckpt.translator.state", STATE_KIND)
    losses = [record["cross_entropy"] for record in header["history"]]
    assert header["best_epoch"] == int(np.argmin(losses)) + 1
    kept = load_checkpoint(tmp_path / "m.ckpt").translator
    assert kept is not None
    for name, value in kept.state_dict().items():
        assert torch.equal(tensors[f"best.translator.{name}"], value)


def test_finetuning_reaches_the_translator_through_the_merged_drawing(data: Path) -> None:
    ranker, translator = RankingModule(MICRO.ranking), TranslationBranch(MICRO.translation)
    for network in (ranker, translator):
        initialise(network, torch.Generator().manual_seed(0))
    pairs = load_pairs(DataFolder(data, (32,)), read_pairs(data / "pairs.jsonl")[:14], 32)
    # In evaluation mode, where drawings of a batch don't influence each other through its statistics.
    losses = finetune_losses(ranker.eval(), translator, pairs)
    for loss, reached in ((losses.ranking, False), (losses.merged_ranking, True), (losses.cross_entropy, True)):
        found = torch.autograd.grad(loss, list(translator.parameters()), retain_graph=True, allow_unused=True)
        assert any(g is not None and bool(g.abs().sum() > 0) for g in found) == reached


def test_a_translator_that_draws_nothing_leaves_the_ranking_loss_as_it_is(data: Path) -> None:
    ranker, translator = RankingModule(MICRO.ranking), TranslationBranch(MICRO.translation).eval()
    translator.expect_ink(0.0)
    translator.layers[-1].weight.data.zero_()  # type: ignore[operator]
    pairs = load_pairs(DataFolder(data, (32,)), read_pairs(data / "pairs.jsonl")[:7], 32)
    losses = finetune_losses(ranker.eval(), translator, pairs)
    torch.testing.assert_close(losses.merged_ranking, losses.ranking, rtol=1e-3, atol=1e-3)


def test_the_ranker_learns_what_people_like_on_shapes_it_never_saw(tmp_path: Path) -> None:
    """The tiny preset's narrow network, on smaller pictures, from 30 shapes: far over chance within a minute."""
    make_data(tmp_path, shapes=42, views=2, held_out=12)
    dims = RankingDims(size=48, width=8)
    preset = replace(PRESETS["tiny"], ranking=dims, translation=TranslationDims(size=48, width=2))
    options = TrainOptions(stages=("ranker",), epochs=12)
    report = run_training(tmp_path, tmp_path / "pairs.jsonl", tmp_path / "m.ckpt", preset, options)
    accuracy = [record["accuracy"] for record in report.history["ranker"]]
    # 168 held-out pairs: chance would be within 0.5 +- 0.12 (three standard deviations) on any one pass.
    assert np.mean(accuracy[-4:]) > 0.65
    assert report.history["ranker"][-1]["loss"] < report.history["ranker"][0]["loss"]


def test_the_translator_learns_to_draw_the_outline(data: Path, tmp_path: Path) -> None:
    rates, dims = Rates(5e-3, batch=2, epochs=12), TranslationDims(size=48, width=4, levels=2, blocks=1)
    preset = replace(MICRO, translation=dims, ranking=RankingDims(48, 2, (1, 1)), translator=rates)
    options = TrainOptions(stages=("translator",))
    report = run_training(data, data / "pairs.jsonl", tmp_path / "m.ckpt", preset, options)
    folder, translator = DataFolder(data, (48,)), load_checkpoint(tmp_path / "m.ckpt").translator
    assert translator is not None
    entropy = [record["cross_entropy"] for record in report.history["translator"]]
    assert min(entropy) < 0.8 * entropy[0]
    pair = read_pairs(data / "pairs.jsonl")[0]
    ink = folder.drawing(pair.item, pair.better, 48)
    probability = translator(torch.from_numpy(folder.maps(pair.item, 48))[None])[0, 0].numpy()
    assert probability[ink > 0.5].mean() > 2 * probability[ink < 0.1].mean()


@pytest.mark.usefixtures("micro")
class TestCommand:
    """`ncontours train`."""

    def arguments(self, data: Path, out: Path, *more: str) -> list[str]:
        return ["train", str(data), str(data / "pairs.jsonl"), "-o", str(out), "--preset", "micro", *more]

    def complaint(self, capsys: pytest.CaptureFixture[str], arguments: list[str]) -> str:
        assert main(arguments) == 2
        lines = capsys.readouterr().err.splitlines()
        assert len(lines) == 1
        return lines[0]

    def test_prints_one_json_object(self, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(self.arguments(data, tmp_path / "m.ckpt", "--epochs", "1", "--json")) == 0
        printed = json.loads(capsys.readouterr().out)
        assert [stage["stage"] for stage in printed["stages"]] == ["ranker", "translator", "finetune"]
        assert printed["checkpoint"] == str(tmp_path / "m.ckpt")

    def test_says_what_it_kept(self, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(self.arguments(data, tmp_path / "m.ckpt", "--stage", "ranker", "--epochs", "2")) == 0
        assert capsys.readouterr().out.startswith("ranker: kept pass ")

    @pytest.mark.parametrize(
        ("more", "complaint"),
        [
            (["--stage", "judge"], "--stage: found 'judge', expected all or one of ranker, translator, finetune"),
            (["--epochs", "0"], "--epochs: found 0, expected at least 1"),
            (["--seconds", "nan"], "--seconds: found nan, expected a positive number"),
            (["--seed", "-1"], "--seed: found -1, expected 0 or more"),
            (["--device", "abacus"], "--device: found 'abacus', which torch can't use"),
            (["--preset", "huge"], "--preset: found 'huge', expected one of"),
            (["--stage", "finetune"], "finetuning needs both networks; train --stage ranker first"),
        ],
    )
    def test_wrong_options(
        self, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], more: list[str], complaint: str
    ) -> None:
        assert complaint in self.complaint(capsys, self.arguments(data, tmp_path / "m.ckpt", *more))

    def test_data_that_is_none(self, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        out = tmp_path / "m.ckpt"
        pairs = str(data / "pairs.jsonl")
        for arguments, complaint in [
            (
                ["train", str(tmp_path / "none"), pairs, "-o", str(out)],
                "no folder 'views' in it; expected a data folder",
            ),
            (["train", str(data), str(tmp_path / "none"), "-o", str(out)], "none: can't be read"),
            (["train", str(data), pairs, "-o", str(tmp_path / "none" / "m")], "its folder doesn't exist"),
        ]:
            assert complaint in self.complaint(capsys, arguments)

    def test_unknown_items(self, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        pairs = tmp_path / "pairs.jsonl"
        pairs.write_text(json.dumps({"shape": "ghost", "view": 0, "better": 0, "worse": 1, "split": "train"}))
        found = self.complaint(capsys, ["train", str(data), str(pairs), "-o", str(tmp_path / "m.ckpt")])
        assert "pairs.jsonl: item 'ghost_0' is unknown" in found

    def test_an_earlier_training_of_another_kind(
        self, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        out = tmp_path / "m.ckpt"
        run(data, out, stages=("ranker",), epochs=1)
        found = self.complaint(capsys, self.arguments(data, out, "--stage", "ranker", "--seed", "1"))
        assert "had seed 0, now 1; expected the same, or a restart" in found
        found = self.complaint(capsys, self.arguments(data, out, "--preset", "tiny"))
        assert "holds networks of preset 'micro'; expected preset 'tiny', or a file that isn't there yet" in found
        (tmp_path / "m.ckpt.ranker.state").unlink()
        found = self.complaint(capsys, self.arguments(data, out, "--stage", "ranker"))
        assert "m.ckpt.ranker.state, needed to go on, is gone; expected that file, or a restart" in found
        assert main(self.arguments(data, out, "--stage", "ranker", "--seed", "1", "--epochs", "1", "--restart")) == 0

    def test_restarting_all_stages_takes_nothing_over(
        self, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        out = tmp_path / "m.ckpt"
        out.write_bytes(b"damaged")
        assert "not a safetensors file" in self.complaint(capsys, self.arguments(data, out))
        assert main(self.arguments(data, out, "--epochs", "1", "--restart")) == 0
        (tmp_path / "m.ckpt.history.json").write_text("{")
        capsys.readouterr()
        assert "history.json: not JSON" in self.complaint(capsys, self.arguments(data, out))


def checkpoint(path: Path) -> Path:
    save_checkpoint(path, Checkpoint(MICRO, ranker=RankingModule(MICRO.ranking)))
    return path


def test_checkpoints_go_to_disk_and_back(tmp_path: Path) -> None:
    ranker, translator = RankingModule(MICRO.ranking), TranslationBranch(MICRO.translation)
    save_checkpoint(tmp_path / "m", Checkpoint(MICRO, ranker, translator, {"seed": 3}))
    loaded = load_checkpoint(tmp_path / "m")
    assert loaded.training == {"seed": 3}
    assert loaded.ranker is not None
    assert not loaded.ranker.training
    for network, other in zip((ranker, translator), loaded.networks.values(), strict=True):
        for name, value in network.state_dict().items():
            assert torch.equal(other.state_dict()[name], value)


def test_files_that_are_no_checkpoints_are_refused_in_a_line(data: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file; expected a neural-contours model"):
        load_checkpoint(tmp_path / "none")
    for name, content in (
        ("empty", b""),
        ("text", b"hello there"),
        ("cut", checkpoint(tmp_path / "m").read_bytes()[:500]),
    ):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError, match=r"not a safetensors file .*; expected a neural-contours model"):
            load_checkpoint(tmp_path / name)
    safetensors.torch.save_file({"x": torch.zeros(2)}, tmp_path / "foreign")
    with pytest.raises(InputError, match="holds a file of some other program; expected a neural-contours model"):
        load_checkpoint(tmp_path / "foreign")
    run(data, tmp_path / "t", stages=("ranker",), epochs=1)
    with pytest.raises(InputError, match="holds a neural-contours training state; expected a neural-contours model"):
        load_checkpoint(tmp_path / "t.ranker.state")


def test_checkpoints_whose_tensors_do_not_fit_their_header(tmp_path: Path) -> None:
    tensors, header = load_tensors(checkpoint(tmp_path / "m"), MODEL_KIND)
    name = "ranker.stem.weight"
    wrong = {
        r"is \(2, 8, 5, 5\)": {**tensors, name: torch.zeros(2, 8, 5, 5)},
        r"is \(2, 8, 7, 7\) torch.float64": {**tensors, name: tensors[name].double()},
        "is missing": {key: value for key, value in tensors.items() if key != name},
        "numbers that aren't finite": {**tensors, name: torch.full_like(tensors[name], torch.nan)},
    }
    for complaint, changed in wrong.items():
        save_tensors(tmp_path / "wrong", MODEL_KIND, changed, header)
        with pytest.raises(InputError, match=f"tensor {name} .*{complaint}"):
            load_checkpoint(tmp_path / "wrong")
    save_tensors(tmp_path / "wrong", MODEL_KIND, {**tensors, "ranker.more": torch.zeros(1)}, header)
    with pytest.raises(InputError, match=r"tensor 'ranker.more' is of no network"):
        load_checkpoint(tmp_path / "wrong")


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"version": 99}, "format version 99; expected version 1"),
        ({"preset": {"name": "x"}}, "damaged header"),
        ({"networks": ["poet"]}, "networks are \\['poet'\\]"),
        ({"networks": []}, "networks are"),
    ],
)
def test_checkpoints_with_a_damaged_header(tmp_path: Path, change: dict[str, object], complaint: str) -> None:
    tensors, header = load_tensors(checkpoint(tmp_path / "m"), MODEL_KIND)
    save_tensors(tmp_path / "wrong", MODEL_KIND, tensors, {**header, **change})
    with pytest.raises(InputError, match=complaint):
        load_checkpoint(tmp_path / "wrong")
