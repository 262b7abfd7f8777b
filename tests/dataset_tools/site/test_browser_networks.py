"""Networks that come and go, a page to log in in place of pictures, a batch on another server, and two tabs."""

import csv
from pathlib import Path
from typing import Any

import playwright.sync_api as playwright
import pytest

from dataset_tools.questionnaires.batch_folder import Look
from dataset_tools.votes.ingest import ingest_results
from tests.helpers.crowd_data import vote_rows
from tests.helpers.site_browser import DESKTOP, Problems, await_answers_at_server, await_pictures, enter, make, served

pytestmark = [
    pytest.mark.browser,
    pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning"),
]

SERVER = "http://server.example"


@pytest.fixture(scope="module")
def batch(data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Seven questions, two of them sentinels."""
    return make(data, tmp_path_factory.mktemp("networks") / "batch", Look(64, 64))


def answer_all(page: Any, key: str = "2") -> None:
    for _ in range(7):
        await_pictures(page)
        page.keyboard.press(key)
        page.keyboard.press("Enter")


def other_server(batch: Path, sent: list[dict[str, str]]) -> Any:
    """Answers as a server that shows the first questionnaire of a batch's template in a form of its own."""
    with (batch / "tasks.csv").open() as file:
        task = next(csv.DictReader(file))
    template = (batch / "template.html").read_text()
    for name, cell in task.items():
        template = template.replace(f"${{{name}}}", cell)
    page = f"<!doctype html><form method=post action=/done>{template}</form>"

    def answer(route: Any) -> None:
        if "/images/" in route.request.url:
            route.fulfill(path=batch / "images" / route.request.url.rpartition("/")[2])
        elif route.request.method == "POST":
            sent.append(dict(pair.split("=", 1) for pair in route.request.post_data.split("&")))
            route.fulfill(content_type="text/html", body="Thanks")
        else:
            route.fulfill(content_type="text/html", body=page)

    return answer


def test_a_batch_on_another_server_is_sent_when_the_network_is_back(browser: Any, batch: Path) -> None:
    sent: list[dict[str, str]] = []
    context = browser.new_context(**DESKTOP)
    context.route(f"{SERVER}/**", other_server(batch, sent))
    page = context.new_page()
    page.goto(f"{SERVER}/hit")
    page.click(".next")
    answer_all(page)
    context.set_offline(True)
    page.click("button[type=submit]")
    playwright.expect(page.locator(".say")).to_contain_text("kept, and sent later")
    assert (page.url, sent) == (f"{SERVER}/hit", [])
    context.set_offline(False)
    page.wait_for_url("**/done")
    assert len(sent) == 1
    assert {f"q{number:02d}" for number in range(1, 8)} <= set(sent[0])
    context.close()


def test_who_begins_without_a_network_is_told(browser: Any, batch: Path, tmp_path: Path) -> None:
    with served(batch, tmp_path / "votes.sqlite") as base:
        context, problems = browser.new_context(**DESKTOP), Problems()
        page = problems.watch(context.new_page())
        page.goto(f"{base}/?PROLIFIC_PID=anna")
        page.check("input[name=agree]")
        context.set_offline(True)
        page.click("button[type=submit]")
        playwright.expect(page.locator("[role=status]")).to_contain_text("No connection")
        context.set_offline(False)
        playwright.expect(page.locator("[role=status]")).to_have_text("")
        page.click("button[type=submit]")
        page.wait_for_selector(".nc.js")
        assert problems == []
        context.close()


def test_a_page_to_log_in_is_no_picture(browser: Any, batch: Path, tmp_path: Path) -> None:
    """What a hotel's network answers to everything, until one has logged in."""
    with served(batch, tmp_path / "votes.sqlite") as base:
        context = browser.new_context(**DESKTOP)
        seen: list[str] = []

        def log_in(route: Any) -> None:
            seen.append(route.request.url)
            if seen.count(route.request.url) < 3:
                route.fulfill(content_type="text/html", body="<html>Please log in</html>")
            else:
                route.continue_()

        context.route("**/images/*", log_in)
        page = enter(context, base, "anna", Problems())
        page.click(".next")
        playwright.expect(page.locator(".say")).to_contain_text("still loading")
        page.keyboard.press("1")
        assert page.locator("fieldset.on input:checked").count() == 0
        await_pictures(page)
        page.keyboard.press("1")
        assert page.locator("fieldset.on input:checked").count() == 1
        context.close()


def test_two_tabs_of_one_participant_give_each_answer_once(browser: Any, batch: Path, tmp_path: Path) -> None:
    """The tab that is left behind sees that the questionnaire was sent, and the way back leads to no questions."""
    with served(batch, tmp_path / "votes.sqlite") as base:
        context = browser.new_context(**DESKTOP)
        page = enter(context, base, "anna", Problems())
        other = context.new_page()
        other.goto(f"{base}/questions")
        other.click(".next")
        await_pictures(other)
        other.keyboard.press("5")
        await_answers_at_server(context, base, 1)
        page.click(".next")
        answer_all(page)
        page.click("button[type=submit]")
        page.wait_for_url("**/done")
        page.go_back()
        playwright.expect(page.locator("main")).to_contain_text("Thank you")
        other.keyboard.press("6")
        other.wait_for_url("**/done")
        context.close()
    done = ingest_results(batch, [tmp_path / "votes.sqlite"], tmp_path / "votes.csv")
    votes = vote_rows(tmp_path / "votes.csv")
    assert (done.assignments, done.problems, len(votes)) == (1, [], 7)
    assert {vote.position for vote in votes} == {2}
