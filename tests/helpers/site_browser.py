"""The site served by its command, and participants who use it in a real browser."""

import re
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from dataset_tools.questionnaires.batch import make_batch
from dataset_tools.questionnaires.batch_folder import Look
from dataset_tools.questionnaires.questionnaire import Scheme
from dataset_tools.questionnaires.sentinels import ArtistsFolder
from ncmodel.data.data_folder import DataFolder

CHROMIUM = Path("/usr/bin/chromium")
ARGUMENTS = [
    "--no-sandbox",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
]
PHONE = {"viewport": {"width": 390, "height": 844}, "device_scale_factor": 2, "is_mobile": True, "has_touch": True}
DESKTOP = {"viewport": {"width": 1280, "height": 800}}


def make(data: Path, folder: Path, look: Look, real: int = 5, votes: int = 3) -> Path:
    scheme = Scheme(real=real, sentinels=2, pool=5)
    make_batch(
        data,
        folder,
        dict.fromkeys(DataFolder(data).items(), votes),
        scheme,
        look,
        ArtistsFolder(data.parent / "artists"),
    )
    return folder


@contextmanager
def served(batch: Path, db: Path, *more: str) -> Iterator[str]:
    """The site, started by its command on a free port."""
    command = [sys.executable, "-m", "ncmodel.cli.main", "crowd", "serve", str(batch), "--db", str(db), "--port", "0"]
    with subprocess.Popen(
        [*command, "--completion-code", "DONE42", *more], stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr
        found = re.search(r"http://[\d.:]+", process.stderr.readline())
        assert found
        try:
            yield found[0]
        finally:
            process.terminate()
            process.wait(10)


class Problems(list[str]):
    """What a page's console complains of."""

    def watch(self, page: Any) -> Any:
        page.on("console", lambda m: self.append(m.text) if m.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: self.append(str(error)))
        return page


def enter(context: Any, base: str, name: str, problems: Problems) -> Any:
    page = problems.watch(context.new_page())
    page.goto(f"{base}/?PROLIFIC_PID={name}")
    page.check("input[name=agree]")
    page.click("button[type=submit]")
    page.wait_for_selector(".nc.js")
    return page


def await_answers_at_server(context: Any, base: str, count: int) -> None:
    """Wait until a page comes with so many answers, before any script of it runs."""
    for _ in range(100):
        if context.request.get(f"{base}/questions").text().count('" checked') == count:
            return
        time.sleep(0.1)
    raise AssertionError(f"the server never had {count} answers")


def await_pictures(page: Any) -> None:
    """Wait until the question in view takes answers."""
    page.wait_for_selector("fieldset.on:not(.shut)")
