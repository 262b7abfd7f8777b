"""Participants whose pictures don't come, who see in forced colours, use keys only, or lose the network."""

import io
import json
import sqlite3
from pathlib import Path
from typing import Any

import numpy as np
import playwright.sync_api as playwright
import pytest
from PIL import Image

from dataset_tools.questionnaires.batch_folder import Look
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

pytestmark = [
    pytest.mark.browser,
    pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning"),
]


@pytest.fixture(scope="module")
def batch(data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Seven questions, two of them sentinels."""
    return make(data, tmp_path_factory.mktemp("hardships") / "batch", Look(64, 64))


def answer_all(page: Any, count: int) -> None:
    """Answer so many questions from the one in view, and send."""
    for _ in range(count):
        await_pictures(page)
        page.locator("fieldset.on label").nth(1).click()
        page.click(".next")
    page.click("button[type=submit]")


def test_nobody_votes_before_the_pictures_are_there(browser: Any, batch: Path, tmp_path: Path) -> None:
    """One picture is late, then fails twice; until it is there neither clicks nor keys choose."""
    with served(batch, tmp_path / "votes.sqlite") as base:
        context = browser.new_context(**DESKTOP)
        names: list[str] = []
        held: list[Any] = []

        def late(route: Any) -> None:
            names.append(route.request.url)
            if names.count(names[0]) == 1 and route.request.url == names[0]:
                held.append(route)
            elif route.request.url == names[0] and names.count(names[0]) == 2:
                route.abort()
            else:
                route.continue_()

        context.route("**/images/*", late)
        page = enter(context, base, "anna", Problems())
        page.click(".next")
        for key in ("1", "0"):
            page.keyboard.press(key)
        page.locator("fieldset.on label").nth(2).click(force=True)
        page.keyboard.press("Enter")
        assert "still loading" in page.inner_text(".say")
        assert page.locator("fieldset.on input:checked").count() == 0
        assert page.locator(".next").is_disabled()
        held[0].abort()
        await_pictures(page)
        assert names.count(names[0]) == 3
        assert page.inner_text(".say") == ""
        playwright.expect(page.locator("fieldset >> nth=1").locator("img[loading=eager]")).to_have_count(11)
        answer_all(page, 7)
        page.wait_for_url("**/done")
        context.close()
    ingest_results(batch, [tmp_path / "votes.sqlite"], tmp_path / "votes.csv")
    assert len(vote_rows(tmp_path / "votes.csv")) == 7


def test_who_never_gets_a_picture_goes_on_without_a_vote(browser: Any, batch: Path, tmp_path: Path) -> None:
    with served(batch, tmp_path / "votes.sqlite") as base:
        context = browser.new_context(**PHONE)
        page = context.new_page()
        page.goto(f"{base}/?PROLIFIC_PID=anna")
        page.check("input[name=agree]")
        page.click("button[type=submit]")
        page.wait_for_selector(".nc.js")
        lost = page.locator("fieldset >> nth=0").locator("img").nth(4).get_attribute("src")
        context.route(f"**{lost}", lambda route: route.fulfill(status=404))
        page.reload()
        page.click(".next")
        page.locator(".miss").wait_for(timeout=20_000)
        assert "didn’t come" in page.inner_text(".say")
        page.screenshot(path=tmp_path / "missing.png")
        assert page.locator("fieldset.on .look input:enabled").count() == 0
        page.locator(".miss label").click()
        await_answers_at_server(context, base, 0)
        page.click(".next")
        answer_all(page, 6)
        page.wait_for_url("**/done")
        context.close()
    with sqlite3.connect(tmp_path / "votes.sqlite") as db:
        kept = dict(db.execute("SELECT field, value FROM answers"))
    assert kept["q01"] == "unseen"
    assert json.loads(kept["pictures"])["q01"] >= 4
    done = ingest_results(batch, [tmp_path / "votes.sqlite"], tmp_path / "votes.csv")
    assert done.problems == []
    assert {vote.question for vote in vote_rows(tmp_path / "votes.csv")} == set(range(2, 8))


def test_asking_again_brings_a_picture_and_takes_the_way_out_away(browser: Any, batch: Path, tmp_path: Path) -> None:
    with served(batch, tmp_path / "votes.sqlite") as base:
        context = browser.new_context(**DESKTOP)
        context.route("**/images/*", lambda route: route.abort())
        page = enter(context, base, "anna", Problems())
        page.click(".next")
        page.locator(".miss").wait_for(timeout=20_000)
        page.locator(".miss label").click()
        assert page.locator(".next").is_enabled()
        context.unroute("**/images/*")
        page.click(".miss button")
        await_pictures(page)
        assert page.locator(".miss").count() == 0
        assert page.locator(".next").is_disabled(), "now there is something to answer"
        page.keyboard.press("2")
        assert page.locator("fieldset.on input").nth(1).is_checked()
        context.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_choice_is_visible_in_forced_colours(browser: Any, batch: Path, tmp_path: Path, scheme: str) -> None:
    """The chosen drawing differs from the same one not chosen in as many pixels as a thick frame has."""

    def shot(page: Any, place: int) -> Any:
        label = page.locator("fieldset.on label").nth(place)
        return np.asarray(Image.open(io.BytesIO(label.screenshot())).convert("RGB"), dtype=int)

    with served(batch, tmp_path / "votes.sqlite") as base:
        context = browser.new_context(**DESKTOP, forced_colors="active", color_scheme=scheme)
        page = enter(context, base, "anna", Problems())
        page.click(".next")
        await_pictures(page)
        page.keyboard.press("1")
        for place in (1, 8):  # a drawing, and an answer in words
            page.locator("fieldset.on legend").focus()
            before = shot(page, place)
            page.locator("fieldset.on label").nth(place).click()
            page.locator("fieldset.on legend").focus()
            changed = np.abs(shot(page, place) - before).max(axis=2) > 60
            height, width = changed.shape
            assert changed.sum() > 2 * 4 * (height + width) * 0.9, "a frame of four pixels, all around"
        page.screenshot(path=tmp_path / f"{scheme}.png")
        context.close()


def test_number_keys_can_be_switched_off_for_good(browser: Any, batch: Path, tmp_path: Path) -> None:
    with served(batch, tmp_path / "votes.sqlite") as base:
        context = browser.new_context(**DESKTOP)
        page = enter(context, base, "anna", Problems())
        page.click(".next")
        await_pictures(page)
        page.click(".digits")
        assert page.inner_text(".digits") == "Number keys: off"
        page.keyboard.press("3")
        assert page.locator("fieldset.on input:checked").count() == 0
        page.reload()
        page.wait_for_selector(".nc.js")
        await_pictures(page)
        page.keyboard.press("3")
        assert page.locator("fieldset.on input:checked").count() == 0
        page.click(".digits")
        page.keyboard.press("3")
        assert page.locator("fieldset.on input").nth(2).is_checked()
        context.close()


def test_answers_sent_without_a_network_arrive_later(browser: Any, batch: Path, tmp_path: Path) -> None:
    """Told at once and on every page; the last click keeps the page, and goes through when the network is back."""
    with served(batch, tmp_path / "votes.sqlite") as base:
        context = browser.new_context(**DESKTOP)
        page = enter(context, base, "anna", Problems())
        page.click(".next")
        for _ in range(6):
            await_pictures(page)
            page.keyboard.press("2")
            page.keyboard.press("Enter")
        await_pictures(page)
        context.set_offline(True)
        playwright.expect(page.locator(".say")).to_contain_text("No connection")
        page.keyboard.press("4")
        page.keyboard.press("Enter")
        playwright.expect(page.locator(".say")).to_contain_text("kept here")
        page.click("button[type=submit]")
        page.wait_for_timeout(1500)
        assert page.url == f"{base}/questions"
        playwright.expect(page.locator(".say")).to_contain_text("No connection")
        context.set_offline(False)
        page.wait_for_url("**/done")
        assert "DONE42" in page.inner_text("main")
        context.close()
    ingest_results(batch, [tmp_path / "votes.sqlite"], tmp_path / "votes.csv")
    assert [vote.position for vote in vote_rows(tmp_path / "votes.csv")] == [2] * 6 + [4]


def test_a_server_that_is_away_at_the_end_is_asked_again(browser: Any, batch: Path, tmp_path: Path) -> None:
    """A proxy's 502 is no page of ours."""
    with served(batch, tmp_path / "votes.sqlite") as base:
        context = browser.new_context(**DESKTOP)
        away = [502, 503]
        context.route(
            "**/finish", lambda route: route.fulfill(status=away.pop(), body="bad") if away else route.continue_()
        )
        page = enter(context, base, "anna", Problems())
        page.click(".next")
        answer_all(page, 7)
        page.wait_for_url("**/done")
        assert away == []
        context.close()
