"""The requester's pages: counts, results, and who may see them."""

from pathlib import Path

import pytest
from starlette.applications import Starlette
from starlette.testclient import TestClient

from dataset_tools.questionnaires.questionnaire import Key
from dataset_tools.site.participant_pages import RateLimits
from dataset_tools.votes.ingest import ingest_results
from tests.helpers.site_client import app, asked, begin, page_secret, right_answers


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


@pytest.mark.parametrize(("proxies", "sent"), [(0, "10.0.0.{}"), (1, "10.0.0.{}, 9.9.9.9")])
def test_addresses_that_somebody_made_up_give_no_more_tries(
    batch: Path, tmp_path: Path, proxies: int, sent: str
) -> None:
    """What our own proxy adds to X-Forwarded-For counts, and nothing before it."""
    site = app(batch, tmp_path, RateLimits(logins=(3, 0.0)), proxies=proxies)
    client = TestClient(site, base_url="http://localhost")
    tried = [
        client.post(
            "/admin/login", data={"token": "wrong" * 6}, headers={"X-Forwarded-For": sent.format(n)}
        ).status_code
        for n in range(5)
    ]
    assert tried == [401, 401, 401, 429, 429]
    site.state.store.close()


def test_wrong_bearer_tokens_are_counted(batch: Path, tmp_path: Path) -> None:
    """After too many of them not even the right one is looked at; who is logged in isn't locked out."""
    site = app(batch, tmp_path, RateLimits(logins=(3, 0.0)))
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
