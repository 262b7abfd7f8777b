"""The processes of a measurement: the site, nginx before it, and connections that say nothing."""

import os
import resource
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from ncmodel.errors import InputError

OPEN_FILES = 1024
"""The site's limit on open files, as systems have it by default."""

START_SECONDS = 120.0
"""How long a process may take until it listens."""

_NGINX = """
daemon off;
worker_processes 1;
pid {folder}/nginx.pid;
error_log {folder}/nginx.log;
events {{ worker_connections 4096; }}
http {{
  access_log off;
  client_body_temp_path {folder}/body;
  proxy_temp_path {folder}/proxy;
  fastcgi_temp_path {folder}/fastcgi;
  uwsgi_temp_path {folder}/uwsgi;
  scgi_temp_path {folder}/scgi;
  upstream site {{ server 127.0.0.1:{site}; keepalive 64; }}
  server {{
    listen 127.0.0.1:{port};
    location / {{
      proxy_pass http://site;
      proxy_http_version 1.1;
      proxy_set_header Connection "";
      proxy_set_header Host $host:{port};
      proxy_set_header X-Forwarded-For $proxy_add_x_forwarded_for;
    }}
  }}
}}
"""


def free_port() -> int:
    """A port of this machine that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@dataclass
class Site:
    """`ncontours crowd serve`, which can be ended and started again.

    Attributes:
        batch: What is served.
        folder: For its files.
        code: The checkout to run, so that an earlier one can stand beside this one.
        options: More of the command's options.
        port: Where it listens.
    """

    batch: Path
    folder: Path
    code: Path
    options: tuple[str, ...]
    port: int = field(default_factory=free_port)
    _process: "subprocess.Popen[bytes] | None" = None

    @property
    def database(self) -> Path:
        """Its database."""
        return self.folder / "votes.sqlite"

    def start(self) -> None:
        """Start it; returns once it listens.

        Raises:
            InputError: It doesn't come to that.
        """
        command = [sys.executable, "-m", "ncmodel.cli.main", "crowd", "serve", str(self.batch)]
        command += ["--db", str(self.database), "--port", str(self.port), "--completion-code", "X", *self.options]
        environment = {**os.environ, "PYTHONPATH": str(self.code)}
        with (self.folder / "site.log").open("ab") as log:
            self._process = subprocess.Popen(
                command, cwd=self.code, env=environment, stdout=log, stderr=log, preexec_fn=_few_files
            )
        _await(self.port, self._process, self.folder / "site.log")

    def end(self, number: signal.Signals) -> None:
        """Send it a signal, and wait until it is gone."""
        if self._process is not None:
            self._process.send_signal(number)
            self._process.wait()
            self._process = None


@contextmanager
def nginx(folder: Path, site: int, port: int) -> Iterator[None]:
    """A proxy that keeps connections to the site and to participants open.

    Args:
        folder: For its files.
        site: The site's port.
        port: Where it listens.
    """
    configuration = folder / "nginx.conf"
    configuration.write_text(_NGINX.format(folder=folder, site=site, port=port))
    with subprocess.Popen(["nginx", "-p", str(folder), "-c", str(configuration)]) as process:
        try:
            _await(port, process, folder / "nginx.log")
            yield
        finally:
            process.terminate()


@contextmanager
def silent(port: int, count: int) -> Iterator[None]:
    """Open connections to the site itself that never say anything; what it closes isn't opened again."""
    with ExitStack() as stack:
        for _ in range(count):
            one = stack.enter_context(socket.socket())
            one.setblocking(False)
            one.connect_ex(("127.0.0.1", port))
        yield


def allow_files(count: int) -> None:
    """Let this process open so many files, if it may."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft < count:
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(count, hard), hard))


def _few_files() -> None:
    resource.setrlimit(resource.RLIMIT_NOFILE, (OPEN_FILES, OPEN_FILES))


def _await(port: int, process: "subprocess.Popen[bytes]", log: Path) -> None:
    end = time.monotonic() + START_SECONDS
    while time.monotonic() < end and process.poll() is None:
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.05)
    said = log.read_text(errors="replace").strip().splitlines()[-1:] or ["nothing"]
    raise InputError(log, f"nobody listens on port {port} ({said[0]})", "a server")
