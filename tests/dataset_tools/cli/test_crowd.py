"""The crowd's commands end to end, and what they say to bad input."""

import json
import re
from pathlib import Path

import pytest

from ncmodel.cli.main import main
from tests.helpers.commands import printed
from tests.helpers.crowd_data import make_data


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_data(tmp_path_factory.mktemp("cli") / "data", shapes=3, views=2)


@pytest.fixture(scope="module")
def answered(data: Path) -> Path:
    """A batch, results of simulated participants, votes and pairs, all by command."""
    folder = data.parent
    small = ["--real", "4", "--sentinels", "2", "--pool", "3", "--drawing-side", "32", "--render-side", "32"]
    assert main(["crowd", "build", str(data), str(folder / "batch"), *small]) == 0
    simulate = ["crowd", "simulate", str(folder / "batch"), "-o", str(folder / "results.csv"), "--participants", "9"]
    assert main([*simulate, "--noise", "0", "--random-clickers", "0.2"]) == 0
    ingest = ["crowd", "ingest", str(folder / "batch"), str(folder / "results.csv"), "-o", str(folder / "votes.csv")]
    assert main(ingest) == 0
    assert main(["crowd", "aggregate", str(folder / "votes.csv"), "-o", str(folder / "pairs.jsonl")]) == 0
    return folder


def test_the_loop(answered: Path, data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    votes, pairs = str(answered / "votes.csv"), str(answered / "again.jsonl")
    summary = printed(capsys, "crowd", "aggregate", votes, "-o", pairs)
    assert summary["participants"] == 9
    assert summary["simulated"] is True
    assert (answered / "again.jsonl").read_bytes() == (answered / "pairs.jsonl").read_bytes()
    held_out = printed(capsys, "crowd", "aggregate", votes, "-o", pairs, "--validation-shapes", "shape_1")
    assert held_out["validation_shapes"] == ["shape_1"]
    one_coin = printed(capsys, "crowd", "aggregate", votes, "-o", pairs, "--method", "one-coin", "--unreliable-too")
    assert one_coin["items"] == 6
    again = printed(capsys, "crowd", "ingest", str(answered / "batch"), str(answered / "results.csv"), "-o", votes)
    assert (again["assignments"], again["known_assignments"]) == (0, 9)
    audit = printed(capsys, "crowd", "audit", votes, "-o", str(answered / "audit.html"), "--data", str(data))
    assert audit["items"] == 6
    review = printed(capsys, "crowd", "review", votes, str(answered / "results.csv"), "-o", str(answered / "r.csv"))
    assert sum(int(str(count)) for count in review.values()) == 9


def test_topup(answered: Path, data: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    votes = str(answered / "votes.csv")
    small = ["--sentinels", "2", "--pool", "3", "--drawing-side", "32", "--render-side", "32"]
    built = printed(capsys, "crowd", "topup", str(data), votes, str(tmp_path / "more"), "--votes", "9", *small)
    assert built["items"] == 6
    assert (tmp_path / "more" / "tasks.csv").exists()
    enough = printed(capsys, "crowd", "topup", str(data), votes, str(tmp_path / "none"), "--votes", "1", *small)
    assert enough["questionnaires"] == 0
    assert not (tmp_path / "none").exists()


def test_trial(data: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    trial = ["crowd", "trial", str(data), "-o", str(tmp_path / "trial.html"), "--participants", "20"]
    record = printed(capsys, *trial, "--adversaries", "1", "--items", "2")
    assert isinstance(record["kinds"], list)
    assert len(record["kinds"]) == 13


def test_results_with_problems_exit_with_1(answered: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    text = (answered / "results.csv").read_text().splitlines()
    (tmp_path / "bad.csv").write_text("\n".join([text[0], text[1], "broken,row", text[2]]) + "\n")
    batch, out = str(answered / "batch"), str(tmp_path / "votes.csv")
    assert main(["crowd", "ingest", batch, str(tmp_path / "bad.csv"), "-o", out, "--json"]) == 1
    captured = capsys.readouterr()
    assert json.loads(captured.out)["assignments"] == 2
    assert "bad.csv, row 3: 2 cells" in captured.err


CASES = [
    (["crowd", "build", "{tmp}/nowhere", "{tmp}/b"], "nowhere: no such folder"),
    (["crowd", "build", "{data}", "{tmp}/b", "--real", "0"], "--real: found 0, expected 1 or more"),
    (["crowd", "build", "{data}", "{tmp}/b", "--pool", "2"], "--pool: found 2, expected at least the sentinels"),
    (["crowd", "build", "{data}", "{tmp}/b", "--artists", "{tmp}"], "no drawing of any view"),
    (["crowd", "build", "{data}", "{answered}/batch"], "holds files already"),
    (
        ["crowd", "build", "{data}", "{tmp}/b", "--drawing-side", "1"],
        "--drawing-side: found 1, expected 16..4096 pixels",
    ),
    (["crowd", "simulate", "{tmp}", "-o", "{tmp}/r.csv"], "key.json: can't be read"),
    (
        ["crowd", "simulate", "{answered}/batch", "-o", "{tmp}/r.csv", "--participants", "0"],
        "--participants: found 0, expected 1 or more",
    ),
    (
        ["crowd", "simulate", "{answered}/batch", "-o", "{tmp}/r.csv", "--random-clickers", "2"],
        "--random-clickers: found 2.0, expected a share",
    ),
    (["crowd", "ingest", "{answered}/batch", "{tmp}/no.csv", "-o", "{tmp}/v.csv"], "no.csv"),
    (["crowd", "ingest", "{answered}/batch", "{answered}/batch/key.json", "-o", "{tmp}/v.csv"], "columns {{"),
    (["crowd", "ingest", "{answered}/batch", "{answered}/results.csv", "-o", "{answered}/results.csv"], "no column"),
    (["crowd", "aggregate", "{tmp}/no.csv", "-o", "{tmp}/p"], "no.csv: can't be read"),
    (["crowd", "aggregate", "{answered}/results.csv", "-o", "{tmp}/p"], "no column worker"),
    (["crowd", "aggregate", "{answered}/votes.csv", "-o", "{tmp}/p", "--method", "best"], "--method: found 'best'"),
    (
        ["crowd", "aggregate", "{answered}/votes.csv", "-o", "{tmp}/p", "--validation-shapes", "x"],
        "--validation-shapes: found x, which has no votes",
    ),
    (["crowd", "topup", "{data}", "{answered}/results.csv", "{tmp}/b"], "no column"),
    (["crowd", "audit", "{answered}/batch/key.json", "-o", "{tmp}/a.html"], "no column worker"),
    (["crowd", "review", "{answered}/votes.csv", "{answered}/votes.csv", "-o", "{tmp}/r"], "WorkerId"),
    (["crowd", "serve", "{tmp}", "--db", "{tmp}/db"], "can't be read"),
    (["crowd", "serve", "{answered}/batch", "--db", "{answered}/votes.csv", "--port", "0"], "database"),
    (["crowd", "serve", "{answered}/batch", "--db", "{tmp}/db", "--parameters", "a b"], "--parameters"),
    (["crowd", "serve", "{answered}/batch", "--db", "{tmp}/db", "--abandoned-after", "0"], "--abandoned-after"),
    (
        ["crowd", "serve", "{answered}/batch", "--db", "{tmp}/db", "--public-url", "example.org"],
        "--public-url: found 'example.org', expected https",
    ),
    (["crowd", "serve", "{answered}/batch", "--db", "{tmp}/db", "--public-url", "https://a/b"], "all of a host"),
    (["crowd", "serve", "{answered}/batch", "--db", "{tmp}/db", "--taken-part", "{tmp}/no.csv"], "no.csv: can't be"),
    (["crowd", "study", "build", "{tmp}/b", "--ours", "x", "--against", "a={tmp}", "--renders", "{tmp}"], "NAME=DIR"),
    (
        ["crowd", "study", "build", "{tmp}/b", "--ours", "x={tmp}", "--against", "a={tmp}", "--renders", "{tmp}"],
        "no drawings",
    ),
    (["crowd", "study", "report", "{answered}/batch", "{tmp}/a.csv", "-o", "{tmp}/r"], "not the key of a study"),
    (["crowd", "trial", "{data}", "-o", "{tmp}/t", "--participants", "1"], "--participants: found 1, expected 10"),
]


@pytest.mark.parametrize(("arguments", "message"), CASES)
def test_bad_input_is_one_line_and_2(
    arguments: list[str], message: str, answered: Path, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    filled = [argument.format(data=data, answered=answered, tmp=tmp_path) for argument in arguments]
    capsys.readouterr()
    assert main(filled) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    last = captured.err.splitlines()[-1]
    assert message.replace("{{", "{") in last, captured.err
    assert "Traceback" not in captured.err
    assert len([line for line in captured.err.splitlines() if not re.match(r"note:|items seen", line)]) == 1
