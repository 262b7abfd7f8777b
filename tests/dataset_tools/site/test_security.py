"""Requests are bounded, come from this site's own pages, and headers forbid what is not theirs."""

import asyncio
import json
import re
from pathlib import Path

import pytest
from starlette.applications import Starlette
from starlette.responses import PlainTextResponse
from starlette.testclient import TestClient
from starlette.types import Receive, Scope, Send

from dataset_tools.site.security import MAX_BODY, Guard, headers
from tests.helpers.site_client import answer, app, begin, page_secret


def test_bodies_without_a_length_are_limited_too(site: Starlette) -> None:
    client = begin(site, "anna")
    chunks = (b"x" * 1000 for _ in range(MAX_BODY // 1000 + 10))
    assert client.post("/answer", content=chunks, headers={"X-NC-Secret": page_secret(client)}).status_code == 413


def test_changes_need_the_session_the_secret_and_this_site(site: Starlette) -> None:
    client, other = begin(site, "anna"), begin(site, "ben")
    secret = page_secret(client)
    assert answer(TestClient(site), secret, "q01", "none") == 403
    assert answer(client, "", "q01", "none") == 403
    assert answer(client, page_secret(other), "q01", "none") == 403
    body = json.dumps({"field": "q01", "value": "none"})
    odd = [{"Origin": origin} for origin in ("https://evil.example", "null", "http://[x", "http://[::1")]
    for foreign in (*odd, {"Sec-Fetch-Site": "cross-site"}):
        reply = client.post("/answer", content=body, headers={"X-NC-Secret": secret, **foreign})
        assert reply.status_code == 403
    assert client.post("/finish", data={"nc_secret": "0"}).status_code == 403
    own = {"X-NC-Secret": secret, "Origin": "http://localhost", "Sec-Fetch-Site": "same-origin"}
    assert client.post("/answer", content=body, headers=own).status_code == 200


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


def test_pages_that_are_none_have_the_same_headers(site: Starlette, monkeypatch: pytest.MonkeyPatch) -> None:
    client = TestClient(site, "http://localhost", raise_server_exceptions=False, cookies={"nc_session": "x"})
    monkeypatch.setattr(site.state.store, "find", lambda secret: 1 // 0)
    replies = {
        404: client.get("/nothing"),
        405: client.get("/answer"),
        500: client.get("/questions"),
    }
    for status, reply in replies.items():
        assert reply.status_code == status
        assert "Traceback" not in reply.text
        for name, value in headers().items():
            assert reply.headers[name] == value, (status, name)


@pytest.mark.parametrize("host", ["[x", "[::1", "a b", "", ":", "x:y", "\xe9vil"])
@pytest.mark.parametrize("public_url", ["", "https://study.example"])
def test_hosts_that_are_none_are_no_failure(batch: Path, tmp_path: Path, host: str, public_url: str) -> None:
    site = app(batch, tmp_path, public_url=public_url)
    client = TestClient(site, base_url="http://localhost", follow_redirects=False)
    heads = {"Host": host.encode("latin-1"), "Origin": b"https://other.example"}
    for page in ("/", "/questions", "/nothing/", "/admin", "/images/x.png", "/start"):
        assert client.get(page, headers=heads).status_code < 500  # type: ignore[arg-type]
    assert client.post("/start", data={"PROLIFIC_PID": "b", "agree": "yes"}, headers=heads).status_code == 403  # type: ignore[arg-type]
    site.state.store.close()


def test_cookies_are_for_tls_only_behind_a_public_address(batch: Path, tmp_path: Path) -> None:
    site = app(batch, tmp_path, public_url="https://study.example")
    client = TestClient(site, base_url="http://127.0.0.1:8000", follow_redirects=False)
    reply = client.post(
        "/start", data={"PROLIFIC_PID": "b", "agree": "yes"}, headers={"Origin": "https://study.example"}
    )
    assert reply.status_code == 303
    assert "secure" in reply.headers["set-cookie"].lower()
    site.state.store.close()


def test_only_the_public_address_and_the_machine_itself_are_this_site(batch: Path, tmp_path: Path) -> None:
    site = app(batch, tmp_path, public_url="https://study.example")
    for host, origin, status in (
        ("study.example", "https://study.example", 303),
        ("127.0.0.1:8000", "http://127.0.0.1:8000", 303),
        ("evil.example", "http://evil.example", 403),
        ("evil.example", "https://study.example", 303),
    ):
        client = TestClient(site, base_url=f"http://{host}", follow_redirects=False)
        sent = {"PROLIFIC_PID": f"p{host[0]}{len(origin)}", "agree": "yes"}
        assert client.post("/start", data=sent, headers={"Origin": origin}).status_code == status, (host, origin)
    assert "location" not in TestClient(site, "http://evil.example", follow_redirects=False).get("/questions/").headers
    site.state.store.close()


@pytest.mark.parametrize(
    ("proxies", "sent", "client"),
    [
        (0, ["9.9.9.9"], "testclient"),
        (1, ["9.9.9.9"], "9.9.9.9"),
        (1, ["1.1.1.1, 9.9.9.9"], "9.9.9.9"),
        (1, ["1.1.1.1", "9.9.9.9"], "9.9.9.9"),
        (2, ["1.1.1.1, 9.9.9.9, 8.8.8.8"], "9.9.9.9"),
        (2, ["9.9.9.9"], "testclient"),
        (1, [], "testclient"),
    ],
)
def test_so_many_proxies_are_believed_and_no_more(proxies: int, sent: list[str], client: str) -> None:
    seen: list[str] = []

    async def page(scope: Scope, receive: Receive, send: Send) -> None:
        seen.append(scope["client"][0])
        await PlainTextResponse("ok")(scope, receive, send)

    headers = [("X-Forwarded-For", value) for value in sent]
    assert TestClient(Guard(page, proxies=proxies)).get("/", headers=headers).text == "ok"
    assert seen == [client]


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


def test_a_planted_cookie_is_not_adopted(site: Starlette) -> None:
    """Session fixation: whoever begins gets a secret of their own, whatever cookie they came with."""
    client = TestClient(site, base_url="http://localhost", follow_redirects=False, cookies={"nc_session": "planted"})
    assert client.post("/start", data={"PROLIFIC_PID": "anna", "agree": "yes"}).status_code == 303
    planted = TestClient(site, base_url="http://localhost", cookies={"nc_session": "planted"})
    assert planted.get("/questions").status_code == 403
