"""Measures the questionnaire site under a crowd: latencies, errors, and whether an acknowledged answer was lost.

ncontours crowd build DATA BATCH
python -m eval.site_load BATCH -o REPORT
"""

import json
import signal
import sqlite3
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import ExitStack, closing
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from dataset_tools.questionnaires.questionnaire import Key
from eval.site_load.participants import Browser, Record, take_part
from eval.site_load.processes import OPEN_FILES, Site, allow_files, free_port, nginx, silent
from ncmodel.files import write_text
from ncmodel.report.text import text_table

SIGNALS = (signal.SIGTERM, signal.SIGKILL)
"""What ends the site in the middle, one after the other."""

PERCENTILES = (50, 95, 99)


@dataclass(frozen=True)
class Trial:
    """What a crowd does to the site.

    Attributes:
        participants: Who answer at once.
        silent: Connections beside them that say nothing.
        signals: What ends the site, at even shares of all answers; it is started again at once.
        behind_nginx: Whether they come through a proxy.
        seconds: When the run ends, whoever isn't done.
    """

    participants: int
    silent: int = 0
    signals: tuple[signal.Signals, ...] = ()
    behind_nginx: bool = True
    seconds: float = 240.0


@dataclass(frozen=True)
class Result:
    """What came of it.

    Attributes:
        trial: What was done, in words.
        requests: Answered.
        milliseconds: Percentile -> time from request to answer.
        longest: The longest such time.
        errors: What came in place of answers, before the request was sent again -> how often.
        finished: Participants whose questionnaire the server said it has.
        participants: All of them.
        acknowledged: Answers that the server said it has.
        lost: Of those, and of finished questionnaires, what the database doesn't hold.
        seconds: The whole run's time.
    """

    trial: str
    requests: int
    milliseconds: dict[int, float]
    longest: float
    errors: dict[str, int]
    finished: int
    participants: int
    acknowledged: int
    lost: int
    seconds: float


def run_trial(batch: Path, trial: Trial, code: Path) -> Result:
    """Serve a batch to a crowd.

    Args:
        batch: The batch.
        trial: What the crowd does.
        code: The checkout whose site is served.

    Raises:
        InputError: A server doesn't start.
    """
    allow_files(trial.silent + 4 * trial.participants + 100)
    asked = Key.load(batch).questionnaires
    places = -(-trial.participants // len(asked))
    questions = max(len(questionnaire.questions) for questionnaire in asked.values())
    records = [Record(f"simulated{number}") for number in range(trial.participants)]
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        port = free_port()
        options = ("--places", str(places), "--public-url", f"http://127.0.0.1:{port}")
        site = Site(batch.resolve(), Path(folder), code.resolve(), options if trial.behind_nginx else options[:2])
        site.start()
        stack.callback(lambda: site.end(signal.SIGTERM))
        if trial.behind_nginx:
            stack.enter_context(nginx(Path(folder), site.port, port))
        stack.enter_context(silent(site.port, trial.silent))
        begun = time.monotonic()
        address = "127.0.0.1", port if trial.behind_nginx else site.port
        _crowd(records, address, trial, site, questions * len(records))
        seconds = time.monotonic() - begun
        site.end(signal.SIGTERM)
        lost = count_lost(records, site.database)
    return _result(trial, records, lost, seconds)


def _crowd(records: Sequence[Record], address: tuple[str, int], trial: Trial, site: Site, answers: int) -> None:
    """Everybody at once; meanwhile the site is ended and started again, at even shares of so many answers."""
    deadline = time.monotonic() + trial.seconds
    over = threading.Event()

    def answer(number: int) -> None:
        try:
            take_part(Browser(address, records[number], deadline), number)
        except TimeoutError:
            records[number].errors["gave up"] += 1

    def interrupt() -> None:
        for share, number in enumerate(trial.signals, 1):
            wanted = answers * share // (len(trial.signals) + 1)
            while sum(len(record.acknowledged) for record in records) < wanted:
                if over.wait(0.02):
                    return
            site.end(number)
            site.start()

    with ThreadPoolExecutor(len(records) + 1) as threads:
        interrupting = threads.submit(interrupt)
        people = [threads.submit(answer, number) for number in range(len(records))]
        wait(people)
        over.set()
        for done in (*people, interrupting):
            done.result()


def count_lost(records: Sequence[Record], database: Path) -> int:
    """Acknowledged answers and questionnaires that the database doesn't hold."""
    with closing(sqlite3.connect(f"{database.as_uri()}?mode=ro", uri=True)) as db:
        query = "SELECT worker, field, value FROM answers JOIN participants ON participant = id"
        stored = set(db.execute(query))
        finished = {worker for (worker,) in db.execute("SELECT worker FROM participants WHERE state = 'finished'")}
    given = {(record.worker, name, value) for record in records for name, value in record.acknowledged.items()}
    sent = {record.worker for record in records if record.finished}
    return len(given - stored) + len(sent - finished)


def _result(trial: Trial, records: Sequence[Record], lost: int, seconds: float) -> Result:
    waits = np.array([seconds for record in records for seconds in record.waits] or [np.nan])
    words = [f"{trial.participants} answering"]
    words += [f"{trial.silent} silent"] * (trial.silent > 0) + [number.name for number in trial.signals]
    return Result(
        ", ".join(words),
        sum(len(record.waits) for record in records),
        {share: round(1000 * float(np.percentile(waits, share)), 1) for share in PERCENTILES},
        round(1000 * float(waits.max()), 1),
        dict(sum((record.errors for record in records), Counter()).most_common()),
        sum(record.finished for record in records),
        len(records),
        sum(len(record.acknowledged) for record in records),
        lost,
        round(seconds, 1),
    )


def table(results: Sequence[Result]) -> str:
    """The results for people."""
    head = ["", "requests", "median ms", "95 %", "99 %", "longest", "errors", "finished", "acknowledged", "lost", "s"]
    rows = [
        [
            result.trial,
            str(result.requests),
            *(f"{value:.0f}" for value in (*result.milliseconds.values(), result.longest)),
            ", ".join(f"{count} {name}" for name, count in result.errors.items()) or "none",
            f"{result.finished} of {result.participants}",
            str(result.acknowledged),
            str(result.lost),
            f"{result.seconds:.0f}",
        ]
        for result in results
    ]
    return text_table([head, *rows])


def main(
    batch: Annotated[Path, typer.Argument(help="Batch that `ncontours crowd build` made.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="JSON file to write.")],
    participants: Annotated[int, typer.Option(help="Who answer at once.", min=1)] = 200,
    silent_connections: Annotated[int, typer.Option(help="Connections that say nothing.", min=0)] = 1000,
    code: Annotated[Path, typer.Option(help="Checkout whose site is served, to compare.")] = Path(),
    seconds: Annotated[float, typer.Option(help="Time for each run.")] = 240.0,
) -> None:
    """Answer behind nginx: alone, all at once, beside silent connections, and with the site ended in the middle."""
    alone = Trial(1, seconds=seconds)
    quiet = Trial(participants, seconds=seconds)
    besides = Trial(participants, silent_connections, seconds=seconds)
    interrupted = Trial(participants, silent_connections, SIGNALS, seconds=seconds)
    results = [run_trial(batch, trial, code) for trial in (alone, quiet, besides, interrupted)]
    record = {"open_files": OPEN_FILES, "runs": [asdict(result) for result in results]}
    write_text(output, json.dumps(record, indent=1) + "\n")
    typer.echo(table(results))


if __name__ == "__main__":
    typer.run(main)
