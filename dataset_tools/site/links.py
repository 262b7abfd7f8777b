"""Links that only the requester can make: each names one participant and proves it.

Without them whoever guesses a participant's number can begin in their place, and one person can take all places under
made-up numbers. Recruiting services make numbers up while people come, and can't sign; for one's own lists it helps.
"""

import csv
import hashlib
import hmac
import io
import secrets
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from urllib.parse import urlencode

from ncmodel.errors import InputError
from ncmodel.files import write_bytes

SIGNATURE = "sig"
"""Parameter of a link that proves the one who is named."""


def signature(token: str, worker: str) -> str:
    """What a participant's link carries.

    Args:
        token: The requester's.
        worker: Who the link is for.
    """
    return hmac.new(token.encode(), b"link " + worker.encode(), hashlib.sha256).hexdigest()[:32]


def is_signed(token: str, worker: str, given: str) -> bool:
    """Whether a link is one of the requester's."""
    return hmac.compare_digest(signature(token, worker).encode(), given.encode())


def read_workers(path: Path) -> list[str]:
    """Participants' numbers, one a line.

    Raises:
        InputError: The file can't be read, or names somebody twice.
    """
    try:
        lines = [line.strip() for line in path.read_text(encoding="utf-8-sig").splitlines()]
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(path, f"can't be read ({error})", "a text file with a participant's number a line") from error
    named = [line for line in lines if line]
    twice = next((name for name, times in Counter(named).items() if times > 1), None)
    if twice is not None or not named:
        raise InputError(path, f"{twice} twice" if named else "nobody", "a participant's number a line, each once")
    return named


def made_up(count: int) -> list[str]:
    """Numbers for participants who have none."""
    return [f"p{secrets.token_hex(6)}" for _ in range(count)]


def write_links(output: Path, base: str, parameter: str, workers: Sequence[str], token: str) -> None:
    """Write a CSV file of participants and their links, for its owner's eyes only."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["participant", "link"])
    for worker in workers:
        query = urlencode({parameter: worker, SIGNATURE: signature(token, worker)})
        writer.writerow([worker, f"{base.rstrip('/')}/?{query}"])
    write_bytes(output, text.getvalue().encode(), private=True)
