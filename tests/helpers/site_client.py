"""A questionnaire site in this process, and participants who use it."""

import json
import re
from pathlib import Path

from starlette.applications import Starlette
from starlette.testclient import TestClient

from dataset_tools.questionnaires.questionnaire import Key
from dataset_tools.site.database import Policy
from dataset_tools.site.participant_pages import RateLimits, Settings
from dataset_tools.site.server import SiteFiles, make_app

LOOSE = RateLimits(answers=(10_000, 1000.0), starts=(10_000, 1000.0))


class Clock:
    """A clock that stands still until it is moved."""

    def __init__(self) -> None:
        self.now = 1000.0

    def __call__(self) -> float:
        return self.now


def app(
    batch: Path, folder: Path, limits: RateLimits = LOOSE, policy: Policy | None = None, **settings: object
) -> Starlette:
    """The site that serves a batch, its files in a folder; `state.store` is its database."""
    files = SiteFiles(batch, folder / "votes.sqlite", folder / "token")
    made, store = make_app(files, Settings(**settings), policy or Policy(), limits)  # type: ignore[arg-type]
    made.state.store = store
    return made


def begin(site: Starlette, name: str) -> TestClient:
    """A participant who has agreed and was given a questionnaire."""
    client = TestClient(site, base_url="http://localhost", follow_redirects=False)
    reply = client.post("/start", data={"PROLIFIC_PID": name, "agree": "yes"})
    assert reply.status_code == 303, reply.text
    return client


def page_secret(client: TestClient) -> str:
    """The secret that the page of questions sends along with answers."""
    found = re.search(r'name="nc_secret" value="([0-9a-f]+)"', client.get("/questions").text)
    assert found
    return found[1]


def asked(client: TestClient, key: Key) -> str:
    """The questionnaire that a participant was given."""
    found = re.search(r'data-questionnaire="([0-9a-f]+)"', client.get("/questions").text)
    assert found
    assert found[1] in key.questionnaires
    return found[1]


def right_answers(key: Key, name: str) -> dict[str, str]:
    """Field -> value: sentinels right, all others anything."""
    return {q.field: q.correct for q in key.questionnaires[name].questions}


def answer(client: TestClient, secret: str, field: str, value: str, seconds: object = 2.5) -> int:
    """Send one answer; the status of the reply."""
    record = {"field": field, "value": value, "seconds": seconds}
    return client.post("/answer", content=json.dumps(record), headers={"X-NC-Secret": secret}).status_code
