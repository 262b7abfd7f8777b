"""Connections that say nothing don't keep people out: they are closed in time, and first when room is needed.

A client that opens connections and sends nothing, or a header byte by byte, costs a file descriptor for each. Without
limits a few hundred of them make a site unreachable, since no new connection can be accepted any more.
"""

import resource
from collections import OrderedDict
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import asyncio

    from uvicorn.protocols.http.h11_impl import H11Protocol

HEADER_SECONDS = 20.0
"""How long a connection may take until its first request's header is there."""

PER_CLIENT = 100
"""Connections of one address that wait for a request's header, at once; a browser opens six."""

RESERVED = 64
"""File descriptors for the database, pictures, logs."""


def most_connections() -> int:
    """How many connections the process can hold; the limit on open files is raised as far as this user may."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft != hard:
        resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    return max((65_536 if hard == resource.RLIM_INFINITY else min(hard, 65_536)) - RESERVED, 16)


class Door:
    """Who is connected, and who of them keeps silent.

    Args:
        most: Connections in all.
        per_client: Silent connections of one address; 0 for no limit, as where all come from one proxy.
        header_seconds: How long a connection may keep silent: before its first request, or within a request's header.
    """

    def __init__(self, most: int, per_client: int = PER_CLIENT, header_seconds: float = HEADER_SECONDS) -> None:
        self._most, self._per_client, self._seconds = most, per_client, header_seconds
        self._inside: set[H11Protocol] = set()
        self._silent: dict[str, OrderedDict[H11Protocol, asyncio.TimerHandle]] = {}
        self._idle: OrderedDict[H11Protocol, None] = OrderedDict()

    def enter(self, connection: "H11Protocol") -> None:
        """A new connection; if there is no room, one that says nothing makes some, or one that had its answers."""
        if len(self._inside) >= self._most:
            self._close(next(iter(max(self._silent.values(), key=len, default=self._idle)), connection))
        self._inside.add(connection)
        self.waits(connection)

    def waits(self, connection: "H11Protocol") -> None:
        """A connection whose next request hasn't come whole; of one address's too many, the first is closed."""
        self._idle.pop(connection, None)
        own = self._silent.setdefault(_address(connection), OrderedDict())
        if connection in own:
            return
        if self._per_client and len(own) >= self._per_client:
            self._close(next(iter(own)))
        own = self._silent.setdefault(_address(connection), own)
        own[connection] = connection.loop.call_later(self._seconds, self._close, connection)

    def spoke(self, connection: "H11Protocol") -> None:
        """A request is there."""
        self._idle.pop(connection, None)
        own = self._silent.get(_address(connection), OrderedDict())
        if (timer := own.pop(connection, None)) is not None:
            timer.cancel()
        if not own:
            self._silent.pop(_address(connection), None)

    def rests(self, connection: "H11Protocol") -> None:
        """A connection had its answer, and nothing of another request has come."""
        self.spoke(connection)
        self._idle[connection] = None

    def leave(self, connection: "H11Protocol") -> None:
        """A connection ended."""
        self.spoke(connection)
        self._inside.discard(connection)

    def _close(self, connection: "H11Protocol") -> None:
        self.leave(connection)
        connection.transport.abort()

    def protocol(self) -> "type[H11Protocol]":
        """What uvicorn speaks with each connection."""
        from uvicorn.protocols.http.h11_impl import H11Protocol

        door = self

        class Guarded(H11Protocol):
            def connection_made(self, transport: "asyncio.Transport") -> None:  # type: ignore[override]
                super().connection_made(transport)
                door.enter(self)

            def handle_events(self) -> None:
                super().handle_events()
                if self.transport.is_closing():
                    return
                if self.cycle is not None and not self.cycle.response_complete:
                    door.spoke(self)
                elif self.cycle is not None and not self.conn.trailing_data[0]:
                    door.rests(self)
                else:
                    door.waits(self)

            def connection_lost(self, exc: Exception | None) -> None:
                door.leave(self)
                super().connection_lost(exc)

        return Guarded


def _address(connection: "H11Protocol") -> str:
    return connection.client[0] if connection.client else ""
