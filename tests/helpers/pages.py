"""The documentation as tests read it: fenced blocks, commands in them, links and headings."""

import re
import shlex
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))

_FENCE = re.compile(r"^( *)```(\w*)\n(.*?)^\1```$", re.MULTILINE | re.DOTALL)
_LINK = re.compile(r"(?<!`)\[[^\]]*\]\(([^)\s]+)\)")
_HEADING = re.compile(r"^#+ (.+)$", re.MULTILINE)
_SEPARATORS = frozenset(["&&", "||", "|", ";", "&"])


@dataclass(frozen=True)
class Block:
    """A fenced block of a page.

    Attributes:
        page: The file.
        line: The line in it on which the block's text begins.
        language: What stands behind the fence.
        text: The block, dedented.
    """

    page: Path
    line: int
    language: str
    text: str

    @property
    def name(self) -> str:
        """Where it stands, to name a test and to find it."""
        return f"{self.page.name}:{self.line}"


def blocks(page: Path, language: str) -> list[Block]:
    """A page's fenced blocks in a language."""
    text = page.read_text(encoding="utf-8")
    found = []
    for match in _FENCE.finditer(text):
        line = text.count("\n", 0, match.start(3)) + 1
        found.append(Block(page, line, match.group(2), textwrap.dedent(match.group(3))))
    return [block for block in found if block.language == language]


def commands(block: Block) -> Iterator[list[str]]:
    """The arguments of each call of `ncontours` in a block of shell lines."""
    for line in block.text.replace("\\\n", " ").splitlines():
        # A substitution may hold quotes and parentheses that only a shell can tell apart.
        if "$(" in line:
            continue
        words = shlex.shlex(line, posix=True, punctuation_chars=True)
        words.whitespace_split, words.commenters = True, "#"
        yield from _calls(list(words))


def _calls(words: list[str]) -> Iterator[list[str]]:
    call: list[str] | None = None
    for word in words:
        if word in _SEPARATORS:
            if call is not None:
                yield call
            call = None
        elif call is None and Path(word).name == "ncontours":
            call = []
        elif call is not None:
            call.append(word)
    if call is not None:
        yield call


def prose(page: Path) -> str:
    """A page without its fenced blocks."""
    return _FENCE.sub("", page.read_text(encoding="utf-8"))


def links(page: Path) -> list[str]:
    """Where a page's links lead, those of pictures included."""
    return _LINK.findall(prose(page))


def anchors(page: Path) -> set[str]:
    """The anchors that GitHub gives a page's headings."""
    words = (re.sub(r"[^\w\- ]", "", heading.strip().lower()) for heading in _HEADING.findall(prose(page)))
    return {word.replace(" ", "-") for word in words}
