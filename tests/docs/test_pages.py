"""The pages of the documentation: links lead somewhere, commands have the options they are shown with, names exist."""

import ast
import importlib
from pathlib import Path

import pytest
import typer
from typer.exceptions import TyperException

from ncmodel.cli.main import app
from tests.helpers.pages import PAGES, ROOT, Block, anchors, blocks, commands, links

SHELL = [block for page in PAGES for block in blocks(page, "sh")]
PYTHON = [block for page in PAGES for block in blocks(page, "python")]

PICTURES = 600_000
"""Bytes that the pictures of the documentation may have, all together."""


def check_command(argv: list[str]) -> None:
    """Raise if a command or an option doesn't exist, an argument is missing, or a number isn't one."""
    command = typer.main.get_command(app)
    while isinstance(command, typer.core.TyperGroup) and argv and not argv[0].startswith("-"):
        found = command.get_command(typer.Context(command), argv[0])
        assert found is not None, f"no command {argv[0]}"
        command, argv = found, argv[1:]
    if isinstance(command, typer.core.TyperGroup):
        # Parsing these would do what they say, such as to install completion.
        known = {name for parameter in command.params for name in parameter.opts} | {"--help", "-h"}
        assert set(argv) <= known, f"found {argv}, expected some of {sorted(known)}"
    else:
        command.make_context("ncontours", list(argv))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for link in links(page):
        if link.startswith(("http://", "https://")):
            continue
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), f"{page.name} links to {link}"
        assert not anchor or anchor in anchors(target), f"{page.name} links to {link}; {sorted(anchors(target))}"


def test_every_page_is_in_the_contents() -> None:
    listed = {link.partition("#")[0] for link in links(ROOT / "docs/index.md")}
    pages = {page.name for page in PAGES if page.parent.name == "docs"} - {"index.md"}
    assert pages <= listed


@pytest.mark.parametrize("block", SHELL, ids=lambda block: block.name)
def test_commands_exist_with_their_options(block: Block) -> None:
    for argv in commands(block):
        try:
            check_command(argv)
        except TyperException as error:
            pytest.fail(f"{block.name}: ncontours {' '.join(argv)}: {error.format_message()}")


def test_blocks_are_found() -> None:
    assert len(SHELL) > 40
    assert len(PYTHON) > 10
    assert sum(len(list(commands(block))) for block in SHELL) > 80


@pytest.mark.parametrize(
    "argv",
    [
        ["draw", "bunny.obj"],
        ["draw", "bunny.obj", "-o", "bunny.svg", "--no-such-option"],
        ["draw", "bunny.obj", "-o", "bunny.svg", "--azimuth", "front"],
        ["crowd", "ingest", "batch/", "-o", "votes.csv"],
    ],
)
def test_wrong_commands_are_noticed(argv: list[str]) -> None:
    with pytest.raises(TyperException):
        check_command(argv)


def test_unknown_commands_are_noticed() -> None:
    with pytest.raises(AssertionError, match="no command sketch"):
        check_command(["sketch", "bunny.obj"])
    with pytest.raises(AssertionError, match="--unknown"):
        check_command(["--unknown"])


@pytest.mark.parametrize("block", PYTHON, ids=lambda block: block.name)
def test_imported_names_exist(block: Block) -> None:
    for node in ast.walk(ast.parse(block.text)):
        if isinstance(node, ast.Import):
            for alias in node.names:
                importlib.import_module(alias.name)
        elif isinstance(node, ast.ImportFrom):
            module = importlib.import_module(str(node.module))
            for alias in node.names:
                assert hasattr(module, alias.name), f"{block.name}: {node.module} has no {alias.name}"


def test_pictures_are_small() -> None:
    files = [path for path in (ROOT / "docs").rglob("*") if path.suffix in (".png", ".svg")]
    assert sum(path.stat().st_size for path in files) < PICTURES
