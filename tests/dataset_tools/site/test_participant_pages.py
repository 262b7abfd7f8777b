"""Participants' pages hand out questionnaires, keep answers, and give nothing away."""

import json
import re
import sqlite3
import threading
from pathlib import Path

import pytest
from starlette.applications import Starlette
from starlette.testclient import TestClient

from dataset_tools.questionnaires.questionnaire import UNSEEN, Key
from dataset_tools.site.database import Policy, State
from dataset_tools.site.security import MAX_BODY
from dataset_tools.votes.ingest import ingest_results, workers_of
from tests.helpers.crowd_data import vote_rows
from tests.helpers.site_client import answer, app, asked, begin, page_secret, right_answers


def test_a_participant_from_consent_to_completion_code(site: Starlette, key: Key, batch: Path, tmp_path: Path) -> None:
    client = TestClient(site, base_url="http://localhost", follow_redirects=False)
    consent = client.get("/?PROLIFIC_PID=anna1&STUDY_ID=s1")
    assert consent.status_code == 200
    assert 'name="PROLIFIC_PID" value="anna1"' in consent.text
    assert "There are 5 questions." in consent.text
    client = begin(site, "anna1")
    name, secret = asked(client, key), page_secret(client)
    answers = right_answers(key, name)
    for field, value in list(answers.items())[:3]:
        assert answer(client, secret, field, value) == 200
    page = client.get("/questions").text
    assert len(re.findall(r" checked>", page)) == 3
    refused = client.post("/finish", data={"nc_secret": secret})
    assert refused.status_code == 422
    assert "2 questions still need an answer" in refused.text
    assert client.post("/finish", data={"nc_secret": secret, **answers}).headers["location"] == "/done"
    done = client.get("/done").text
    assert "C0DE" in done
    assert "https://app.prolific.com/submissions/complete?cc=C0DE" in done
    ingested = ingest_results(batch, [tmp_path / "votes.sqlite"], tmp_path / "votes.csv")
    votes = vote_rows(tmp_path / "votes.csv")
    assert (ingested.assignments, len(votes)) == (1, 5)
    assert {(v.worker, v.source) for v in votes} == {("anna1", "site")}
    assert all(v.passed for v in votes if v.sentinel)
    assert sorted(v.seconds or 0 for v in votes)[-3:] == [2.5, 2.5, 2.5]


def test_everybody_takes_part_once(site: Starlette, key: Key) -> None:
    lost = begin(site, "anna1")
    client = begin(site, "anna1")
    assert lost.get("/questions").status_code == 403, (
        "without an answer yet one may begin again, and goes on there alone"
    )
    again = TestClient(site, base_url="http://localhost", follow_redirects=False)
    assert answer(client, page_secret(client), "q01", "none") == 200
    reply = again.post("/start", data={"PROLIFIC_PID": "anna1", "agree": "yes"})
    assert reply.status_code == 409
    assert "go on in the browser" in reply.text
    secret, name = page_secret(client), asked(client, key)
    client.post("/finish", data={"nc_secret": secret, **right_answers(key, name)})
    assert "taken part already" in again.post("/start", data={"PROLIFIC_PID": "anna1", "agree": "yes"}).text
    assert answer(client, secret, "q01", "none") == 409
    assert client.get("/questions").headers["location"] == "/done"


def test_questionnaires_are_handed_out_once_each_until_none_is_left(site: Starlette, key: Key) -> None:
    clients = [begin(site, f"p{i}") for i in range(len(key.questionnaires))]
    assert {asked(client, key) for client in clients} == set(key.questionnaires)
    late = TestClient(site, base_url="http://localhost").post("/start", data={"PROLIFIC_PID": "late", "agree": "yes"})
    assert late.status_code == 409
    assert "All places are taken" in late.text


@pytest.mark.parametrize(
    "given", ["", "?PROLIFIC_PID=", "?PROLIFIC_PID=<script>", "?PROLIFIC_PID=" + "x" * 200, "?OTHER=1"]
)
def test_links_without_a_sane_participant_are_refused(site: Starlette, given: str) -> None:
    reply = TestClient(site).get("/" + given)
    assert reply.status_code == 400
    assert "<script>alert" not in reply.text


def test_a_site_open_to_all_gives_names(batch: Path, tmp_path: Path) -> None:
    site = app(batch, tmp_path, open_to_all=True)
    for _ in range(2):
        reply = TestClient(site, follow_redirects=False).post("/start", data={"agree": "yes"})
        assert reply.status_code == 303
    assert len({entry.worker for entry in site.state.store.assignments()}) == 2
    site.state.store.close()


def test_who_refuses_cookies_is_told_why(site: Starlette) -> None:
    client = begin(site, "anna")
    client.cookies.clear()
    reply = client.get("/questions")
    assert reply.status_code == 403
    assert "allow cookies for this site" in reply.text
    stranger = TestClient(site, base_url="http://localhost", cookies={"nc_session": "of another study"})
    assert "We don&#39;t know you here" in stranger.get("/questions").text


def test_a_question_whose_pictures_do_not_come_is_no_vote_and_no_failed_sentinel(
    site: Starlette, key: Key, batch: Path, tmp_path: Path
) -> None:
    client = begin(site, "anna")
    name, secret = asked(client, key), page_secret(client)
    asks = key.questionnaires[name].questions
    lost = [next(q.field for q in asks if q.sentinel is kind) for kind in (True, False)]
    answers = right_answers(key, name) | dict.fromkeys(lost, UNSEEN)
    assert answer(client, secret, lost[0], UNSEEN) == 200
    pictures = json.dumps({lost[0]: 4, "q99": 1, "q01": "x"})
    sent = client.post("/finish", data={"nc_secret": secret, "pictures": pictures, **answers})
    assert sent.headers["location"] == "/done"
    (entry,) = site.state.store.assignments()
    assert entry.reliable
    assert json.loads(site.state.store.answers(entry.id)["pictures"]) == {lost[0]: 4}
    token = (tmp_path / "token").read_text().strip()
    admin = TestClient(site).get("/admin/status.json", headers={"Authorization": f"Bearer {token}"})
    assert ["anna", "pictures of 2 questions didn't come"] in admin.json()["flags"]
    done = ingest_results(batch, [tmp_path / "votes.sqlite"], tmp_path / "votes.csv")
    votes = vote_rows(tmp_path / "votes.csv")
    assert (done.problems, done.unseen, len(votes)) == ([], 2, len(asks) - 2)
    assert all(vote.passed for vote in votes if vote.sentinel)


def test_consent_is_needed(site: Starlette) -> None:
    assert TestClient(site).post("/start", data={"PROLIFIC_PID": "anna"}).status_code == 400


@pytest.mark.parametrize(
    ("content", "status"),
    [
        (b"{", 400),
        (b"[]", 400),
        (b'{"field": "q01"}', 400),
        (b'{"field": "q99", "value": "none"}', 400),
        (b'{"field": "q01", "value": "\' OR 1=1 --"}', 400),
        (b"[" * 5000, 400),
        (b"x" * (MAX_BODY + 1), 413),
    ],
)
def test_answers_that_are_none_are_refused(site: Starlette, content: bytes, status: int) -> None:
    client = begin(site, "anna")
    headers = {"X-NC-Secret": page_secret(client)}
    assert client.post("/answer", content=content, headers=headers).status_code == status


def test_odd_times_are_not_kept(site: Starlette, tmp_path: Path) -> None:
    client = begin(site, "anna")
    secret = page_secret(client)
    for seconds in (-1, "long", 1e308, None, [1]):
        assert answer(client, secret, "q01", "none", seconds) == 200
    with sqlite3.connect(tmp_path / "votes.sqlite") as db:
        assert db.execute("SELECT seconds FROM answers").fetchall() == [(0.0,)]


def test_participants_cannot_read_what_is_not_theirs(site: Starlette, key: Key, batch: Path, tmp_path: Path) -> None:
    client = begin(site, "anna")
    page = client.get("/questions").text
    own = asked(client, key)
    for name in key.questionnaires:
        assert (name in page) is (name == own)
    outside = ["/images/../key.json", "/images/..%2fkey.json", "/images/%2e%2e/key.json", "/images/..%5ckey.json"]
    outside += ["/static/../site.py", "/static/..%2f..%2fkey.json", "/static/questionnaire.js", "/images/key.json"]
    files = ["/key.json", "/tasks.csv", "/template.html", "/votes.sqlite", "/token", "/images/"]
    for path in [*outside, *files, "/admin/results.csv", "/admin/status.json"]:
        reply = client.get(path)
        assert reply.status_code in (401, 404), path
        assert "sentinel" not in reply.text
        assert "options" not in reply.text
    assert client.get("/admin").status_code == 401
    for text in (page, client.get("/", follow_redirects=True).text):
        assert "sentinel" not in text
        assert not re.search(r"shape_\d", text)


def test_pictures_come_without_age_and_tag(site: Starlette) -> None:
    client = begin(site, "anna")
    names = re.findall(r'src="(/images/[0-9a-f]+\.png)"', client.get("/questions").text)
    assert len(names) == 5 * 11
    replies = [client.get(name) for name in names]
    assert {reply.status_code for reply in replies} == {200}
    kinds = {tuple(sorted(reply.headers.items())) for reply in replies}
    assert len(kinds) <= 2, "drawings and renders may differ in length, nothing else"
    assert all("etag" not in reply.headers and "last-modified" not in reply.headers for reply in replies)


def test_the_next_person_at_a_shared_computer_starts_afresh(site: Starlette, key: Key) -> None:
    client = begin(site, "anna")
    first = asked(client, key)
    assert answer(client, page_secret(client), "q01", "none") == 200
    assert client.get("/?PROLIFIC_PID=anna").headers["location"] == "/questions"
    assert client.get("/").headers["location"] == "/questions", "a link without a name goes on"
    consent = client.get("/?PROLIFIC_PID=ben")
    assert consent.status_code == 200
    assert 'name="PROLIFIC_PID" value="ben"' in consent.text
    assert client.get("/?PROLIFIC_PID=not%20a%20name").status_code == 400
    assert client.post("/start", data={"PROLIFIC_PID": "ben", "agree": "yes"}).status_code == 303
    assert asked(client, key) != first
    assert " checked>" not in client.get("/questions").text
    entries = site.state.store.assignments()
    assert [(entry.worker, entry.state) for entry in entries] == [("anna", State.ACTIVE), ("ben", State.ACTIVE)]
    assert len(site.state.store.answers(entries[0].id)) == 1, "what anna answered is kept"


def test_after_the_end_the_next_person_starts_afresh(site: Starlette, key: Key) -> None:
    client = begin(site, "anna")
    client.post("/finish", data={"nc_secret": page_secret(client), **right_answers(key, asked(client, key))})
    assert client.get("/?PROLIFIC_PID=anna").headers["location"] == "/done"
    assert client.get("/?PROLIFIC_PID=ben").status_code == 200


def test_sending_twice_at_once_ends_with_what_is_stored(site: Starlette, key: Key) -> None:
    """Whatever comes in between, the judgement is about the answers that are kept."""
    client = begin(site, "anna")
    name, secret = asked(client, key), page_secret(client)
    right = right_answers(key, name)
    wrong = {field: "none" for field in right}
    threads = [
        threading.Thread(target=client.post, args=("/finish",), kwargs={"data": {"nc_secret": secret, **answers}})
        for answers in (right, wrong) * 4
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    (entry,) = site.state.store.assignments()
    answers = site.state.store.answers(entry.id)
    assert entry.state is State.FINISHED
    assert entry.reliable is (answers == right)
    assert answers in (right, wrong)


@pytest.mark.parametrize(
    "body",
    [
        b"", b"{", b"[]", b"null", b'"x"', b"\xff\xfe", b'{"field":1}', b"[" * 60_000,
        b'{"field":"q01","value":"\\ud800"}', b'{"field":"q99","value":"none"}',
        b'{"field":"q01","value":"none","seconds":' + b"9" * 5000 + b"}",
    ],
)  # fmt: skip
def test_malformed_answers_are_refused_and_change_nothing(site: Starlette, body: bytes) -> None:
    client = begin(site, "anna")
    reply = client.post("/answer", content=body, headers={"X-NC-Secret": page_secret(client)})
    assert reply.status_code == 400
    assert site.state.store.answers(site.state.store.assignments()[0].id) == {}


def test_who_took_part_in_an_earlier_round_cannot_again(batch: Path, key: Key, tmp_path: Path) -> None:
    """Only a participant's first questionnaire counts, so a second one would be asked for nothing."""
    first = app(batch, tmp_path)
    client = begin(first, "anna")
    client.post("/finish", data={"nc_secret": page_secret(client), **right_answers(key, asked(client, key))})
    begin(first, "ben")
    first.state.store.close()
    ingest_results(batch, [tmp_path / "votes.sqlite"], tmp_path / "votes.csv")
    (tmp_path / "round2").mkdir()
    for earlier in ("votes.sqlite", "votes.csv"):
        taken_part = workers_of([tmp_path / earlier])
        assert taken_part == {"anna"}, "ben sent nothing"
        site = app(batch, tmp_path / "round2", policy=Policy(taken_part=taken_part))
        again = TestClient(site, base_url="http://localhost").post(
            "/start", data={"PROLIFIC_PID": "anna", "agree": "yes"}
        )
        assert again.status_code == 409
        assert "taken part already" in again.text
        begin(site, "ben")
        site.state.store.close()
