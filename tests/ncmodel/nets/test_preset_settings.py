"""Settings of one's own: what a file may say, and one line for what it may not."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from ncmodel.cli.main import main
from ncmodel.nets.checkpoints import load_checkpoint
from ncmodel.nets.preset_settings import as_published, with_settings
from ncmodel.nets.presets import PRESETS, Rates, Variation
from tests.helpers.commands import complaint
from tests.helpers.micro_training import MICRO

pytestmark = pytest.mark.usefixtures("one_thread")

FILE = """
averaging = 0

[ranker]
learning_rate = 1e-4
batch = 8
epochs = 2

[statistics]
epochs = 7

[variation]
mirror = false
shift = 0
"""


def test_a_file_says_rates_batches_passes_and_variation(tmp_path: Path) -> None:
    path, tiny = tmp_path / "s.toml", PRESETS["tiny"]
    path.write_text(FILE)
    found = with_settings(tiny, path)
    assert found == replace(
        tiny,
        averaging=0.0,
        ranker=Rates(1e-4, 8, 2),
        counting=replace(tiny.counting, epochs=7),
        variation=Variation(mirror=False, quarter_turns=True, shift=0.0),
    )
    path.write_text("")
    assert with_settings(tiny, path) == tiny


def test_as_published_leaves_out_what_is_ours(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    tiny = as_published(PRESETS["tiny"])
    assert tiny.stages == ("ranker", "translator", "finetune")
    assert (tiny.averaging, tiny.percentile) == (0.0, "mesh")
    assert tiny.variation == Variation(mirror=False, quarter_turns=False, shift=0.0)
    monkeypatch.setitem(PRESETS, "micro", MICRO)
    words = ["train", str(data), str(data / "pairs.jsonl"), "-o", str(tmp_path / "m"), "--preset", "micro"]
    assert main([*words, "--as-published", "--stage", "ranker", "--epochs", "1", "--json"]) == 0
    capsys.readouterr()
    assert load_checkpoint(tmp_path / "m").preset == as_published(MICRO)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("[", "s.toml: not TOML"),
        ("momentum = 1", "s.toml: unknown key 'momentum'; expected averaging, or a table: ranker, translator,"),
        ("[ranker]\nrate = 1", "unknown key 'rate' in [ranker]; expected some of learning_rate, batch, epochs"),
        ("ranker = 3", "ranker is 3; expected a table [ranker] with some of learning_rate"),
        ("[ranker]\nlearning_rate = nan", "ranker.learning_rate is nan; expected a positive number"),
        ("[translator]\nbatch = 0", "translator.batch is 0; expected a whole number of at least 1"),
        ("[translator]\nbatch = 2.5", "translator.batch is 2.5; expected a whole number"),
        ("[variation]\nmirror = 1", "variation.mirror is 1; expected true or false"),
        ("[variation]\nshift = 0.6", "variation.shift is 0.6; expected a share of the side, 0 to 0.5"),
        ("averaging = 1", "averaging is 1.0; expected a number of at least 0 and below 1"),
    ],
)
def test_what_makes_no_sense_is_told_in_a_line(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], content: str, message: str
) -> None:
    path = tmp_path / "s.toml"
    path.write_text(content)
    words = ["train", data, data / "pairs.jsonl", "-o", tmp_path / "m", "--settings", path]
    assert message in complaint(capsys, *words)
    assert "can't be read" in complaint(capsys, *words[:-1], tmp_path / "none.toml")


def test_training_goes_by_them_and_other_ones_are_refused(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(PRESETS, "micro", MICRO)
    path, out = tmp_path / "s.toml", tmp_path / "m"
    path.write_text("[ranker]\nepochs = 1\nbatch = 8\n")
    words = ["train", str(data), str(data / "pairs.jsonl"), "-o", str(out), "--preset", "micro", "--stage", "ranker"]
    assert main([*words, "--settings", str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["stages"][0]["epochs"] == 1
    assert load_checkpoint(out).preset.ranker.batch == 8
    found = complaint(capsys, *words)
    assert "holds networks of preset 'micro'; expected the same settings of it, or a file that isn't there yet" in found
