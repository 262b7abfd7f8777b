"""The questionnaires in a real browser: on the site, and on a real Turkle server."""

import csv
import http.server
import json
import re
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import playwright.sync_api as playwright
import pytest

from dataset_tools.questionnaires.batch_folder import Look
from dataset_tools.questionnaires.questionnaire import Key
from dataset_tools.votes.ingest import ingest_results
from tests.helpers.crowd_data import vote_rows
from tests.helpers.site_browser import (
    DESKTOP,
    PHONE,
    Problems,
    await_answers_at_server,
    await_pictures,
    enter,
    make,
    served,
)
from tests.helpers.turkle_server import PASSWORD, USER

pytestmark = [
    pytest.mark.browser,
    pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning"),
]


@pytest.mark.parametrize(("name", "device"), [("phone", PHONE), ("desktop", DESKTOP)])
def test_a_questionnaire_on_the_site(
    browser: Any, data: Path, tmp_path: Path, name: str, device: dict[str, Any]
) -> None:
    batch, problems = make(data, tmp_path / "batch", Look(64, 64)), Problems()
    with served(batch, tmp_path / "votes.sqlite") as base:
        context = browser.new_context(**device)
        page = enter(context, base, name, problems)
        assert page.inner_text("output") == "0 of 7"
        page.click(".next")
        assert page.locator(".next").is_disabled(), "an answer first"
        await_pictures(page)
        page.keyboard.press("Enter")
        assert "choose an answer" in page.inner_text(".say")
        page.keyboard.press("3")
        assert page.locator("fieldset.on input:checked").count() == 1
        assert page.locator("fieldset.on input").nth(2).is_checked()
        for key, place in (("ArrowDown", 3), ("ArrowRight", 4), ("ArrowLeft", 3), ("ArrowUp", 2), ("ArrowRight", 3)):
            page.keyboard.press(key)
            assert page.locator("fieldset.on input").nth(place).is_checked(), "all arrows move the choice"
        page.keyboard.press("Enter")
        await_pictures(page)
        page.keyboard.press("0")
        assert page.locator("fieldset.on .other input").is_checked()
        page.click(".back")
        assert page.locator("fieldset.on input").nth(3).is_checked()
        page.reload()
        page.wait_for_selector(".nc.js")
        assert page.inner_text("output") == "2 of 7", "a reload keeps answers"
        await_answers_at_server(context, base, 2)
        page.screenshot(path=tmp_path / f"{name}.png")
        for _ in range(7):
            page.locator("fieldset.on label").nth(1).click()
            page.click(".next")
        page.click("button[type=submit]")
        page.wait_for_url("**/done")
        assert "DONE42" in page.inner_text("main")
        context.close()
    assert problems == []
    done = ingest_results(batch, [tmp_path / "votes.sqlite"], tmp_path / "votes.csv")
    votes = vote_rows(tmp_path / "votes.csv")
    assert (done.assignments, len(votes)) == (1, 7)
    assert {vote.position for vote in votes} == {2}
    assert all(vote.seconds is not None for vote in votes)


def test_the_page_can_be_used_by_everybody(browser: Any, data: Path, tmp_path: Path) -> None:
    """Labels, alternative texts, focus, no sideways scrolling, pictures loaded ahead."""
    batch, problems = make(data, tmp_path / "batch", Look(64, 64)), Problems()
    with served(batch, tmp_path / "votes.sqlite") as base:
        context = browser.new_context(**PHONE)
        page = enter(context, base, "anna", problems)
        page.click(".next")
        page.wait_for_timeout(300)
        focused = page.evaluate("document.activeElement.tagName")
        assert focused == "LEGEND", "a new question is announced"
        assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
        texts = page.locator("img").evaluate_all("images => images.map(image => image.alt)")
        assert set(texts) == {f"Drawing {i}" for i in range(1, 9)} | {f"Shape, view {i}" for i in (1, 2, 3)}
        named = page.locator("fieldset.on input").evaluate_all("all => all.every(one => one.labels.length === 1)")
        assert named
        sizes = page.locator("fieldset.on label").evaluate_all(
            "all => all.map(one => one.getBoundingClientRect().height)"
        )
        assert min(sizes) >= 44, "large enough to touch"
        ahead = page.locator("fieldset >> nth=1").locator("img")
        assert ahead.evaluate_all("all => Promise.all(all.map(one => one.decode())).then(() => all.length)") == 11
        page.click(".size")
        wide = page.locator("fieldset.on .grid label").first.bounding_box()
        assert wide["width"] > 300
        context.close()
    assert problems == []


def test_the_page_works_without_scripts(browser: Any, data: Path, tmp_path: Path) -> None:
    batch = make(data, tmp_path / "batch", Look(32, 32))
    key = Key.load(batch)
    with served(batch, tmp_path / "votes.sqlite") as base:
        context = browser.new_context(java_script_enabled=False, **DESKTOP)
        page = context.new_page()
        page.goto(f"{base}/?PROLIFIC_PID=plain")
        page.check("input[name=agree]")
        page.click("button[type=submit]")
        for number in range(1, 8):
            page.check(f"input[name=q{number:02d}] >> nth=0", force=True)
        page.click("button:has-text('Send my answers')")
        assert page.url.endswith("/done")
        context.close()
    ingest_results(batch, [tmp_path / "votes.sqlite"], tmp_path / "votes.csv")
    assert len(vote_rows(tmp_path / "votes.csv")) == 7
    assert len(key.questionnaires) == 5


def test_the_next_person_in_the_same_browser_finds_no_answers(browser: Any, data: Path, tmp_path: Path) -> None:
    """Both get the same questionnaire, so only who they are keeps their answers apart."""
    batch, problems = make(data, tmp_path / "batch", Look(32, 32), real=8, votes=1), Problems()
    with served(batch, tmp_path / "votes.sqlite", "--places", "2") as base:
        context = browser.new_context(**DESKTOP)
        page = enter(context, base, "anna", problems)
        page.click(".next")
        await_pictures(page)
        page.keyboard.press("5")
        await_answers_at_server(context, base, 1)
        page = enter(context, base, "ben", problems)
        assert page.inner_text("output") == "0 of 10"
        assert page.inner_text(".next") == "Start"
        await_answers_at_server(context, base, 0)
        context.close()
    assert problems == []


def test_answers_survive_a_server_that_is_away(browser: Any, data: Path, tmp_path: Path) -> None:
    batch, problems = make(data, tmp_path / "batch", Look(32, 32)), Problems()
    with served(batch, tmp_path / "votes.sqlite") as base:
        context = browser.new_context(**DESKTOP)
        page = enter(context, base, "anna", problems)
        page.click(".next")
        await_pictures(page)
        context.set_offline(True)
        page.keyboard.press("5")
        playwright.expect(page.locator(".say")).to_contain_text("No connection")
        context.set_offline(False)
        playwright.expect(page.locator(".say")).to_have_text("", timeout=10_000)
        await_answers_at_server(context, base, 1)
        context.close()


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextmanager
def pictures(folder: Path) -> Iterator[str]:
    """A plain web server for a batch's pictures."""

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *arguments: object) -> None:
            """Say nothing."""

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(folder))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/images/"
        server.shutdown()


@contextmanager
def turkle(folder: Path) -> Iterator[tuple[str, str]]:
    """A Turkle server: its address and the requester's token."""
    port = free_port()
    command = [sys.executable, "-m", "tests.helpers.turkle_server", str(folder), str(port)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        assert process.stdout
        try:
            token = process.stdout.readline().strip()
            assert re.fullmatch("[0-9a-f]{40}", token), "the server printed its token"
            base = f"http://127.0.0.1:{port}"
            for _ in range(100):
                try:
                    urllib.request.urlopen(base, timeout=5).close()
                    break
                except OSError:
                    time.sleep(0.2)
            yield base, token
        finally:
            process.kill()
            process.wait(10)


def call(url: str, token: str, record: dict[str, object] | None = None) -> str:
    """The text that Turkle's interface for programs answers."""
    headers = {"Authorization": f"Token {token}", "Content-Type": "application/json"}
    data = None if record is None else json.dumps(record).encode()
    with urllib.request.urlopen(urllib.request.Request(url, data, headers), timeout=30) as reply:
        return str(reply.read().decode())


def test_a_batch_on_a_real_turkle_server(browser: Any, data: Path, tmp_path: Path) -> None:
    """Upload template and tasks, answer one questionnaire in the browser, download the results, ingest them."""
    with pictures(tmp_path / "batch") as address, turkle(tmp_path) as (base, token):
        batch = make(data, tmp_path / "batch", Look(64, 64, base_url=address))
        template, tasks = (batch / "template.html").read_text(), (batch / "tasks.csv").read_text()
        project = json.loads(
            call(f"{base}/api/projects/", token, {"name": "p", "html_template": template, "filename": "t"})
        )
        uploaded = {"name": "b", "project": project["id"], "filename": "tasks.csv", "csv_text": tasks}
        number = json.loads(call(f"{base}/api/batches/", token, {**uploaded, "published": True}))["id"]
        context, problems = browser.new_context(**DESKTOP), Problems()
        page = problems.watch(context.new_page())
        page.goto(f"{base}/login/")
        page.fill("input[name=username]", USER)
        page.fill("input[name=password]", PASSWORD)
        page.press("input[name=password]", "Enter")
        page.goto(f"{base}/batch/{number}/accept_next_task/")
        frame = page.frame_locator("#task_assignment_iframe")
        frame.locator(".next").click()
        frame.locator("fieldset.on label").nth(4).click()
        page.reload()
        playwright.expect(frame.locator("output")).to_have_text("1 of 7")
        for _ in range(7):
            frame.locator("fieldset.on label").nth(4).click()
            frame.locator(".next").click()
        loaded = frame.locator("img").evaluate_all("all => all.filter(one => one.naturalWidth > 0).length")
        assert loaded == 7 * 11
        page.screenshot(path=tmp_path / "turkle.png")
        frame.locator("button[type=submit]").click()
        page.wait_for_url(f"{base}/")
        text = call(f"{base}/api/batches/{number}/results/", token)
        context.close()
    (tmp_path / "results.csv").write_text(text)
    with (tmp_path / "results.csv").open() as file:
        assert len(list(csv.DictReader(file))) == 1
    done = ingest_results(batch, [tmp_path / "results.csv"], tmp_path / "votes.csv")
    votes = vote_rows(tmp_path / "votes.csv")
    assert (done.problems, len(votes), done.sources) == ([], 7, {"turkle": 1})
    assert {vote.position for vote in votes} == {5}
    assert all(vote.seconds is not None and vote.submitted for vote in votes)
