"""What stands before every page: sizes, origins, headers; and what pages do with requests and responses."""

import asyncio
from collections.abc import Sequence
from urllib.parse import parse_qsl, urlsplit

from starlette.datastructures import MutableHeaders
from starlette.requests import Request
from starlette.responses import PlainTextResponse, RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

MAX_BODY = 64 * 1024
"""Bytes of the largest request that a page of ours can send."""

LOOPBACK = ("127.0.0.1", "::1", "localhost")

BODY_SECONDS = 30.0
"""How long such a request takes over the slowest connection that can show the pictures."""


def headers(scripts: Sequence[str] = (), styles: Sequence[str] = ()) -> dict[str, str]:
    """Response headers of a page: nothing from elsewhere, nothing kept, nothing told.

    Args:
        scripts: Hashes of scripts that stand in the page.
        styles: Hashes of style sheets that stand in the page.
    """
    policy = (
        "default-src 'none'; img-src 'self' data:; connect-src 'self'; form-action 'self'; base-uri 'none'; "
        f"frame-ancestors 'none'; script-src {' '.join([chr(39) + 'self' + chr(39), *scripts])}; "
        f"style-src {' '.join([chr(39) + 'self' + chr(39), *styles])}"
    )
    return {
        "Content-Security-Policy": policy,
        "X-Content-Type-Options": "nosniff",
        "X-Frame-Options": "DENY",
        "Referrer-Policy": "same-origin",
        "Permissions-Policy": "camera=(), microphone=(), geolocation=()",
        "Cross-Origin-Opener-Policy": "same-origin",
        "Cache-Control": "no-store",
    }


class Guard:
    """Refuses bodies that are too large and changes that another site sent.

    Args:
        app: What it guards.
        public_url: The address that participants use; "" where it is the one they connect to.
        proxies: How many proxies before the site write where requests come from.
        body_seconds: How long a request's body may take.
    """

    def __init__(
        self, app: ASGIApp, public_url: str = "", proxies: int = 0, body_seconds: float = BODY_SECONDS
    ) -> None:
        self._app, self._proxies, self._body_seconds = app, proxies, body_seconds
        self._public_host = urlsplit(public_url).netloc

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle a request, as ASGI wants it."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        given = {name.decode("latin-1"): value.decode("latin-1") for name, value in scope["headers"]}
        if self._proxies:
            scope = {**scope, "client": self._client(scope)}
        if scope["method"] not in ("GET", "HEAD") and not self._from_here(given):
            await PlainTextResponse("sent by another site", 403, headers=headers())(scope, receive, send)
            return
        length = given.get("content-length", "0")
        if not length.isdecimal() or int(length) > MAX_BODY:
            await PlainTextResponse("too large", 413, headers=headers())(scope, receive, send)
            return
        try:
            async with asyncio.timeout(self._body_seconds):
                body = await _read(receive)
        except TimeoutError:
            await PlainTextResponse("too slow", 408, headers=headers())(scope, receive, send)
            return
        if body is None:
            await PlainTextResponse("too large", 413, headers=headers())(scope, receive, send)
            return
        messages: list[Message] = [{"type": "http.request", "body": body, "more_body": False}]

        async def replay() -> Message:
            return messages.pop() if messages else await receive()

        async def send_safely(message: Message) -> None:
            if message["type"] == "http.response.start":  # a missing page or a wrong method has no headers of ours
                given = MutableHeaders(scope=message)
                for name, value in headers().items():
                    given.setdefault(name, value)
            await send(message)

        await self._app(scope, replay, send_safely)

    def _from_here(self, given: dict[str, str]) -> bool:
        """Whether a change comes from a page of this site, as far as the browser says."""
        if given.get("sec-fetch-site", "same-origin") not in ("same-origin", "none"):
            return False
        origin = given.get("origin")
        if origin is None:
            return True
        host = given.get("host", "")
        try:
            sender, asked = urlsplit(origin).netloc, urlsplit(f"//{host}").hostname
        except ValueError:  # "http://[x" is no address
            return False
        # Where participants use another address, only who sits at the machine itself asks for this one.
        own = host if not self._public_host or asked in LOOPBACK else ""
        return sender != "" and sender in (self._public_host, own)

    def _client(self, scope: Scope) -> tuple[str, int] | None:
        """Where a request comes from: what the outermost of our proxies wrote, the last but so many in the header.

        What stands before it was there when the request came, and anybody can write that.
        """
        lines = [value.decode("latin-1") for name, value in scope["headers"] if name == b"x-forwarded-for"]
        named = [one.strip() for one in ",".join(lines).split(",") if one.strip()]
        client: tuple[str, int] | None = scope["client"]
        return (named[-self._proxies], 0) if len(named) >= self._proxies else client


async def _read(receive: Receive) -> bytes | None:
    """The whole body, or None if it is larger than any that our pages send."""
    parts, read, more = [], 0, True
    while more:
        message = await receive()
        parts.append(message.get("body", b""))
        read += len(parts[-1])
        more = message.get("more_body", False)
        if read > MAX_BODY:
            return None
    return b"".join(parts)


async def form(request: Request) -> dict[str, str]:
    """The fields of a form; one that can't be read is empty."""
    try:
        return dict(parse_qsl((await request.body()).decode("utf-8"), keep_blank_values=True, max_num_fields=2000))
    except ValueError:
        return {}


async def failed(request: Request, error: Exception) -> PlainTextResponse:
    """What is shown where something went wrong that shouldn't; the log has the rest."""
    return PlainTextResponse("something went wrong here; please try again", 500, headers=headers())


def redirect(where: str) -> RedirectResponse:
    """Go on at another page of the site."""
    return RedirectResponse(where, 303, headers=headers())


def address(request: Request) -> str:
    """Where a request comes from, for limits."""
    return request.client.host if request.client else ""
