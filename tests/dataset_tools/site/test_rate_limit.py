"""Too many requests from one place are slowed; limits refill."""

from pathlib import Path

from starlette.testclient import TestClient

from dataset_tools.site.participant_pages import RateLimits
from dataset_tools.site.rate_limit import RateLimit
from tests.helpers.site_client import Clock, answer, app, begin, page_secret


def test_too_many_requests_are_slowed(batch: Path, tmp_path: Path) -> None:
    site = app(batch, tmp_path, RateLimits(answers=(3, 0.0), starts=(2, 0.0), logins=(2, 0.0)))
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


def test_a_limit_can_be_asked_without_counting() -> None:
    limit = RateLimit(1, 0.0, Clock())
    assert [limit.would_allow("a") for _ in range(3)] == [True, True, True]
    assert limit.allows("a")
    assert not limit.would_allow("a")
