"""Connections that say nothing: the site stays reachable, whatever the limit on open files."""

import re
import resource
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

FILES = 150
"""The server's limit on open files: room for 86 connections."""
SILENT = 400


@pytest.fixture
def place(batch: Path, tmp_path: Path) -> Iterator[tuple[str, int]]:
    """Where a site listens that can open few files."""
    command = [sys.executable, "-m", "ncmodel.cli.main", "crowd", "serve", str(batch), "--port", "0"]
    log = (tmp_path / "log").open("w")

    def few_files() -> None:
        resource.setrlimit(resource.RLIMIT_NOFILE, (FILES, FILES))

    with subprocess.Popen(
        [*command, "--db", str(tmp_path / "db")], stderr=subprocess.PIPE, text=True, preexec_fn=few_files
    ) as process:
        assert process.stderr
        found = re.search(r"http://([\d.]+):(\d+)", process.stderr.readline())
        assert found
        yield found[1], int(found[2])
        process.terminate()
        log.write(process.stderr.read())
        assert process.wait(60) == 0
    log.close()
    assert (tmp_path / "log").stat().st_size < 10_000


def connections(place: tuple[str, int], count: int, sent: bytes) -> ExitStack:
    stack = ExitStack()
    for _ in range(count):
        one = stack.enter_context(socket.create_connection(place, timeout=20))
        if sent:
            one.sendall(sent)
    return stack


def is_reachable(place: tuple[str, int]) -> bool:
    with urllib.request.urlopen(f"http://{place[0]}:{place[1]}/health", timeout=20) as reply:
        return bool(reply.read() == b"ok")


@pytest.mark.parametrize("sent", [b"", b"GET /health HTTP/1.1\r\nHost: x\r\n"])
def test_silent_and_half_sent_connections_do_not_keep_people_out(place: tuple[str, int], sent: bytes) -> None:
    with connections(place, SILENT, sent):
        started = time.monotonic()
        assert all(is_reachable(place) for _ in range(5))
        assert time.monotonic() - started < 15.0


def test_connections_that_had_their_answer_do_not_either(place: tuple[str, int]) -> None:
    with connections(place, SILENT, b"GET /health HTTP/1.1\r\nHost: x\r\n\r\n"):
        assert is_reachable(place)


def test_of_one_address_few_are_silent_at_once(place: tuple[str, int]) -> None:
    """Those beyond are closed, the longest silent first; who asked meanwhile has the answer."""
    with socket.create_connection(place, timeout=20) as early:
        early.sendall(b"GET /health HTTP/1.1\r\nHost: x\r\n\r\n")
        with early.makefile("rb") as answer:
            assert answer.readline().split()[1] == b"200"
        with connections(place, SILENT, b""):
            assert is_reachable(place)
