"""Results are read whatever their order and shape, what can't be read is named, and nothing is counted twice."""

import csv
import json
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dataset_tools.votes.ingest import ingest_results
from dataset_tools.votes.results_csv import Answered, Problem, parse_time, read_csv_results
from dataset_tools.votes.votes import DTYPES, Vote, ingest, read_votes, votes_of, write_votes
from ncmodel.errors import InputError
from tests.helpers.crowd_data import vote_rows
from tests.helpers.results_files import FIELDS, KEY, ROWS, row, to_csv, value


def ingested(batch: Path, *files: bytes, name: str = "votes.csv") -> set[Any]:
    paths = []
    for number, data in enumerate(files):
        paths.append(batch / f"{name}-{number}.csv")
        paths[-1].write_bytes(data)
    ingest_results(batch, paths, batch / name)
    return set(vote_rows(batch / name))


def test_votes_mean_what_the_key_says(batch: Path) -> None:
    votes = {(vote.worker, vote.question): vote for vote in ingested(batch, to_csv(ROWS))}
    assert len(votes) == 12
    first = votes["w1", 1]
    assert (first.shape, first.view, first.choice, first.sentinel, first.passed) == ("shape0", "0", 0, False, None)
    assert (first.position, first.seconds, first.source) == (6, 20.0, "mturk")
    assert first.submitted == "2019-11-01T19:08:17Z"
    assert votes["w2", 3].choice == -1
    assert votes["w2", 3].position == 0
    assert [votes[f"w{i}", 2].passed for i in (1, 2, 3, 4)] == [True, True, False, True]


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.sampled_from(range(4)), min_size=1, max_size=12),
    st.permutations([*ROWS[0], "Extra", "Answer.comment"]),
    st.sampled_from(["\n", "\r\n"]),
    st.booleans(),
    st.integers(0, 11),
)
def test_order_and_repetition_change_nothing(
    tmp_path_factory: pytest.TempPathFactory, picks: list[int], columns: list[str], line: str, bom: bool, cut: int
) -> None:
    """Rows in any order, repeated within and across files, columns in any order, BOM or CRLF: the same votes."""
    folder = tmp_path_factory.mktemp("order")
    (folder / "key.json").write_text(json.dumps(KEY.record()))
    rows = [{**ROWS[i], "Extra": 'a "quoted",\nfield', "Answer.comment": "ü"} for i in picks]
    parts = [part for part in (rows[:cut], rows[cut:]) if part]
    found = ingested(folder, *(to_csv(part, columns, line, bom) for part in parts))
    plain = ingested(folder, to_csv([ROWS[i] for i in sorted(set(picks))]), name="plain")
    assert found == plain
    assert len(found) == 3 * len(set(picks))


def test_appending_again_adds_nothing(batch: Path) -> None:
    once = ingested(batch, to_csv(ROWS[:2]))
    text = (batch / "votes.csv").read_bytes()
    done = ingest_results(batch, [batch / "votes.csv-0.csv"], batch / "votes.csv")
    assert (done.assignments, done.known_assignments, done.votes) == (0, 2, 0)
    assert (batch / "votes.csv").read_bytes() == text
    assert ingested(batch, to_csv(ROWS)) > once


def test_task_answers_are_read_too(batch: Path) -> None:
    """crowd-form's JSON: radio groups as booleans, or plain strings."""
    chosen = {f: value("A", f, c) for f, c in zip(FIELDS, (0, 0, 5), strict=True)}
    radios = {"q01": {chosen["q01"]: True, "other": False}, "q02": chosen["q02"], "q03": {chosen["q03"]: True}}
    blob = {
        **{k: v for k, v in ROWS[0].items() if not k.startswith("Answer")},
        "Answer.taskAnswers": json.dumps([radios]),
    }
    assert ingested(batch, to_csv([blob])) == ingested(batch, to_csv(ROWS[:1]), name="plain")


def test_turkle_files_are_read(batch: Path) -> None:
    turkle = [
        {**ROWS[0], "WorkerId": "7", "Turkle.Username": "anna"},
        {**ROWS[1], "WorkerId": "", "Turkle.Username": "b"},
    ]
    votes = ingested(batch, to_csv(turkle))
    assert {(vote.worker, vote.source) for vote in votes} == {("7", "turkle"), ("b", "turkle")}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"Input.questionnaire": "Z"}, "row 3: questionnaire 'Z' is unknown"),
        ({"WorkerId": " "}, "row 3: WorkerId is empty"),
        ({"AssignmentId": ""}, "row 3: AssignmentId is empty"),
        ({"Answer.q01": "nonsense"}, "row 3: q01 is 'nonsense'; expected one of its 8 values or none"),
        ({"Answer.q01": value("B", "q01", 1)}, "row 3: q01 is "),
        ({"Answer.q01": f"{value('A', 'q01', 1)}|{value('A', 'q01', 2)}"}, "row 3: q01 is "),
    ],
)
def test_what_cannot_be_read_is_named_and_the_rest_is_kept(batch: Path, change: dict[str, str], message: str) -> None:
    path = batch / "bad.csv"
    path.write_bytes(to_csv([ROWS[0], {**ROWS[1], **change}, ROWS[2]]))
    done = ingest_results(batch, [path], batch / "votes.csv")
    assert len(done.problems) == 1
    assert str(done.problems[0]).startswith(f"{path}, {message}")
    assert {"w1", "w3"} <= set(read_votes(batch / "votes.csv")["worker"])


def test_broken_rows_are_problems_and_the_file_goes_on(batch: Path) -> None:
    lines = to_csv(ROWS).decode().splitlines()
    lines[2:2] = ["one,two", "", "\x00" * 9, '"unfinished']
    path = batch / "bad.csv"
    path.write_bytes("\n".join(lines).encode() + b"\n\xff\xfe,1,2,3,A,x,y,z\n")
    found = list(read_csv_results(path))
    assert [one.worker for one in found if isinstance(one, Answered)][:1] == ["w1"]
    assert sum(isinstance(one, Problem) for one in found) >= 2
    assert all(str(path) in str(one) for one in found if isinstance(one, Problem))


def test_a_file_that_is_no_results_file_is_a_problem_beside_others(batch: Path) -> None:
    (batch / "good.csv").write_bytes(to_csv(ROWS))
    (batch / "wrong.csv").write_text("a,b\n1,2\n")
    done = ingest_results(batch, [batch / "wrong.csv", batch / "missing.csv", batch / "good.csv"], batch / "votes.csv")
    assert done.assignments == 4
    assert ["columns a, b" in str(done.problems[0]), "No such file" in str(done.problems[1])] == [True, True]


def test_nothing_readable_is_bad_input_and_writes_nothing(batch: Path) -> None:
    (batch / "bad.csv").write_bytes(to_csv([{**ROWS[0], "Input.questionnaire": "Z"}]))
    with pytest.raises(InputError, match=r"row 2.*unknown"):
        ingest_results(batch, [batch / "bad.csv"], batch / "votes.csv")
    assert not (batch / "votes.csv").exists()


def test_an_assignment_with_other_answers_is_reported_and_stays(batch: Path) -> None:
    (batch / "r.csv").write_bytes(to_csv([ROWS[0], {**ROWS[0], "Answer.q01": value("A", "q01", 6)}]))
    done = ingest_results(batch, [batch / "r.csv"], batch / "votes.csv")
    assert "other answers" in str(done.problems[0])
    assert {vote.choice for vote in vote_rows(batch / "votes.csv") if vote.question == 1} == {0}


def test_a_missing_answer_is_no_vote_but_fails_a_sentinel() -> None:
    answered = Answered("w", "a", "A", {}, {}, None, "", "mturk", "here")
    (only,) = votes_of(answered, KEY.questionnaires["A"])
    assert isinstance(only, Vote)
    assert (only.sentinel, only.passed, only.choice, only.position) == (True, False, -1, None)


def test_times_of_questions_are_used_where_they_make_sense(batch: Path) -> None:
    record = json.dumps({"q01": 3.5, "q02": -1, "q03": "long", "q99": 1e99})
    votes = {vote.question: vote.seconds for vote in ingested(batch, to_csv([{**ROWS[0], "Answer.seconds": record}]))}
    assert votes == {1: 3.5, 2: 20.0, 3: 20.0}


@pytest.mark.parametrize(
    ("text", "iso"),
    [
        ("Fri Nov 01 12:08:17 PDT 2019", "2019-11-01T19:08:17Z"),
        ("Sun Nov 22 14:05:00 UTC 2026", "2026-11-22T14:05:00Z"),
        ("Sun Nov 22 14:05:00 +0530 2026", "2026-11-22T08:35:00Z"),
        ("Sun Feb 30 14:05:00 UTC 2026", ""),
        ("yesterday", ""),
        ("", ""),
    ],
)
def test_times(text: str, iso: str) -> None:
    assert parse_time(text) == iso


def test_votes_survive_a_round_trip_and_other_column_orders(tmp_path: Path, batch: Path) -> None:
    votes = ingested(batch, to_csv(ROWS))
    write_votes(tmp_path / "again.csv", read_votes(batch / "votes.csv"))
    assert (tmp_path / "again.csv").read_bytes() == (batch / "votes.csv").read_bytes()
    with (tmp_path / "again.csv").open() as file:
        rows = list(csv.DictReader(file))
    least = [name for name in reversed(rows[0]) if name not in ("position", "submitted")]
    (tmp_path / "least.csv").write_bytes(to_csv(rows, [*least, "extra"], "\r\n", bom=True))
    assert {(v.worker, v.question, v.choice) for v in vote_rows(tmp_path / "least.csv")} == {
        (v.worker, v.question, v.choice) for v in votes
    }


def test_votes_are_a_frame_with_typed_columns(batch: Path) -> None:
    ingested(batch, to_csv([ROWS[0], {**ROWS[1], "WorkTimeInSeconds": ""}]))
    votes = read_votes(str(batch / "votes.csv"))
    with (batch / "votes.csv").open() as file:
        assert list(votes.columns) == next(csv.reader(file))
    assert votes.dtypes.astype(str).to_dict() == DTYPES
    assert votes["passed"].isna().tolist() == (~votes["sentinel"]).tolist()
    assert votes.groupby("worker")["seconds"].count().to_dict() == {"w1": 3, "w2": 0}
    (batch / "none.csv").write_text(",".join(votes.columns) + "\n")
    assert read_votes(batch / "none.csv").dtypes.astype(str).to_dict() == DTYPES


@pytest.mark.parametrize(
    ("name", "bad"),
    [("choice", "8"), ("choice", "-2"), ("sentinel", "yes"), ("question", "0"), ("seconds", "nan"), ("worker", "")],
)
def test_vote_files_that_make_no_sense_are_refused(batch: Path, name: str, bad: str) -> None:
    ingested(batch, to_csv(ROWS))
    with (batch / "votes.csv").open() as file:
        rows = list(csv.DictReader(file))
    rows[1][name] = bad
    (batch / "votes.csv").write_bytes(to_csv(rows))
    with pytest.raises(InputError, match=rf"votes\.csv, row 3: {name}"):
        read_votes(batch / "votes.csv")


def test_ingestion_keeps_the_old_file_when_it_fails(batch: Path) -> None:
    ingested(batch, to_csv(ROWS))
    before = (batch / "votes.csv").read_bytes()

    def broken() -> Iterator[Answered]:
        yield Answered("w9", "a9", "A", {"q01": "none"}, {}, None, "", "mturk", "here")
        raise InputError("disk", "gone", "a disk")

    with pytest.raises(InputError, match="gone"):
        ingest(broken(), KEY, batch / "votes.csv")
    assert (batch / "votes.csv").read_bytes() == before


def test_names_that_look_like_formulas_do_nothing_in_a_spreadsheet(batch: Path) -> None:
    """In the file they have an apostrophe in front; read again they are what they were, and count once."""
    names = ["=cmd|' /C calc'!A0", "+1", "-1+1", "@sum", "'=x", "''", "'plain"]
    rows = [row(name, "A", (1, 0, 2)) for name in names]
    votes = ingested(batch, to_csv(rows))
    assert {vote.worker for vote in votes} == set(names)
    with (batch / "votes.csv").open(newline="") as file:
        cells = {cell for line in list(csv.reader(file))[1:] for cell in line}
    assert not [cell for cell in cells if cell[:1] in ("=", "+", "@") or (cell[:1] == "-" and cell != "-1")]
    assert ingested(batch, to_csv(rows)) == votes
    write_votes(batch / "copy.csv", read_votes(batch / "votes.csv").sort_values(["worker", "question"]))
    assert set(vote_rows(batch / "copy.csv")) == votes


BROKEN = [
    ({"WorkerId": "ev\0il"}, r"row 3: WorkerId is 'ev\x00il'; expected at most 500 printable"),
    ({"WorkerId": "a\nb\x1b[31m"}, r"row 3: WorkerId is 'a\nb\x1b[31m'"),
    ({"WorkerId": "x" * 501}, "row 3: WorkerId is 'xxxx"),
    ({"WorkerId": " "}, "row 3: WorkerId is empty"),
    ({"AssignmentId": ""}, "row 3: AssignmentId is empty"),
    ({"Input.questionnaire": "C'; DROP TABLE x"}, 'row 3: questionnaire "C\'; DROP TABLE x" is unknown'),
    ({"Answer.q01": "=1+1"}, "row 3: q01 is '=1+1'; expected one of its 8 values or none"),
    ({"Answer.q01": "none|none"}, "row 3: q01 is 'none|none'"),
]


@pytest.mark.parametrize(("change", "message"), BROKEN)
def test_a_bad_row_is_named_and_the_others_are_kept(batch: Path, change: dict[str, str], message: str) -> None:
    rows = [ROWS[0], {**ROWS[1], **change}, ROWS[2]]
    (batch / "r.csv").write_bytes(to_csv(rows))
    done = ingest_results(batch, [batch / "r.csv"], batch / "v.csv")
    assert [message in str(problem) for problem in done.problems] == [True], done.problems
    assert "\n" not in str(done.problems[0])
    assert set(read_votes(batch / "v.csv")["worker"]) >= {"w1", "w3"}


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (bytes(range(256)) * 20, "no text in UTF-8"),
        (
            to_csv(ROWS).replace(b"Answer.q02", b"Answer.q01"),
            "row 2: Answer.q01 is there twice, 'Aq02v5' and 'Aq01v5'; expected one of them",
        ),
        (b"", "no header"),
    ],
)
def test_a_file_that_cannot_be_read_is_one_printable_line(batch: Path, data: bytes, message: str) -> None:
    (batch / "r.csv").write_bytes(data)
    with pytest.raises(InputError, match=message) as found:
        ingest_results(batch, [batch / "r.csv"], batch / "v.csv")
    assert str(found.value).isprintable()
    assert not (batch / "v.csv").exists()


def test_ingestions_at_once_lose_nothing(batch: Path) -> None:
    """Each reads the file first and then is slow, so that without waiting for each other one would undo the other."""

    def slowly(number: int) -> Iterator[Answered | Problem]:
        (batch / f"r{number}.csv").write_bytes(to_csv([row(f"w{number}", "A", (0, 0, 5))]))
        time.sleep(0.2)
        yield from read_csv_results(batch / f"r{number}.csv")

    threads = [threading.Thread(target=ingest, args=(slowly(number), KEY, batch / "v.csv")) for number in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert set(read_votes(batch / "v.csv")["worker"]) == {"w0", "w1", "w2"}
