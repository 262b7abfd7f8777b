"""Links of the requester's: who has one takes part, and nobody else; and the database's copy."""

import csv
import re
import shutil
import sqlite3
import stat
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import pytest
from starlette.testclient import TestClient

from dataset_tools.site.links import is_signed, signature
from dataset_tools.votes.results_sqlite import read_site_results
from ncmodel.cli.main import main
from tests.helpers.site_client import answer, app, begin, page_secret

TOKEN = "a token of some length"


def test_only_signed_links_are_let_in(batch: Path, tmp_path: Path) -> None:
    site = app(batch, tmp_path, link_token=TOKEN)
    good = {"PROLIFIC_PID": "anna", "sig": signature(TOKEN, "anna")}
    client = TestClient(site, base_url="http://localhost", follow_redirects=False)
    for wrong in ({"PROLIFIC_PID": "anna"}, {**good, "PROLIFIC_PID": "ben"}, {**good, "sig": "0" * 32}, {}):
        assert client.get("/", params=wrong).status_code == 400
        assert client.post("/start", data={**wrong, "agree": "yes"}).status_code == 400
    fields = dict(re.findall(r'name="(\w+)" value="(\w+)"', client.get("/", params=good).text))
    assert fields["sig"] == good["sig"]
    assert client.post("/start", data={**fields, "agree": "yes"}).status_code == 303
    site.state.store.close()


def test_numbers_that_somebody_made_up_take_no_places(batch: Path, tmp_path: Path) -> None:
    site = app(batch, tmp_path, link_token=TOKEN)
    client = TestClient(site, base_url="http://localhost", follow_redirects=False)
    for number in range(17):
        sent = {
            "PROLIFIC_PID": f"p{number}",
            "sig": signature("a token that was guessed", f"p{number}"),
            "agree": "yes",
        }
        assert client.post("/start", data=sent).status_code == 400
    assert site.state.store.assignments() == []
    site.state.store.close()


def test_links_of_a_list_open_the_site(tmp_path: Path) -> None:
    (tmp_path / "people.txt").write_text("anna\nben\n\n")
    command = ["crowd", "links", "--db", str(tmp_path / "votes.sqlite"), "--base-url", "https://study.example/"]
    assert main([*command, "--participants", str(tmp_path / "people.txt"), "-o", str(tmp_path / "links.csv")]) == 0
    assert stat.S_IMODE((tmp_path / "links.csv").stat().st_mode) == 0o600
    token = (tmp_path / "votes.sqlite.token").read_text().strip()
    rows = list(csv.DictReader((tmp_path / "links.csv").read_text().splitlines()))
    assert [row["participant"] for row in rows] == ["anna", "ben"]
    for row in rows:
        link = urlsplit(row["link"])
        query = parse_qs(link.query)
        assert link.netloc == "study.example"
        assert query["PROLIFIC_PID"] == [row["participant"]]
        assert is_signed(token, row["participant"], query["sig"][0])


def test_numbers_are_made_up(tmp_path: Path) -> None:
    command = ["crowd", "links", "--db", str(tmp_path / "db"), "--base-url", "https://study.example"]
    assert main([*command, "--count", "5", "-o", str(tmp_path / "links.csv")]) == 0
    rows = list(csv.DictReader((tmp_path / "links.csv").read_text().splitlines()))
    assert len({row["participant"] for row in rows}) == 5


@pytest.mark.parametrize(
    ("text", "more", "told"),
    [
        ("anna\nanna\n", [], ": anna twice; expected"),
        ("\n", [], ": nobody; expected"),
        ("anna\n", ["--count", "3"], "count: found 3"),
    ],
)
def test_lists_that_are_none(
    text: str, more: list[str], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "people.txt").write_text(text)
    command = ["crowd", "links", "--db", str(tmp_path / "db"), "--base-url", "https://study.example"]
    command += ["--participants", str(tmp_path / "people.txt"), "-o", str(tmp_path / "links.csv"), *more]
    assert main(command) == 2
    assert told in capsys.readouterr().err
    assert not (tmp_path / "links.csv").exists()


def test_a_copy_of_a_running_sites_database_holds_all(batch: Path, tmp_path: Path) -> None:
    site = app(batch, tmp_path)
    client = begin(site, "anna")
    assert answer(client, page_secret(client), "q01", "none") == 200
    assert (tmp_path / "votes.sqlite-wal").stat().st_size  # what was answered isn't in the file itself yet
    copy = tmp_path / "copy.sqlite"
    assert main(["crowd", "backup", str(tmp_path / "votes.sqlite"), "-o", str(copy)]) == 0
    assert stat.S_IMODE(copy.stat().st_mode) == 0o600
    site.state.store.close()
    alone = tmp_path / "alone.sqlite"
    shutil.copy(copy, alone)
    with sqlite3.connect(alone) as db:
        assert db.execute("SELECT worker, field, value FROM participants, answers").fetchall() == [
            ("anna", "q01", "none")
        ]
    assert list(read_site_results(alone)) == []


def test_what_is_no_sites_database_is_not_copied(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, content in (("text", b"hello"), ("empty", b"")):
        (tmp_path / name).write_bytes(content)
        assert main(["crowd", "backup", str(tmp_path / name), "-o", str(tmp_path / "copy")]) == 2
        assert name in capsys.readouterr().err
    assert main(["crowd", "backup", str(tmp_path / "missing"), "-o", str(tmp_path / "copy")]) == 2
    assert not (tmp_path / "copy").exists()
