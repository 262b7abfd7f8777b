"""Many participants at once, and a server that is killed among them: what was acknowledged is there."""

import asyncio
import json
import os
import re
import signal
import socket
import sqlite3
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

import httpx2
import pytest

from dataset_tools.questionnaires.batch import make_batch
from dataset_tools.questionnaires.batch_folder import Look
from dataset_tools.questionnaires.questionnaire import Key, Scheme
from dataset_tools.questionnaires.sentinels import ArtistsFolder
from dataset_tools.votes.ingest import ingest_results
from ncmodel.data.data_folder import DataFolder
from tests.helpers.crowd_data import make_artists, make_data, vote_rows

PARTICIPANTS = 200
SECONDS = 60.0
"""A run that takes longer has failed."""

pytestmark = pytest.mark.slow


@dataclass
class Record:
    """What one participant sent and what the server acknowledged."""

    acknowledged: dict[str, str] = field(default_factory=dict)
    finished: bool = False
    waits: list[float] = field(default_factory=list)


def start_server(batch: Path, db: Path, port: int) -> subprocess.Popen[bytes]:
    command = [
        sys.executable,
        "-m",
        "ncmodel.cli.main",
        "crowd",
        "serve",
        str(batch),
        "--db",
        str(db),
        "--port",
        str(port),
    ]
    process = subprocess.Popen([*command, "--completion-code", "X"], stderr=subprocess.DEVNULL)
    for _ in range(300):
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return process
        time.sleep(0.1)
    raise AssertionError("the server doesn't start")


async def insist(client: httpx2.AsyncClient, record: Record, method: str, path: str, **more: object) -> httpx2.Response:
    """Ask until the server answers: it is away for a while in between."""
    while True:
        begin = time.perf_counter()
        try:
            reply = await client.request(method, path, **more)  # type: ignore[arg-type]
        except httpx2.TransportError:
            await asyncio.sleep(0.2)
            continue
        record.waits.append(time.perf_counter() - begin)
        return reply


async def take_part(base: str, key: Key, number: int, record: Record) -> None:
    """One participant, from the link to the end, as fast as the server lets it."""
    async with httpx2.AsyncClient(base_url=base, timeout=30) as client:
        name = f"worker{number}"
        reply = await insist(client, record, "GET", f"/?PROLIFIC_PID={name}")
        assert reply.status_code == 200
        reply = await insist(client, record, "POST", "/start", data={"PROLIFIC_PID": name, "agree": "yes"})
        assert reply.status_code == 303, reply.text
        page = (await insist(client, record, "GET", "/questions")).text
        secret, identifier = (
            re.search(r'nc_secret" value="(\w+)"', page),
            re.search(r'data-questionnaire="(\w+)"', page),
        )
        assert secret
        assert identifier
        questions = key.questionnaires[identifier[1]].questions
        for question in questions:
            value = list(question.options)[(number + question.number) % 8]
            body = json.dumps({"field": question.field, "value": value, "seconds": 1.5})
            reply = await insist(client, record, "POST", "/answer", content=body, headers={"X-NC-Secret": secret[1]})
            assert reply.status_code == 200, reply.text
            record.acknowledged[question.field] = value
        sent = {"nc_secret": secret[1], **record.acknowledged}
        reply = await insist(client, record, "POST", "/finish", data=sent)
        assert reply.headers["location"] == "/done"
        record.finished = True


async def everybody(base: str, key: Key, records: list[Record]) -> None:
    await asyncio.wait_for(
        asyncio.gather(*(take_part(base, key, number, record) for number, record in enumerate(records))), SECONDS
    )


def test_two_hundred_at_once_and_a_killed_server(tmp_path: Path) -> None:
    data = make_data(tmp_path / "data", shapes=20, views=1)
    artists = make_artists(tmp_path / "artists", data)
    needs = dict.fromkeys(DataFolder(data).items(), PARTICIPANTS // 2)
    make_batch(
        data, tmp_path / "batch", needs, Scheme(real=10, sentinels=2, pool=5), Look(16, 16), ArtistsFolder(artists)
    )
    key, db = Key.load(tmp_path / "batch"), tmp_path / "votes.sqlite"
    assert len(key.questionnaires) == PARTICIPANTS
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    records = [Record() for _ in range(PARTICIPANTS)]
    server = start_server(tmp_path / "batch", db, port)
    begin = time.perf_counter()

    async def run() -> None:
        nonlocal server
        crowd = asyncio.create_task(everybody(f"http://127.0.0.1:{port}", key, records))
        while sum(len(record.acknowledged) for record in records) < PARTICIPANTS * 6 and not crowd.done():
            await asyncio.sleep(0.05)
        os.kill(server.pid, signal.SIGKILL)
        server.wait()
        server = await asyncio.to_thread(start_server, tmp_path / "batch", db, port)
        await crowd

    try:
        asyncio.run(run())
    finally:
        server.kill()
        server.wait()
    seconds = time.perf_counter() - begin
    waits = sorted(wait for record in records for wait in record.waits)
    middle, late = waits[len(waits) // 2], waits[int(0.99 * len(waits))]
    sys.stderr.write(
        f"{len(waits)} requests in {seconds:.1f} s, median {1000 * middle:.0f} ms, 99 % {1000 * late:.0f} ms\n"
    )
    assert all(record.finished for record in records)

    stored: dict[str, dict[str, str]] = {}
    with sqlite3.connect(db) as connection:
        rows = connection.execute(
            "SELECT worker, field, value FROM answers JOIN participants ON participant = id"
        ).fetchall()
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        taken = connection.execute("SELECT count(*), count(DISTINCT worker) FROM participants").fetchone()
        handed = connection.execute("SELECT max(n) FROM (SELECT count(*) n FROM participants GROUP BY questionnaire)")
        assert handed.fetchone() == (1,)
    for worker, name, value in rows:
        stored.setdefault(worker, {})[name] = value
    for number, record in enumerate(records):
        assert record.acknowledged.items() <= stored.get(f"worker{number}", {}).items(), "acknowledged, and lost"
    assert taken == (PARTICIPANTS, PARTICIPANTS)
    done = ingest_results(tmp_path / "batch", [db, db], tmp_path / "votes.csv")
    votes = vote_rows(tmp_path / "votes.csv")
    assert (done.assignments, done.known_assignments, done.problems) == (PARTICIPANTS, PARTICIPANTS, [])
    assert len({(vote.worker, vote.question) for vote in votes}) == len(votes) == 12 * PARTICIPANTS
