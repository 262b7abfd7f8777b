"""The requester's page of the site: how far the study is, votes on each item, flags, and the results to download."""

import hashlib
import hmac
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from dataset_tools.questionnaires.pages import render
from dataset_tools.questionnaires.questionnaire import UNSEEN
from dataset_tools.site.database import Assignment, SiteStore, State
from dataset_tools.site.rate_limit import RateLimit
from dataset_tools.site.security import address, form, headers, redirect
from dataset_tools.votes.results_sqlite import results_csv

COOKIE = "nc_admin"
FAST_SECONDS = 2.0
"""A participant whose median question took less is flagged."""


@dataclass(frozen=True)
class StudyStatus:
    """How far a study is."""

    questionnaires: int
    wanted: int
    active: int
    finished: int
    abandoned: int
    unreliable: int
    items: Sequence[tuple[str, int]]
    flags: Sequence[tuple[str, str]]


def status(
    assignments: Sequence[Assignment], items_of: Mapping[str, Sequence[str]], places: int, unseen: Mapping[str, int]
) -> StudyStatus:
    """Count participants and votes.

    Args:
        assignments: All of the site.
        items_of: Questionnaire -> names of what it asks about, sentinels excluded.
        places: Participants wanted for each questionnaire.
        unseen: Assignment -> how many of its questions had pictures that didn't come.
    """
    states = Counter(assignment.state for assignment in assignments)
    votes: Counter[str] = Counter({name: 0 for names in items_of.values() for name in names})
    for assignment in assignments:
        if assignment.state is State.FINISHED and assignment.reliable:
            votes.update(items_of[assignment.questionnaire])
    return StudyStatus(
        questionnaires=len(items_of),
        wanted=places * len(items_of),
        active=states[State.ACTIVE],
        finished=states[State.FINISHED],
        abandoned=states[State.ABANDONED],
        unreliable=sum(assignment.reliable is False for assignment in assignments),
        items=sorted(votes.items(), key=lambda pair: (pair[1], pair[0])),
        flags=[
            (assignment.worker, flag)
            for assignment in assignments
            for flag in _flags(assignment, items_of, unseen.get(assignment.id, 0))
        ],
    )


def _flags(assignment: Assignment, items_of: Mapping[str, Sequence[str]], unseen: int) -> list[str]:
    flags = [f"pictures of {unseen} question{'s' if unseen > 1 else ''} didn't come"] if unseen else []
    if assignment.finished is None:
        return flags
    if assignment.reliable is False:
        flags.append("failed a sentinel")
    if assignment.finished - assignment.started < FAST_SECONDS * len(items_of[assignment.questionnaire]):
        flags.append(f"took {assignment.finished - assignment.started:.0f} s")
    return flags


class Admin:
    """The requester's page.

    Args:
        store: What was answered.
        database: The store's file.
        items_of: Questionnaire -> names of what it asks about.
        token: Who knows it is the requester.
        places: Participants wanted for each questionnaire.
        logins: How often somebody may try: (burst, times a second).
        secure: Send the cookie over TLS only.
        clock: Seconds, for the limit.
    """

    def __init__(
        self,
        store: SiteStore,
        database: Path,
        items_of: Mapping[str, Sequence[str]],
        token: str,
        places: int,
        logins: tuple[int, float] = (5, 0.05),
        secure: bool = False,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._store, self._database, self._items_of, self._places = store, database, items_of, places
        self._token, self._secure = token, secure
        self._logins = RateLimit(*logins, clock)

    def routes(self) -> list[Route]:
        """Where the pages are."""
        return [
            Route("/admin", self.overview),
            Route("/admin/login", self.login, methods=["POST"]),
            Route("/admin/status.json", self.status),
            Route("/admin/results.csv", self.results),
        ]

    async def overview(self, request: Request) -> Response:
        """Live counts, votes an item, flags; or the form that asks for the token."""
        refused = self._refusal(request)
        if refused:
            return HTMLResponse(render("site_login.html.j2", message=""), refused, headers=headers())
        now = await self._status()
        return HTMLResponse(render("site_admin.html.j2", status=now), headers={**headers(), "Refresh": "15"})

    async def login(self, request: Request) -> Response:
        """Check the token."""
        if not self._logins.allows(address(request)):
            return HTMLResponse(render("site_login.html.j2", message="Too many tries; wait a minute."), 429, headers())
        given = (await form(request)).get("token", "").strip()
        if not hmac.compare_digest(given.encode(), self._token.encode()):
            return HTMLResponse(render("site_login.html.j2", message="That isn't the token."), 401, headers())
        response = redirect("/admin")
        response.set_cookie(
            COOKIE,
            self._login_proof(),
            max_age=86400,
            path="/admin",
            httponly=True,
            secure=self._secure,
            samesite="strict",
        )
        return response

    async def status(self, request: Request) -> Response:
        """The counts, for programs."""
        refused = self._refusal(request)
        if refused:
            return _refused(refused)
        return JSONResponse(_plain(await self._status()), headers=headers())

    async def results(self, request: Request) -> Response:
        """The questionnaires that were sent, as CSV."""
        refused = self._refusal(request)
        if refused:
            return _refused(refused)
        name = {"Content-Disposition": 'attachment; filename="results.csv"'}
        return StreamingResponse(results_csv(self._database), media_type="text/csv", headers={**headers(), **name})

    async def _status(self) -> StudyStatus:
        assignments = await run_in_threadpool(self._store.assignments)
        unseen = await run_in_threadpool(self._store.count_answers, UNSEEN)
        return status(assignments, self._items_of, self._places, unseen)

    def _refusal(self, request: Request) -> int:
        """The status of the refusal of somebody who isn't the requester, 0 for the requester.

        The cookie can't be guessed. Wrong tokens count as tries to log in, and after too many of them no token is
        looked at.
        """
        if hmac.compare_digest(request.cookies.get(COOKIE, "").encode(), self._login_proof().encode()):
            return 0
        scheme, _, bearer = request.headers.get("authorization", "").partition(" ")
        if scheme.lower() != "bearer":
            return 401
        if not self._logins.would_allow(address(request)):
            return 429
        if hmac.compare_digest(bearer.strip().encode(), self._token.encode()):
            return 0
        self._logins.allows(address(request))
        return 401

    def _login_proof(self) -> str:
        """What the cookie holds: proof of the token, not the token."""
        return hmac.new(self._token.encode(), b"admin", hashlib.sha256).hexdigest()


def _refused(status: int) -> Response:
    text = "too many wrong tokens; wait a minute" if status == 429 else "no token"
    return JSONResponse({"error": text}, status, headers=headers())


def _plain(now: StudyStatus) -> dict[str, Any]:
    return {**asdict(now), "items": dict(now.items), "flags": [list(flag) for flag in now.flags]}
