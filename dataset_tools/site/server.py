"""The site put together and served."""

import os
import re
import secrets
import signal
import socket
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

from starlette.applications import Starlette
from starlette.middleware import Middleware

from dataset_tools.questionnaires.questionnaire import KEY_NAME, read_key
from dataset_tools.site.connections import PER_CLIENT, RESERVED, Door, most_connections
from dataset_tools.site.database import Policy, SiteStore
from dataset_tools.site.participant_pages import RateLimits, Settings, Site
from dataset_tools.site.requester_pages import Admin
from dataset_tools.site.security import LOOPBACK, Guard, failed
from dataset_tools.site.served_batch import SiteBatch
from ncmodel.errors import ArgumentError, InputError, UsageError

WAITING = 2048
"""Connections that wait to be let in."""

AT_ONCE = RESERVED // 4
"""Of those, how many are let in before what they do is looked at."""


@dataclass(frozen=True)
class SiteFiles:
    """Where a site's files are.

    Attributes:
        batch_dir: The batch.
        database: What was answered.
        token: The file with the requester's token; made with a new one if there is none.
    """

    batch_dir: Path
    database: Path
    token: Path


def make_app(
    files: SiteFiles, settings: Settings, policy: Policy, limits: RateLimits | None = None
) -> tuple[Starlette, SiteStore]:
    """The site as an ASGI application, and its store, which the caller closes.

    Raises:
        InputError: The batch or the database can't be used.
    """
    limits = limits or RateLimits()
    batch = SiteBatch(files.batch_dir)
    store = SiteStore(files.database, batch.identifiers, policy, time.time)
    site = Site(batch, store, settings, limits)
    secure = settings.public_url.startswith("https:")
    token = read_token(files.token)
    admin = Admin(store, files.database, _items_of(files.batch_dir), token, policy.places, limits.logins, secure)
    guard = Middleware(Guard, public_url=settings.public_url, proxies=settings.proxies)
    app = Starlette(routes=[*site.routes(), *admin.routes()], middleware=[guard], exception_handlers={500: failed})
    # To an address with a slash too many it would answer with one made of the request's Host.
    app.router.redirect_slashes = False
    return app, store


def _items_of(batch_dir: Path) -> dict[str, list[str]]:
    """Questionnaire -> what it asks about, sentinels excluded."""
    listed: Mapping[str, Mapping[str, Sequence[Mapping[str, object]]]] = read_key(batch_dir)["questionnaires"]
    return {
        name: list(
            dict.fromkeys(
                f"{one.get('shape')} {one.get('view')}" for one in entry["questions"] if not one.get("sentinel")
            )
        )
        for name, entry in listed.items()
    }


def read_token(path: Path) -> str:
    """The requester's token; a new one, in a file that only its owner reads, if there is none.

    Raises:
        UsageError: The file holds something too short to be safe.
    """
    if not path.exists():
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(secrets.token_urlsafe(24) + "\n")
    token = path.read_text(encoding="utf-8").strip()
    if len(token) < 16:
        raise UsageError(f"{path}: a token of {len(token)} characters, expected 16 or more")
    return token


@dataclass(frozen=True)
class Addresses:
    """Where a site that is being served can be reached.

    Attributes:
        participants: The link for participants.
        requester: The requester's page.
        token: The file with the requester's token.
        port: The port that is listened on.
        notes: What the requester should know.
    """

    participants: str
    requester: str
    token: Path
    port: int
    notes: tuple[str, ...]

    def record(self) -> dict[str, object]:
        """As a JSON object."""
        return {**asdict(self), "token": str(self.token), "notes": list(self.notes)}

    def text(self) -> str:
        """For people."""
        lines = [f"participants: {self.participants}", f"requester: {self.requester}, token in {self.token}"]
        return "\n".join([*lines, *self.notes])


def serve(
    files: SiteFiles,
    settings: Settings,
    policy: Policy,
    host: str,
    port: int,
    announce: Callable[[Addresses], None],
) -> None:
    """Serve the site until interrupted or told to end; then the database file holds all answers by itself.

    Args:
        files: Where its files are.
        settings: What the requester decides.
        policy: Who gets which questionnaire.
        host: Address to listen on.
        port: Port to listen on, 0 for a free one.
        announce: Called once the site listens.

    Raises:
        InputError: The batch or the database can't be used.
        UsageError: The address can't be listened on.
    """
    import uvicorn

    app, store = make_app(files, settings, policy)
    door = Door(most_connections(), 0 if settings.proxies else PER_CLIENT)
    # Addresses of requests hold participants' numbers, so none are logged. What proxies say of where a request comes
    # from is read by `Guard`, which knows how many there are.
    config = uvicorn.Config(
        app, host=host, port=port, log_level="warning", access_log=False, server_header=False,
        proxy_headers=False, timeout_keep_alive=30, timeout_graceful_shutdown=10, http=door.protocol(),
        backlog=AT_ONCE,
    )  # fmt: skip
    try:
        with _ending_on_term(), _listening(host, port) as listener:
            announce(_addresses(host, listener.getsockname()[1], settings, files))
            uvicorn.Server(config).run(sockets=[listener])
    finally:
        store.close()


@contextmanager
def _ending_on_term() -> Iterator[None]:
    """SIGTERM, which systemd and docker send, ends the block as an exit does instead of killing the process in it."""

    def end(*_: object) -> None:
        raise SystemExit(0)

    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


class _Listener(socket.socket):
    """A socket on which many wait to be let in, while few are let in at once.

    asyncio lets in as many as are to wait before the door sees the first of them, and then runs out of open files:
    https://github.com/python/cpython/issues/151615
    """

    def listen(self, backlog: int = WAITING) -> None:
        """Listen, whatever fewer `backlog` says."""
        super().listen(max(backlog, WAITING))


def _listening(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        listener = _Listener(fileno=socket.create_server((host, port), family=family).detach())
    except OSError as error:
        found = f"{host}:{port}, which can't be listened on ({error.strerror})"
        raise ArgumentError("port", found, "a free one") from error
    # Connections inherit it; without it, the second answer on a connection waits 40 ms for the first one's receipt.
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return listener


def site_parameters(parameters: str) -> tuple[str, ...]:
    """Names of recruiting parameters from a comma-separated list.

    Raises:
        UsageError: There is none, or one can't stand in a link.
    """
    names = tuple(name.strip() for name in parameters.split(",") if name.strip())
    if not names or not all(re.fullmatch(r"\w{1,60}", name) for name in names):
        expected = "names of letters, digits and _, separated by commas"
        raise ArgumentError("parameters", repr(parameters), expected)
    return names


def read_consent(path: Path) -> tuple[str, ...]:
    """The paragraphs of a consent text.

    Raises:
        InputError: It can't be read or is empty.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(path, f"can't be read ({error})", "a text file in UTF-8") from error
    paragraphs = tuple(line.strip() for line in lines if line.strip())
    if not paragraphs:
        raise InputError(path, "no text", "what participants agree to")
    return paragraphs


def _addresses(host: str, port: int, settings: Settings, files: SiteFiles) -> Addresses:
    base = settings.public_url or f"http://{f'[{host}]' if ':' in host else host}:{port}"
    link = f"{base}/?" + "&".join(f"{name}=..." for name in settings.parameters)
    notes = []
    if not settings.public_url:
        reach = "only this machine can reach it" if host in LOOPBACK else "WITHOUT TLS: answers can be read on the way"
        notes.append(
            f"{reach}; to open it to others put a proxy with TLS (caddy, nginx) before this address on loopback and "
            "start again with the public URL https://YOUR.HOST"
        )
    elif not settings.proxies:
        notes.append("limits take all behind the proxy for one, unless you say how many proxies add to X-Forwarded-For")
    notes += _open_files(files)
    return Addresses(link, f"{base}/admin", files.token, port, tuple(notes))


def _open_files(files: SiteFiles) -> Iterator[str]:
    """What others on this machine could read, and what that would tell them."""
    private = {
        files.batch_dir / KEY_NAME: "tells all answers",
        files.database: "holds participants' numbers and answers",
        files.token: "opens the requester's page",
    }
    for path, tells in private.items():
        if path.stat().st_mode & 0o077:
            yield f"other users of this machine can open {path}, which {tells}: chmod 600 {path}"
