"""The self-hosted site: consent, one questionnaire a participant, answers kept one by one, a page for the requester.

An ASGI application on a `SiteBatch` and a `SiteStore`. Participants are told apart by a secret in a cookie; changes
need a second secret that only pages of this site know. What participants receive never depends on the key.
"""

import hashlib
import hmac
import json
import re
import secrets
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from urllib.parse import SplitResult, quote, urlsplit

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from dataset_tools.questionnaires.pages import asset, render
from dataset_tools.site.database import Assignment, Refusal, SiteStore, State
from dataset_tools.site.links import SIGNATURE, is_signed
from dataset_tools.site.rate_limit import RateLimit
from dataset_tools.site.security import address, form, headers, redirect
from dataset_tools.site.served_batch import SiteBatch
from dataset_tools.votes.results_csv import parse_seconds, sensible_seconds
from ncmodel.errors import ArgumentError
from ncmodel.parsing import parse_json

SESSION = "nc_session"
PICTURES_FIELD = "pictures"
"""Form field with how often pictures of each question didn't come, as in the results of other platforms."""

_PARAMETER = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.@-]{0,99}")

CONSENT = (
    "This study asks which line drawings of 3D shapes people find best.",
    "We keep your answers, how long each takes, and the participant number that your recruiting service gave us. "
    "We don't ask for your name or anything else about you.",
    "Taking part is voluntary. You can stop at any time by closing the page.",
)


@dataclass(frozen=True)
class Settings:
    """What the requester decides.

    Attributes:
        parameters: Names of the recruiting parameters in the link; the first says who the participant is.
        open_to_all: Let people without that parameter take part, as somebody new.
        completion_code: Shown at the end; "" for none.
        completion_url: Where the end page leads, `{code}` being the code; "" for nowhere.
        consent: Paragraphs of the consent page.
        contact: Whom to ask.
        public_url: The address that participants use, where a proxy with TLS stands before the site; "" on loopback.
        proxies: How many proxies before the site write where requests come from.
        link_token: The requester's token where only people with a link of the requester's may take part; "" for others.
    """

    parameters: tuple[str, ...] = ("PROLIFIC_PID", "STUDY_ID", "SESSION_ID")
    open_to_all: bool = False
    completion_code: str = ""
    completion_url: str = "https://app.prolific.com/submissions/complete?cc={code}"
    consent: tuple[str, ...] = CONSENT
    contact: str = ""
    public_url: str = ""
    proxies: int = 0
    link_token: str = ""

    def __post_init__(self) -> None:
        parts = _web_address(self.public_url)
        if self.public_url and (parts is None or parts.path.strip("/") or parts.query):
            raise ArgumentError("public_url", repr(self.public_url), "https://HOST: the site wants all of a host")
        if self.completion_url and _web_address(self.completion_url) is None:
            raise ArgumentError("completion_url", repr(self.completion_url), "https://HOST/..., or nothing")

    @property
    def completion_link(self) -> str:
        """Where the end page leads, "" for nowhere."""
        needs_code = "{code}" in self.completion_url
        if not self.completion_url or (needs_code and not self.completion_code):
            return ""
        return self.completion_url.replace("{code}", quote(self.completion_code, safe=""))


@dataclass(frozen=True)
class RateLimits:
    """How often a participant or an address may do something: (burst, times a second)."""

    answers: tuple[int, float] = (120, 5.0)
    starts: tuple[int, float] = (400, 5.0)
    logins: tuple[int, float] = (5, 0.05)


@dataclass
class Site:
    """The site's pages for participants.

    Attributes:
        batch: What is asked.
        store: What was answered.
        settings: What the requester decides.
        limits: How often things may be done.
        clock: Seconds, for the limits.
    """

    batch: SiteBatch
    store: SiteStore
    settings: Settings = field(default_factory=Settings)
    limits: RateLimits = field(default_factory=RateLimits)
    clock: Callable[[], float] = time.monotonic

    def __post_init__(self) -> None:
        self._answers = RateLimit(*self.limits.answers, self.clock)
        self._starts = RateLimit(*self.limits.starts, self.clock)
        self._page_headers = headers(self.batch.hashes("script"), self.batch.hashes("style"))

    def routes(self) -> list[Route]:
        """Where the pages are."""
        return [
            Route("/", self.welcome),
            Route("/start", self.start, methods=["POST"]),
            Route("/questions", self.questions),
            Route("/answer", self.answer, methods=["POST"]),
            Route("/finish", self.finish, methods=["POST"]),
            Route("/done", self.done),
            Route("/images/{name}", self.picture),
            Route("/static/{name}", self.static),
            Route("/health", self.health),
        ]

    async def welcome(self, request: Request) -> Response:
        """The consent page; who has begun goes on where they were, unless the link names somebody else."""
        assignment = await self._assignment(request)
        named = request.query_params.get(self.settings.parameters[0], "")
        if assignment is not None and assignment.state is not State.ABANDONED and named in ("", assignment.worker):
            return redirect("/done" if assignment.state is State.FINISHED else "/questions")
        parameters = self._parameters(request.query_params)
        if parameters is None:
            text = "Please use the link that your recruiting service gave you."
            return self._message("This link isn't complete", text, 400)
        questions = max(map(len, self.batch.questions.values()))
        if self.settings.link_token:
            parameters[SIGNATURE] = request.query_params[SIGNATURE]
        page = render("site_consent.html.j2", settings=self.settings, parameters=parameters, questions=questions)
        return HTMLResponse(page, headers=headers())

    async def start(self, request: Request) -> Response:
        """Agreed: hand out a questionnaire."""
        if not self._starts.allows(address(request)):
            return self._message("Too many people are starting just now", "Please try again in a minute.", 429)
        given = await form(request)
        parameters = self._parameters(given)
        if parameters is None or given.get("agree") != "yes":
            return self._message("Something was missing", "Please go back, tick the box and try again.", 400)
        worker = parameters.get(self.settings.parameters[0]) or f"guest-{secrets.token_hex(8)}"
        begun = await run_in_threadpool(self.store.begin, worker, parameters)
        if isinstance(begun, Refusal):
            return self._refused(begun)
        response = redirect("/questions")
        secure = self.settings.public_url.startswith("https:")
        response.set_cookie(SESSION, begun, max_age=14 * 86400, httponly=True, secure=secure, samesite="lax")
        return response

    async def questions(self, request: Request) -> Response:
        """The questionnaire, with what was answered so far."""
        assignment = await self._assignment(request)
        if assignment is None or assignment.state is not State.ACTIVE:
            return self._closed(request, assignment)
        answers = await run_in_threadpool(self.store.answers, assignment.id)
        return self._questionnaire(request, assignment, answers, "")

    def _questionnaire(
        self, request: Request, assignment: Assignment, answers: Mapping[str, str], message: str, status: int = 200
    ) -> Response:
        page = render(
            "site_questions.html.j2",
            fragment=self.batch.fragment(assignment.questionnaire, answers),
            secret=_csrf_token(request.cookies[SESSION]),
            message=message,
        )
        return HTMLResponse(page, status, headers=self._page_headers)

    async def answer(self, request: Request) -> Response:
        """Keep one answer; the reply comes when it is on disk."""
        assignment = await self._assignment(request)
        if assignment is None or not _has_csrf_token(request, request.headers.get("x-nc-secret", "")):
            return JSONResponse({"error": "no session"}, 403, headers=headers())
        if not self._answers.allows(assignment.id):
            return JSONResponse({"error": "too fast"}, 429, headers={**headers(), "Retry-After": "2"})
        try:
            record = parse_json(await request.body())
            name, value = str(record["field"]), str(record["value"])
        except (ValueError, KeyError, TypeError):
            return JSONResponse({"error": "not an answer"}, 400, headers=headers())
        if not self.batch.accepts(assignment.questionnaire, name, value):
            return JSONResponse({"error": "not an answer to this questionnaire"}, 400, headers=headers())
        spent = sensible_seconds({name: record.get("seconds")}).get(name, 0.0)
        kept = await run_in_threadpool(self.store.save, assignment.id, {name: (value, spent)})
        return JSONResponse({"saved": kept}, 200 if kept else 409, headers=headers())

    async def finish(self, request: Request) -> Response:
        """Keep all answers and close the questionnaire, if every question has one."""
        assignment = await self._assignment(request)
        given = await form(request)
        if assignment is None or assignment.state is not State.ACTIVE:
            return self._closed(request, assignment)
        if not _has_csrf_token(request, given.get("nc_secret", "")):
            return self._message("This form is out of date", "Please open the questions and send them again.", 403)
        spent = parse_seconds(given.get("seconds", ""))
        sent = {
            name: (given[name], spent.get(name, 0.0))
            for name in self.batch.questions[assignment.questionnaire]
            if self.batch.accepts(assignment.questionnaire, name, given.get(name, ""))
        }
        if pictures := parse_seconds(given.get("pictures", "")):
            missed = {name: int(count) for name, count in pictures.items() if name in sent}
            sent[PICTURES_FIELD] = (json.dumps(missed), 0.0)
        await run_in_threadpool(self.store.save, assignment.id, sent)
        if await run_in_threadpool(
            self.store.finish, assignment.id, partial(self.batch.judge, assignment.questionnaire)
        ):
            return redirect("/done")
        answers = await run_in_threadpool(self.store.answers, assignment.id)
        left = len(self.batch.questions[assignment.questionnaire].keys() - answers.keys())
        message = f"{left} question{'s' if left > 1 else ''} still need{'' if left > 1 else 's'} an answer."
        return self._questionnaire(request, assignment, answers, message, 422)

    async def done(self, request: Request) -> Response:
        """Thanks, and the completion code."""
        assignment = await self._assignment(request)
        if assignment is None or assignment.state is not State.FINISHED:
            return self._closed(request, assignment)
        return HTMLResponse(render("site_done.html.j2", settings=self.settings), headers=headers())

    async def picture(self, request: Request) -> Response:
        """A picture of the batch, by its opaque name; nothing else can be named."""
        path = self.batch.pictures.get(request.path_params["name"])
        if path is None:
            return PlainTextResponse("no such picture", 404, headers=headers())
        data = await run_in_threadpool(path.read_bytes)
        # No age and no tag: both come from the file and could tell one kind of picture from another.
        kept = {"Cache-Control": "private, max-age=86400, immutable"}
        return Response(data, media_type="image/png", headers={**headers(), **kept})

    async def static(self, request: Request) -> Response:
        """A style sheet or script of the site's own."""
        kinds = {"site.css": "text/css", "site.js": "text/javascript", "site_begin.js": "text/javascript"}
        name = request.path_params["name"]
        if name not in kinds:
            return PlainTextResponse("no such file", 404, headers=headers())
        return Response(asset(name), media_type=kinds[name], headers={**headers(), "Cache-Control": "no-cache"})

    async def health(self, request: Request) -> Response:
        """For a proxy that asks whether the site lives."""
        return PlainTextResponse("ok", headers=headers())

    async def _assignment(self, request: Request) -> Assignment | None:
        secret = request.cookies.get(SESSION, "")
        return await run_in_threadpool(self.store.find, secret) if secret else None

    def _parameters(self, given: Mapping[str, str]) -> dict[str, str] | None:
        """The recruiting parameters in a link or form; None if the one that says who it is is missing or odd."""
        names, token = self.settings.parameters, self.settings.link_token
        found = {name: given[name] for name in (*names, SIGNATURE) if _PARAMETER.fullmatch(given.get(name, ""))}
        signed = found.pop(SIGNATURE, "")
        if token and not (names[0] in found and is_signed(token, found[names[0]], signed)):
            return None
        return found if self.settings.open_to_all or names[0] in found else None

    def _closed(self, request: Request, assignment: Assignment | None) -> Response:
        if assignment is not None and assignment.state is State.FINISHED:
            return redirect("/done")
        if assignment is not None and assignment.state is State.ACTIVE:
            return redirect("/questions")
        if not request.cookies.get(SESSION):
            text = (
                "This study keeps your place with a cookie, and your browser sent none: it may refuse cookies, here or "
                "everywhere, or they were deleted. Please allow cookies for this site, or take another browser, and "
                "open the link that you were given once more."
            )
            return self._message("Your browser doesn't keep our cookie", text, 403)
        if assignment is not None:
            text = "You were away for long, and your questions were given to somebody else."
            return self._message("Your time is over", text, 410)
        return self._message("We don't know you here", "Please start with the link that you were given.", 403)

    def _refused(self, refusal: Refusal) -> Response:
        texts = {
            Refusal.FULL: ("All places are taken", "Thank you for your interest; there is nothing to do just now."),
            Refusal.DONE: ("You have taken part already", "Everybody can take part once. Thank you!"),
            Refusal.ELSEWHERE: ("You have begun already", "Please go on in the browser in which you began."),
        }
        return self._message(*texts[refusal], 409)

    def _message(self, title: str, text: str, status: int) -> Response:
        page = render("site_message.html.j2", title=title, text=text, contact=self.settings.contact)
        return HTMLResponse(page, status, headers=headers())


def _web_address(text: str) -> SplitResult | None:
    """An address of the web in parts; None for any other text."""
    try:
        parts = urlsplit(text)
    except ValueError:
        return None
    return parts if parts.scheme in ("http", "https") and parts.netloc else None


def _csrf_token(secret: str) -> str:
    """What pages send along with changes; another site can neither read it nor work it out."""
    return hmac.new(secret.encode(), b"change", hashlib.sha256).hexdigest()


def _has_csrf_token(request: Request, given: str) -> bool:
    return hmac.compare_digest(given.encode(), _csrf_token(request.cookies.get(SESSION, "")).encode())
