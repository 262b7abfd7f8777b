"""Results as people hand them on: saved by a spreadsheet, joined, cut at the right end, with rejected rows."""

import csv
import json
from collections.abc import Callable
from pathlib import Path

import pytest

from dataset_tools.cli.messages import emit_ingested
from dataset_tools.votes.approvals import write_review
from dataset_tools.votes.ingest import ingest_results
from dataset_tools.votes.reliability import assess
from dataset_tools.votes.votes import read_votes
from ncmodel.errors import BatchError, InputError
from tests.helpers.crowd_data import vote_rows
from tests.helpers.results_files import FIELDS, KEY, ROWS, to_csv, value

PLAIN = to_csv(ROWS).decode()


def saved(separator: str, encoding: str, first: str = "") -> bytes:
    """The plain file with another separator, encoding and first line."""
    lines = [separator.join(cells) for cells in csv.reader(PLAIN.splitlines())]
    return (first + "\r\n".join(lines) + "\r\n").encode(encoding)


def joined() -> bytes:
    """Two files, one behind the other with its own header, whose columns come in another order."""
    other = to_csv(ROWS[2:], list(reversed(ROWS[0])), bom=True)
    return to_csv(ROWS[:2]) + other


def without_review_cells() -> bytes:
    """As Mechanical Turk wrote them: the header has two columns more than the rows."""
    lines = PLAIN.splitlines()
    return "\n".join([f"{lines[0]},Approve,Reject", *lines[1:]]).encode()


def with_empty_cells_at_the_end() -> bytes:
    lines = PLAIN.splitlines()
    return "\n".join([lines[0], *(f"{line},,," for line in lines[1:])]).encode()


def one_column_a_button(true: str = "true", false: str = "false") -> bytes:
    """A column for every radio button of every questionnaire; those of other questionnaires are empty."""
    rows = []
    for row in ROWS:
        cells = {name: cell for name, cell in row.items() if not name.startswith("Answer.")}
        for field in FIELDS:
            for name, questionnaire in KEY.questionnaires.items():
                question = next(one for one in questionnaire.questions if one.field == field)
                for option in (*question.options, "none"):
                    asked = name == row["Input.questionnaire"] or option == "none"
                    chosen = row[f"Answer.{field}"] == option
                    cells[f"Answer.{field}.{option}"] = (true if chosen else false) if asked else ""
        rows.append(cells)
    return to_csv(rows)


def columns_twice() -> bytes:
    """As when somebody adds the columns for reviewing again, and a copy of the workers' names."""
    reader = list(csv.reader(PLAIN.splitlines()))
    names, *rows = reader
    worker = names.index("WorkerId")
    more = [
        [*names, "Reward", "Reward", "WorkerId"],
        *([*row, "1", "2" if n else "1", row[worker]] for n, row in enumerate(rows)),
    ]
    return "\n".join(map(",".join, more)).encode()


@pytest.mark.parametrize(
    "make",
    [
        lambda: saved(";", "utf-8-sig"),
        lambda: saved("\t", "utf-16"),
        lambda: saved("\t", "utf-16-le"),
        lambda: saved(",", "utf-16-be"),
        lambda: saved(";", "utf-8", "sep=;\r\n"),
        lambda: saved("~", "utf-8", '"sep=~"\r\n'),
        joined,
        without_review_cells,
        with_empty_cells_at_the_end,
        one_column_a_button,
        lambda: one_column_a_button("WAHR", "FALSCH"),
        lambda: one_column_a_button("on", ""),
        lambda: one_column_a_button("1", "0"),
        lambda: one_column_a_button("DOĞRU", "YANLIŞ"),
        lambda: b"\r\n\r\nsep=;\r\n\r\n" + saved(";", "utf-8"),
        lambda: saved(";", "utf-8", "sep=;\n") + saved(";", "utf-8", "sep=;\n"),
        columns_twice,
    ],
)
def test_every_dialect_gives_the_votes_of_the_plain_file(batch: Path, make: Callable[[], bytes]) -> None:
    (batch / "plain.csv").write_text(PLAIN)
    (batch / "other.csv").write_bytes(make())
    ingest_results(batch, [batch / "plain.csv"], batch / "plain")
    done = ingest_results(batch, [batch / "other.csv"], batch / "other")
    assert (done.problems, done.votes) == ([], 12)
    assert set(vote_rows(batch / "other")) == set(vote_rows(batch / "plain"))


def test_buttons_that_say_neither_true_nor_false_fail_nobody(batch: Path) -> None:
    (batch / "r.csv").write_bytes(one_column_a_button("ja", "nein"))
    with pytest.raises(InputError, match=r"row 2: a button of q01 is '(ja|nein)'; expected true or false"):
        ingest_results(batch, [batch / "r.csv"], batch / "v.csv")
    assert not (batch / "v.csv").exists()


def test_a_column_twice_that_says_two_things_is_a_problem(batch: Path) -> None:
    lines = PLAIN.splitlines()
    more = [f"{lines[0]},WorkerId", *(f"{line},{'w1' if n == 0 else 'x'}" for n, line in enumerate(lines[1:]))]
    (batch / "r.csv").write_text("\n".join(more))
    done = ingest_results(batch, [batch / "r.csv"], batch / "v.csv")
    assert (done.assignments, len(done.problems)) == (1, 3)
    assert "row 3: WorkerId is there twice, 'x' and 'w2'; expected one of them" in str(done.problems[0])


@pytest.mark.parametrize("head", [b"PK\x03\x04", b"\xd0\xcf\x11\xe0\xa1\xb1"])
def test_a_spreadsheet_of_a_programs_own_is_named(batch: Path, head: bytes) -> None:
    (batch / "r.xlsx").write_bytes(head + bytes(100))
    with pytest.raises(InputError, match="a spreadsheet program's own file; expected a table saved as CSV"):
        ingest_results(batch, [batch / "r.xlsx"], batch / "v.csv")


def test_a_row_that_ends_before_its_answers_is_a_problem(batch: Path) -> None:
    lines = PLAIN.splitlines()
    (batch / "r.csv").write_text("\n".join([*lines[:-1], lines[-1].rpartition(",")[0]]))
    done = ingest_results(batch, [batch / "r.csv"], batch / "v.csv")
    assert (done.assignments, len(done.problems)) == (3, 1)
    assert "row 5: 7 cells; expected 8" in str(done.problems[0])


@pytest.mark.parametrize(
    "answers",
    [
        {"Answer.choice1": "x", "Answer.seconds": "{}"},
        {"Answer.choice1": ""},
        {"Answer.taskAnswers": json.dumps([{"choice1": {"x": True}}])},
        {"Answer.choice1.x": "true"},
    ],
)
def test_a_file_whose_answers_fit_no_question_is_refused(batch: Path, answers: dict[str, str]) -> None:
    """Its participants would all have failed their sentinels."""
    rows = [{**{k: v for k, v in row.items() if not k.startswith("Answer.")}, **answers} for row in ROWS]
    (batch / "r.csv").write_bytes(to_csv(rows))
    with pytest.raises(InputError, match=r"row 2: no answer fits: found answers to choice1.*q01, q02, q03"):
        ingest_results(batch, [batch / "r.csv"], batch / "v.csv")
    assert not (batch / "v.csv").exists()


@pytest.mark.parametrize(
    "cell",
    [
        "1.23457E+15",
        "6,91E+28",
        "1E-07",
        "1234567890123450",
        "123456789012345",
        "#NAME?",
        "#\u00a1VALOR!",
        "Err:502",
        "########",
    ],
)
def test_what_a_spreadsheet_made_of_an_answer_fails_nobody(batch: Path, cell: str) -> None:
    """The questionnaire isn't recorded, so that it is read whole from the file as it was downloaded."""
    (batch / "r.csv").write_bytes(to_csv([{**ROWS[0], "Answer.q02": cell}, ROWS[1]]))
    done = ingest_results(batch, [batch / "r.csv"], batch / "v.csv")
    assert [str(problem).partition(": ")[2] for problem in done.problems] == [
        f"q02 is {cell!r}, which a spreadsheet made of an answer; expected the file as it was downloaded"
    ]
    assert set(read_votes(batch / "v.csv")["worker"]) == {"w2"}
    (batch / "r.csv").write_bytes(to_csv(ROWS[:2]))
    done = ingest_results(batch, [batch / "r.csv"], batch / "v.csv")
    assert (done.assignments, done.known_assignments, done.problems) == (1, 1, [])


@pytest.mark.parametrize("mark", [{"AssignmentStatus": "Rejected"}, {"Reject": "Too fast."}])
def test_rejected_assignments_are_left_out_and_counted(
    batch: Path, mark: dict[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    columns = [*ROWS[0], *mark]
    (batch / "r.csv").write_bytes(to_csv([{**ROWS[0], **mark}, *ROWS[1:]], columns))
    done = ingest_results(batch, [batch / "r.csv"], batch / "v.csv")
    assert (done.assignments, done.rejected, done.votes) == (3, 1, 9)
    assert "w1" not in set(read_votes(batch / "v.csv")["worker"])
    emit_ingested(done, batch / "v.csv", as_json=False)
    assert "1 rejected ones left out" in capsys.readouterr().out


def test_who_is_rejected_after_being_read_is_told(batch: Path) -> None:
    (batch / "r.csv").write_bytes(to_csv(ROWS))
    ingest_results(batch, [batch / "r.csv"], batch / "v.csv")
    (batch / "r.csv").write_bytes(to_csv([{**row, "AssignmentStatus": "Rejected"} for row in ROWS[:1]]))
    with pytest.raises(InputError, match="read before it was rejected, and its answers stay"):
        ingest_results(batch, [batch / "r.csv"], batch / "v.csv")
    assert len(read_votes(batch / "v.csv")) == 12


def test_the_review_file_is_made_from_every_dialect_too(batch: Path) -> None:
    (batch / "r.csv").write_bytes(saved(";", "utf-16", "sep=;\r\n"))
    ingest_results(batch, [batch / "r.csv"], batch / "v.csv")
    counts = write_review(batch / "r.csv", assess(read_votes(batch / "v.csv")), batch / "review.csv")
    assert counts == {"approved": 3, "rejected": 1, "unknown": 0}
    with (batch / "review.csv").open(newline="") as file:
        assert [bool(row["Reject"]) for row in csv.DictReader(file)] == [False, False, True, False]


def test_problems_still_make_the_exit_status(batch: Path) -> None:
    (batch / "r.csv").write_bytes(to_csv([ROWS[0], {**ROWS[1], "Answer.q01": value("B", "q01", 1)}]))
    done = ingest_results(batch, [batch / "r.csv"], batch / "v.csv")
    with pytest.raises(BatchError, match="1 problem in the results"):
        emit_ingested(done, batch / "v.csv", as_json=True)
