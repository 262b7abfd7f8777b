"""The site hands out questionnaires, keeps answers, and gives nothing away."""

import asyncio
import json
import re
import shutil
import sqlite3
import stat
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from starlette.applications import Starlette
from starlette.testclient import TestClient

from dataset_tools.build.items import list_items
from dataset_tools.questionnaires.batch_folder import Look
from dataset_tools.questionnaires.questionnaire import Key, Scheme
from dataset_tools.simulation.crowd import make_batch
from dataset_tools.site.database import Policy, Refusal, SiteStore, State
from dataset_tools.site.participant_pages import Limits, Settings
from dataset_tools.site.rate_limit import RateLimit
from dataset_tools.site.security import MAX_BODY, Guard
from dataset_tools.site.served_batch import SiteBatch
from dataset_tools.site.server import SiteFiles, make_app, read_consent, read_token, site_parameters
from dataset_tools.votes.ingest import ingest_results, workers_of
from dataset_tools.votes.votes import read_votes
from ncmodel.errors import InputError, UsageError
from tests.helpers.crowd_data import make_artists, make_data

LOOSE = Limits(answers=(10_000, 1000.0), starts=(10_000, 1000.0))


@pytest.fixture(scope="module")
def batch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    data = make_data(folder / "data", shapes=6, views=1)
    artists = make_artists(folder / "artists", data)
    scheme = Scheme(real=3, sentinels=2, pool=4, votes=2)
    make_batch(data, folder / "batch", dict.fromkeys(list_items(data), 2), scheme, Look(32, 32), artists)
    return folder / "batch"


@pytest.fixture
def key(batch: Path) -> Key:
    return Key.load(batch)


class Clock:
    def __init__(self) -> None:
        self.now = 1000.0

    def __call__(self) -> float:
        return self.now


def app(
    batch: Path, folder: Path, limits: Limits = LOOSE, policy: Policy | None = None, **settings: object
) -> Starlette:
    files = SiteFiles(batch, folder / "votes.sqlite", folder / "token")
    made, store = make_app(files, Settings(**settings), policy or Policy(), limits)  # type: ignore[arg-type]
    made.state.store = store
    return made


@pytest.fixture
def site(batch: Path, tmp_path: Path) -> Iterator[Starlette]:
    made = app(batch, tmp_path, completion_code="C0DE")
    yield made
    made.state.store.close()


def begin(site: Starlette, name: str) -> TestClient:
    client = TestClient(site, base_url="http://localhost", follow_redirects=False)
    reply = client.post("/start", data={"PROLIFIC_PID": name, "agree": "yes"})
    assert reply.status_code == 303, reply.text
    return client


def page_secret(client: TestClient) -> str:
    found = re.search(r'name="nc_secret" value="([0-9a-f]+)"', client.get("/questions").text)
    assert found
    return found[1]


def asked(client: TestClient, key: Key) -> str:
    found = re.search(r'data-questionnaire="([0-9a-f]+)"', client.get("/questions").text)
    assert found
    assert found[1] in key.questionnaires
    return found[1]


def right_answers(key: Key, name: str) -> dict[str, str]:
    return {q.field: q.correct for q in key.questionnaires[name].questions}


def answer(client: TestClient, secret: str, field: str, value: str, seconds: object = 2.5) -> int:
    record = {"field": field, "value": value, "seconds": seconds}
    return client.post("/answer", content=json.dumps(record), headers={"X-NC-Secret": secret}).status_code


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
    votes = list(read_votes(tmp_path / "votes.csv"))
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


def test_abandoned_questionnaires_return(tmp_path: Path) -> None:
    clock = Clock()
    store = SiteStore(tmp_path / "db", ["a"], Policy(abandoned_after=60), clock)
    first = store.begin("anna", {})
    assert store.begin("ben", {}) is Refusal.FULL
    clock.now += 61
    second = store.begin("ben", {})
    assert isinstance(second, str)
    assert not isinstance(second, Refusal)
    lost = store.find(first)
    assert lost is not None
    assert lost.state is State.ABANDONED
    assert not store.save(lost.id, {"q01": ("x", 1.0)})
    clock.now += 61
    back = store.find(first)
    assert back is not None
    assert back.state is State.ABANDONED, "ben was only just not seen: his place isn't given up before somebody asks"
    assert [entry.state for entry in store.entries()] == [State.ABANDONED, State.ABANDONED]
    back = store.find(first)
    assert back is not None
    assert back.state is State.ACTIVE, "the place is free again"
    store.close()


def test_unreliable_participants_can_be_replaced(tmp_path: Path) -> None:
    for replace, expected in ((False, True), (True, False)):
        store = SiteStore(tmp_path / f"db{replace}", ["a"], Policy(replace_unreliable=replace), Clock())
        entry = store.find(store.begin("anna", {}))
        assert entry is not None
        assert store.finish(entry.id, lambda answers: False)
        assert (store.begin("ben", {}) is Refusal.FULL) is expected
        store.close()


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
    assert len({entry.worker for entry in site.state.store.entries()}) == 2
    site.state.store.close()


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


def test_bodies_without_a_length_are_limited_too(site: Starlette) -> None:
    client = begin(site, "anna")
    chunks = (b"x" * 1000 for _ in range(MAX_BODY // 1000 + 10))
    assert client.post("/answer", content=chunks, headers={"X-NC-Secret": page_secret(client)}).status_code == 413


def test_odd_times_are_not_kept(site: Starlette, tmp_path: Path) -> None:
    client = begin(site, "anna")
    secret = page_secret(client)
    for seconds in (-1, "long", 1e308, None, [1]):
        assert answer(client, secret, "q01", "none", seconds) == 200
    with sqlite3.connect(tmp_path / "votes.sqlite") as db:
        assert db.execute("SELECT seconds FROM answers").fetchall() == [(0.0,)]


def test_changes_need_the_session_the_secret_and_this_site(site: Starlette) -> None:
    client, other = begin(site, "anna"), begin(site, "ben")
    secret = page_secret(client)
    assert answer(TestClient(site), secret, "q01", "none") == 403
    assert answer(client, "", "q01", "none") == 403
    assert answer(client, page_secret(other), "q01", "none") == 403
    body = json.dumps({"field": "q01", "value": "none"})
    for headers in ({"Origin": "https://evil.example"}, {"Sec-Fetch-Site": "cross-site"}, {"Origin": "null"}):
        reply = client.post("/answer", content=body, headers={"X-NC-Secret": secret, **headers})
        assert reply.status_code == 403
    assert client.post("/finish", data={"nc_secret": "0"}).status_code == 403
    own = {"X-NC-Secret": secret, "Origin": "http://localhost", "Sec-Fetch-Site": "same-origin"}
    assert client.post("/answer", content=body, headers=own).status_code == 200


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


def test_pages_forbid_what_is_not_theirs(site: Starlette) -> None:
    client = begin(site, "anna")
    reply = client.get("/questions")
    policy = reply.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe-inline" not in policy
    assert "frame-ancestors 'none'" in policy
    assert "'sha256-" in policy
    assert reply.headers["cache-control"] == "no-store"
    cookie = client.post("/start", data={"PROLIFIC_PID": "b", "agree": "yes"}).headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=lax" in cookie
    assert "secure" not in cookie
    assert not re.search(r"(src|href)=\"(https?:)?//", reply.text)


def test_cookies_are_for_tls_only_behind_a_public_address(batch: Path, tmp_path: Path) -> None:
    site = app(batch, tmp_path, public_url="https://study.example")
    client = TestClient(site, base_url="http://127.0.0.1:8000", follow_redirects=False)
    reply = client.post(
        "/start", data={"PROLIFIC_PID": "b", "agree": "yes"}, headers={"Origin": "https://study.example"}
    )
    assert reply.status_code == 303
    assert "secure" in reply.headers["set-cookie"].lower()
    site.state.store.close()


def test_too_many_requests_are_slowed(batch: Path, tmp_path: Path) -> None:
    site = app(batch, tmp_path, Limits(answers=(3, 0.0), starts=(2, 0.0), logins=(2, 0.0)))
    client = begin(site, "anna")
    secret = page_secret(client)
    assert [answer(client, secret, "q01", "none") for _ in range(5)] == [200, 200, 200, 429, 429]
    begin(site, "ben")
    assert TestClient(site).post("/start", data={"PROLIFIC_PID": "c", "agree": "yes"}).status_code == 429
    tries = [TestClient(site).post("/admin/login", data={"token": "x" * 30}).status_code for _ in range(3)]
    assert tries == [401, 401, 429]
    site.state.store.close()


def test_rate_limit_refills() -> None:
    clock = Clock()
    limit = RateLimit(2, 0.5, clock)
    assert [limit.allows("a") for _ in range(3)] == [True, True, False]
    assert limit.allows("b")
    clock.now += 2
    assert [limit.allows("a") for _ in range(2)] == [True, False]


def test_the_requester_sees_counts_and_downloads_results(
    site: Starlette, key: Key, batch: Path, tmp_path: Path
) -> None:
    client = begin(site, "anna")
    client.post("/finish", data={"nc_secret": page_secret(client), **right_answers(key, asked(client, key))})
    begin(site, "ben")
    token = (tmp_path / "token").read_text().strip()
    admin = TestClient(site, base_url="http://localhost")
    assert admin.post("/admin/login", data={"token": "wrong" * 6}).status_code == 401
    page = admin.post("/admin/login", data={"token": token}).text
    assert "anna" in page, "the whole questionnaire took no time, which is flagged"
    status = admin.get("/admin/status.json").json()
    assert (status["finished"], status["active"], status["wanted"], sum(status["items"].values())) == (1, 1, 4, 3)
    assert token not in page
    assert token not in str(admin.cookies)
    bearer = TestClient(site).get("/admin/results.csv", headers={"Authorization": f"Bearer {token}"})
    (tmp_path / "results.csv").write_text(bearer.text)
    once = ingest_results(batch, [tmp_path / "results.csv"], tmp_path / "votes.csv")
    both = ingest_results(batch, [tmp_path / "results.csv", tmp_path / "votes.sqlite"], tmp_path / "votes.csv")
    assert (once.votes, once.sources, both.votes, both.problems) == (5, {"site": 1}, 0, [])


def test_tokens_are_made_private_and_refused_when_short(tmp_path: Path) -> None:
    token = read_token(tmp_path / "token")
    assert len(token) >= 24
    assert read_token(tmp_path / "token") == token
    assert stat.S_IMODE((tmp_path / "token").stat().st_mode) == 0o600
    (tmp_path / "short").write_text("abc")
    with pytest.raises(UsageError, match="expected 16 or more"):
        read_token(tmp_path / "short")


def test_the_database_holds_no_secret_and_is_private(site: Starlette, tmp_path: Path) -> None:
    client = begin(site, "anna")
    secret = client.cookies["nc_session"]
    dump = b"".join(path.read_bytes() for path in tmp_path.glob("votes.sqlite*"))
    assert secret.encode() not in dump
    assert stat.S_IMODE((tmp_path / "votes.sqlite").stat().st_mode) == 0o600


def test_a_database_of_another_batch_or_none_is_refused(tmp_path: Path) -> None:
    SiteStore(tmp_path / "db", ["a", "b"], Policy(), Clock()).close()
    with pytest.raises(InputError, match="answers to another batch"):
        SiteStore(tmp_path / "db", ["c"], Policy(), Clock())
    (tmp_path / "text").write_text("this is no database, and long enough not to be taken for an empty one")
    with pytest.raises(InputError, match="database"):
        SiteStore(tmp_path / "text", ["a"], Policy(), Clock())


def test_concurrent_starts_never_share_a_place(tmp_path: Path) -> None:
    store = SiteStore(tmp_path / "db", [f"q{i}" for i in range(20)], Policy(), Clock())
    found: list[str | Refusal] = []
    threads = [threading.Thread(target=lambda i=i: found.append(store.begin(f"w{i % 30}", {}))) for i in range(60)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    entries = store.entries()
    assert len(entries) == 20
    assert len({entry.questionnaire for entry in entries}) == 20
    assert len({entry.worker for entry in entries}) == 20
    assert sum(isinstance(one, Refusal) for one in found) == 20, "ten workers found no place, twice"
    store.close()


def test_settings_are_checked(tmp_path: Path) -> None:
    assert site_parameters("a, b_1") == ("a", "b_1")
    with pytest.raises(UsageError, match="^parameters: found 'a b'"):
        site_parameters("a b")
    (tmp_path / "empty").write_text("\n")
    with pytest.raises(InputError, match="no text"):
        read_consent(tmp_path / "empty")


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
    entries = site.state.store.entries()
    assert [(entry.worker, entry.state) for entry in entries] == [("anna", State.ACTIVE), ("ben", State.ACTIVE)]
    assert len(site.state.store.answers(entries[0].id)) == 1, "what anna answered is kept"


def test_after_the_end_the_next_person_starts_afresh(site: Starlette, key: Key) -> None:
    client = begin(site, "anna")
    client.post("/finish", data={"nc_secret": page_secret(client), **right_answers(key, asked(client, key))})
    assert client.get("/?PROLIFIC_PID=anna").headers["location"] == "/done"
    assert client.get("/?PROLIFIC_PID=ben").status_code == 200


def test_wrong_bearer_tokens_are_counted(batch: Path, tmp_path: Path) -> None:
    """After too many of them not even the right one is looked at; who is logged in isn't locked out."""
    site = app(batch, tmp_path, Limits(logins=(3, 0.0)))
    token = (tmp_path / "token").read_text().strip()
    admin = TestClient(site, base_url="http://localhost")
    admin.post("/admin/login", data={"token": token})

    def tried(given: str) -> list[int]:
        heads = {"Authorization": f"Bearer {given}"}
        return [TestClient(site).get(f"/admin{page}", headers=heads).status_code for page in ("/status.json", "")]

    assert tried(token) == [200, 200]
    assert tried("wrong" * 6) == [401, 401]
    assert tried(token) == [429, 429]
    assert tried("wrong" * 6) == [429, 429]
    assert TestClient(site).get("/admin/results.csv").status_code == 401
    assert admin.get("/admin/status.json").status_code == 200
    site.state.store.close()


def test_a_limit_can_be_asked_without_counting() -> None:
    limit = RateLimit(1, 0.0, Clock())
    assert [limit.would_allow("a") for _ in range(3)] == [True, True, True]
    assert limit.allows("a")
    assert not limit.would_allow("a")


def test_slow_bodies_are_cut_off() -> None:
    """A client that sends a byte now and then doesn't hold a connection for ever."""
    from starlette.responses import PlainTextResponse
    from starlette.types import Message

    sent: list[Message] = []

    async def drip() -> Message:
        await asyncio.sleep(0.02)
        return {"type": "http.request", "body": b"x", "more_body": True}

    async def send(message: Message) -> None:
        sent.append(message)

    guard = Guard(PlainTextResponse("never reached"), body_seconds=0.1)
    scope = {"type": "http", "method": "POST", "headers": [], "path": "/answer", "query_string": b""}
    asyncio.run(guard(scope, drip, send))
    assert sent[0]["status"] == 408


def test_where_it_listens_as_json(batch: Path, tmp_path: Path) -> None:
    """A program learns the port, the link and the token's file; a key that others can read is complained of."""
    copy = tmp_path / "batch"
    shutil.copytree(batch, copy)
    (copy / "key.json").chmod(0o644)
    command = [sys.executable, "-m", "ncmodel.cli.main", "crowd", "serve", str(copy), "--db", str(tmp_path / "db")]
    with subprocess.Popen([*command, "--port", "0", "--json"], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        lines: list[str] = []
        while not lines or lines[-1] != "}\n":
            lines.append(process.stdout.readline())
        process.terminate()
    found = json.loads("".join(lines))
    assert found["participants"] == f"http://127.0.0.1:{found['port']}/?PROLIFIC_PID=...&STUDY_ID=...&SESSION_ID=..."
    assert found["requester"].endswith("/admin")
    assert Path(found["token"]).read_text().strip()
    assert any("chmod 600" in note for note in found["notes"])


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
    (entry,) = site.state.store.entries()
    answers = site.state.store.answers(entry.id)
    assert entry.state is State.FINISHED
    assert entry.reliable is (answers == right)
    assert answers in (right, wrong)


@pytest.mark.parametrize("quote", ['"', ""])
def test_batches_with_and_without_quotes_show_answers_again(batch: Path, tmp_path: Path, quote: str) -> None:
    copy = tmp_path / "batch"
    shutil.copytree(batch, copy)
    text = (copy / "template.html").read_text()
    (copy / "template.html").write_text(re.sub(r"name=(q\d+) ", rf"name={quote}\1{quote} ", text))
    served = SiteBatch(copy)
    assert served.fragment(served.identifiers[0], {"q02": "none"}).count(" checked") == 1


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
    assert site.state.store.answers(site.state.store.entries()[0].id) == {}


def test_a_planted_cookie_is_not_adopted(site: Starlette) -> None:
    """Session fixation: whoever begins gets a secret of their own, whatever cookie they came with."""
    client = TestClient(site, base_url="http://localhost", follow_redirects=False, cookies={"nc_session": "planted"})
    assert client.post("/start", data={"PROLIFIC_PID": "anna", "agree": "yes"}).status_code == 303
    planted = TestClient(site, base_url="http://localhost", cookies={"nc_session": "planted"})
    assert planted.get("/questions").status_code == 403


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


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("tasks.csv", lambda text: text.replace("questionnaire", "x", 1), "row 2: .* expected a header with questionn"),
        ("tasks.csv", lambda text: text + "only,two\n", "row 6: 2 cells"),
        ("tasks.csv", lambda text: text + text.splitlines()[-1] + "\n", "row 6: "),
        ("tasks.csv", lambda text: "", "no questionnaire"),
        ("template.html", lambda text: text + "\udcff", "template.html: not UTF-8"),
        ("template.html", lambda text: text + "${q99_d1}", "placeholder 'q99_d1'"),
        ("key.json", lambda text: text.replace('"options"', '"opt"', 1).replace('"field"', '"f"'), "not the key of a"),
        ("key.json", lambda text: text.replace('"options": {', '"options": [], "x": {', 1), "not the key of a batch"),
    ],
)
def test_a_broken_batch_is_one_line(
    batch: Path, tmp_path: Path, name: str, change: Callable[[str], str], message: str
) -> None:
    copy = tmp_path / "batch"
    shutil.copytree(batch, copy)
    text = change((copy / name).read_text())
    (copy / name).write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(InputError, match=message) as found:
        SiteBatch(copy)
    assert "\n" not in str(found.value)
