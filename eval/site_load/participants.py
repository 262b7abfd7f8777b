"""Simulated participants who use the site as a browser does: its pages, pictures, cookies, over one kept connection."""

import http.client
import json
import re
import time
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from urllib.parse import urlencode

PAUSE = 0.25
"""Seconds until a request that came to nothing is sent again, as the site's own page does."""

ANSWER_SECONDS = 30.0
"""How long an answer from the server is waited for."""

_CHOICE = re.compile(r'name="?(q\d+)"? value="([^"]+)"')
_PICTURE = re.compile(r'src="(/images/[^"]+)"')


@dataclass
class Record:
    """What one participant sent, and what the server acknowledged.

    Attributes:
        worker: The participant's name.
        acknowledged: Field -> value of each answer that the server said it has.
        finished: The server said that it has the questionnaire.
        waits: Seconds from each request to the whole of its answer.
        errors: What came in place of answers -> how often.
    """

    worker: str
    acknowledged: dict[str, str] = field(default_factory=dict)
    finished: bool = False
    waits: list[float] = field(default_factory=list)
    errors: Counter[str] = field(default_factory=Counter)


@dataclass
class Browser:
    """One connection that is kept, and the cookies.

    Attributes:
        address: Host and port of the site, or the proxy before it.
        record: What is noted.
        deadline: When to give up, on `time.monotonic`.
    """

    address: tuple[str, int]
    record: Record
    deadline: float
    _cookies: dict[str, str] = field(default_factory=dict)
    _connection: http.client.HTTPConnection | None = None

    def ask(self, method: str, path: str, body: str = "", **headers: str) -> tuple[int, str]:
        """Send a request until the server answers it; redirects aren't followed.

        Returns:
            Status and text.

        Raises:
            TimeoutError: It didn't in time.
        """
        while time.monotonic() < self.deadline:
            begun = time.perf_counter()
            try:
                status, text = self._ask_once(method, path, body, headers)
            except (OSError, http.client.HTTPException) as error:
                self.record.errors[type(error).__name__] += 1
                self.close()
            else:
                if status < 500:
                    self.record.waits.append(time.perf_counter() - begun)
                    return status, text
                self.record.errors[str(status)] += 1
            time.sleep(PAUSE)
        raise TimeoutError(f"{self.record.worker}: {method} {path}")

    def _ask_once(self, method: str, path: str, body: str, headers: Mapping[str, str]) -> tuple[int, str]:
        if self._connection is None:
            self._connection = http.client.HTTPConnection(*self.address, timeout=ANSWER_SECONDS)
        host, port = self.address
        sent = {"Cookie": "; ".join(f"{name}={value}" for name, value in self._cookies.items()), **headers}
        self._connection.request(method, path, body or None, {**sent, "Origin": f"http://{host}:{port}"})
        reply = self._connection.getresponse()
        text = reply.read().decode(errors="replace")
        for cookie in reply.headers.get_all("Set-Cookie", []):
            name, _, value = cookie.partition(";")[0].partition("=")
            self._cookies[name] = value
        return reply.status, text

    def close(self) -> None:
        """Close the connection; the next request opens another."""
        if self._connection is not None:
            self._connection.close()
            self._connection = None


def take_part(browser: Browser, number: int) -> None:
    """One participant, from the link to the last page, as fast as the server lets them.

    Args:
        browser: What they use.
        number: Tells what they choose.

    Raises:
        TimeoutError: The server didn't answer in time.
        ValueError: It answered what it shouldn't.
    """
    record, form = browser.record, {"Content-Type": "application/x-www-form-urlencoded"}
    try:
        _expect(200, *browser.ask("GET", f"/?PROLIFIC_PID={record.worker}"))
        agreed = urlencode({"PROLIFIC_PID": record.worker, "agree": "yes"})
        _expect(303, *browser.ask("POST", "/start", agreed, **form))
        page = _expect(200, *browser.ask("GET", "/questions"))
        secret = re.search(r'nc_secret" value="(\w+)"', page)
        if secret is None:
            raise ValueError(f"no questions: {page[:200]}")
        for picture in sorted(set(_PICTURE.findall(page)))[:8]:  # of a question; a browser asks for the others later
            _expect(200, *browser.ask("GET", picture))
        offered: dict[str, list[str]] = {}
        for name, value in _CHOICE.findall(page):
            offered.setdefault(name, []).append(value)
        for place, (name, values) in enumerate(offered.items()):
            value = values[(number + place) % len(values)]
            body = json.dumps({"field": name, "value": value, "seconds": 2.5})
            said = _expect(200, *browser.ask("POST", "/answer", body, **{"X-NC-Secret": secret[1]}))
            if json.loads(said)["saved"]:
                record.acknowledged[name] = value
        sent = urlencode({"nc_secret": secret[1], **record.acknowledged})
        _expect(303, *browser.ask("POST", "/finish", sent, **form))
        record.finished = True
        _expect(200, *browser.ask("GET", "/done"))
    finally:
        browser.close()


def _expect(wanted: int, status: int, text: str) -> str:
    if status != wanted:
        raise ValueError(f"status {status} in place of {wanted}: {text[:200]}")
    return text
