"""The `ncontours` command: commands found through entry points, errors as one line and an exit status.

Any installed package may add a command: an entry point in the group `ncontours.commands` names a function with
Typer's annotations, or a `typer.Typer` for a group of commands. A command's module is loaded when it is called.
"""

import os
import sys
from collections.abc import Sequence
from functools import cached_property
from importlib.metadata import EntryPoint, PackageNotFoundError, distribution, entry_points
from typing import Any

import typer
from typer.core import TyperGroup
from typer.exceptions import TyperException

from ncmodel.errors import ArgumentError, BatchError, NeuralContoursError, UsageError

DISTRIBUTION = "neural-contours"
GROUP = "ncontours.commands"
_SETTINGS = {"help_option_names": ["-h", "--help"]}


class Commands(TyperGroup):
    """The commands of all installed packages; our own come first and can't be replaced."""

    @cached_property
    def own(self) -> dict[str, EntryPoint]:
        """Name -> entry point of this distribution's commands: cheap to find, unlike everybody's."""
        try:
            points = distribution(DISTRIBUTION).entry_points
        except PackageNotFoundError:
            raise UsageError(f"{DISTRIBUTION} isn't installed, so its commands aren't known: pip install .") from None
        return {point.name: point for point in points.select(group=GROUP)}

    @cached_property
    def everybodys(self) -> dict[str, EntryPoint]:
        """Name -> entry point of all commands."""
        others = {point.name: point for point in sorted(entry_points(group=GROUP), key=lambda point: point.value)}
        return {**self.own, **{name: point for name, point in others.items() if name not in self.own}}

    def list_commands(self, ctx: Any) -> list[str]:
        """The names of all commands."""
        return list(self.everybodys)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The command of that name, its module loaded; None if there is none."""
        point = self.own.get(cmd_name) or self.everybodys.get(cmd_name)
        return None if point is None else _load(point)


def _load(point: EntryPoint) -> Any:
    """The command that an entry point names; of one that can't be loaded, a command that says so."""
    try:
        return _command(point.name, point.load())
    except Exception as error:  # a stranger's module may raise anything
        reason = f"{point.name}: can't be loaded from {point.value} ({type(error).__name__}: {error})"

        def complain() -> None:
            raise UsageError(reason)

        complain.__doc__ = reason
        return _command(point.name, complain)


def _command(name: str, found: Any) -> Any:
    """A command from a function with Typer's annotations, a group from a `typer.Typer`."""
    holder = typer.Typer(add_completion=False, context_settings=_SETTINGS)
    if isinstance(found, typer.Typer):
        holder.add_typer(found, name=name)
    else:
        holder.command(name)(found)
        # Without a callback, an application with one command would take its name for an argument.
        holder.callback()(lambda: None)
    return typer.main.get_group(holder).commands[name]


app = typer.Typer(
    cls=Commands,
    help="Learned line drawings of 3D shapes.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings=_SETTINGS,
)


def _show_version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        sys.stdout.write(f"ncontours {version(DISTRIBUTION)}\n")
        raise typer.Exit


@app.callback()
def _root(
    version: bool = typer.Option(False, "--version", callback=_show_version, is_eager=True, help="Show the version."),
) -> None:
    """Learned line drawings of 3D shapes."""


def run(argv: Sequence[str] | None = None) -> int:
    """Run one command and let its errors pass; `main` turns them into a line and a status."""
    status = app(args=None if argv is None else list(argv), prog_name="ncontours", standalone_mode=False)
    sys.stdout.flush()
    return status if isinstance(status, int) else 0


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        argv: Arguments without the program's name; `sys.argv` by default.

    Returns:
        Exit status: 0 done, 1 some items of a batch failed, 2 bad usage or bad input.
    """
    try:
        return run(argv)
    except BatchError as error:
        return _complain(error, 1)
    except ArgumentError as error:
        return _complain(error.as_option, 2)
    except NeuralContoursError as error:
        return _complain(error, 2)
    except TyperException as error:
        # Without arguments the help has been printed already, and the message is empty.
        message = error.format_message()
        return _complain(f"{message} Try --help." if message else "expected a command", 2)
    except (typer.Abort, KeyboardInterrupt):
        return _complain("interrupted", 130)
    except BrokenPipeError:
        # The reader of our output went away (`| head`): nothing is wrong, and nothing more can be said.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except MemoryError:
        return _complain("not enough memory for this input at this size", 2)
    except OSError as error:
        return _complain(f"{error.filename or 'system'}: {error.strerror or error}", 2)


def _complain(message: object, status: int) -> int:
    sys.stderr.write(f"ncontours: {' '.join(str(message).split())}\n")
    return status


if __name__ == "__main__":
    sys.exit(main())
