"""`ncontours train`: what it prints, and one clear line for what it can't do."""

import json
from pathlib import Path

import pytest

from ncmodel.cli.main import main
from ncmodel.nets.presets import PRESETS
from tests.helpers.commands import complaint
from tests.helpers.micro_training import MICRO, run

pytestmark = pytest.mark.usefixtures("one_thread")


@pytest.fixture
def micro(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(PRESETS, "micro", MICRO)


@pytest.mark.usefixtures("micro")
class TestCommand:
    """`ncontours train`."""

    def arguments(self, data: Path, out: Path, *more: str) -> list[str]:
        return ["train", str(data), str(data / "pairs.jsonl"), "-o", str(out), "--preset", "micro", *more]

    def test_prints_one_json_object(self, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(self.arguments(data, tmp_path / "m.ckpt", "--epochs", "1", "--json")) == 0
        printed = json.loads(capsys.readouterr().out)
        assert [stage["stage"] for stage in printed["stages"]] == ["ranker", "translator", "finetune"]
        assert printed["checkpoint"] == str(tmp_path / "m.ckpt")

    def test_says_what_it_kept(self, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(self.arguments(data, tmp_path / "m.ckpt", "--stage", "ranker", "--epochs", "2")) == 0
        assert capsys.readouterr().out.startswith("ranker: kept pass ")

    @pytest.mark.parametrize(
        ("more", "message"),
        [
            (
                ["--stage", "judge"],
                "--stage: found 'judge', expected all or one of ranker, translator, finetune, statistics",
            ),
            (
                ["--stage", "statistics"],
                "--stage: found 'statistics', expected what 'micro' has: ranker, translator, finetune",
            ),
            (["--epochs", "0"], "--epochs: found 0, expected at least 1"),
            (["--seconds", "nan"], "--seconds: found nan, expected a positive number"),
            (["--seed", "-1"], "--seed: found -1, expected 0 or more"),
            (["--device", "abacus"], "--device: found 'abacus', which torch can't use"),
            (["--preset", "huge"], "--preset: found 'huge', expected one of"),
            (["--stage", "finetune"], "finetuning needs both networks; train the ranker first"),
        ],
    )
    def test_wrong_options(
        self, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], more: list[str], message: str
    ) -> None:
        assert message in complaint(capsys, *self.arguments(data, tmp_path / "m.ckpt", *more))

    def test_data_that_is_none(self, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        out = tmp_path / "m.ckpt"
        pairs = str(data / "pairs.jsonl")
        for arguments, message in [
            (
                ["train", str(tmp_path / "none"), pairs, "-o", str(out)],
                "no folder 'views' in it; expected a data folder",
            ),
            (["train", str(data), str(tmp_path / "none"), "-o", str(out)], "none: can't be read"),
            (["train", str(data), pairs, "-o", str(tmp_path / "none" / "m")], "its folder doesn't exist"),
        ]:
            assert message in complaint(capsys, *arguments)

    def test_unknown_items(self, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        pairs = tmp_path / "pairs.jsonl"
        pairs.write_text(json.dumps({"shape": "ghost", "view": 0, "better": 0, "worse": 1, "split": "train"}))
        found = complaint(capsys, "train", str(data), str(pairs), "-o", str(tmp_path / "m.ckpt"))
        assert "pairs.jsonl: item 'ghost_0' is unknown" in found

    def test_an_earlier_training_of_another_kind(
        self, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        out = tmp_path / "m.ckpt"
        run(data, out, stages=("ranker",), epochs=1)
        found = complaint(capsys, *self.arguments(data, out, "--stage", "ranker", "--seed", "1"))
        assert "had seed 0, now 1; expected the same, or a restart" in found
        found = complaint(capsys, *self.arguments(data, out, "--preset", "tiny"))
        assert "holds networks of preset 'micro'; expected preset 'tiny', or a file that isn't there yet" in found
        (tmp_path / "m.ckpt.ranker.state").unlink()
        found = complaint(capsys, *self.arguments(data, out, "--stage", "ranker"))
        assert "m.ckpt.ranker.state, needed to go on, is gone; expected that file, or a restart" in found
        assert main(self.arguments(data, out, "--stage", "ranker", "--seed", "1", "--epochs", "1", "--restart")) == 0

    def test_restarting_all_stages_takes_nothing_over(
        self, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        out = tmp_path / "m.ckpt"
        out.write_bytes(b"damaged")
        assert "not a safetensors file" in complaint(capsys, *self.arguments(data, out))
        assert main(self.arguments(data, out, "--epochs", "1", "--restart")) == 0
        (tmp_path / "m.ckpt.history.json").write_text("{")
        capsys.readouterr()
        assert "history.json: not JSON" in complaint(capsys, *self.arguments(data, out))
