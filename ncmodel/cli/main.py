"""The `ncontours` command: one Typer application, a thin file a group, errors as one line and an exit status."""

import os
import sys
from collections.abc import Sequence

import typer
from typer.exceptions import TyperException

from ncmodel.cli import bench, crowd, dataset, demo, draw, evaluate, features, train
from ncmodel.errors import BatchError, NeuralContoursError

app = typer.Typer(
    help="Learned line drawings of 3D shapes.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
draw.register(app)
features.register(app)
dataset.register(app)
evaluate.register(app)
crowd.register(app)
train.register(app)
demo.register(app)
bench.register(app)


@app.callback()
def _root() -> None:
    """Learned line drawings of 3D shapes."""
    # Without a callback, an application with one command would take its name for an argument.


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
