"""The errors that this project raises on purpose.

NeuralContoursError          anything a user can mend; its text is one line
├── UsageError               what was asked for makes no sense
│   └── ArgumentError        one parameter has a value that makes no sense
├── InputError               a file is missing, unreadable, or not what was expected
│   └── MeshError            a mesh can't be read, is empty, or can't be repaired
└── BatchError               some items of a batch failed; all others were written

The library raises them; only the command line formats them. The first three end a command with exit status 2,
`BatchError` with 1.
"""

from pathlib import Path


class NeuralContoursError(Exception):
    """Base of every error raised on purpose; `str(error)` is one line that a user can act on."""


class UsageError(NeuralContoursError):
    """What was asked for makes no sense."""


class ArgumentError(UsageError):
    """One parameter has a value that makes no sense.

    The library names the parameter as its caller knows it; the command line names the option of that name.

    Args:
        parameter: The parameter's name in Python.
        found: What it was, or what is wrong with it.
        expected: What was expected instead.
    """

    def __init__(self, parameter: str, found: str, expected: str) -> None:
        super().__init__(f"{parameter}: found {found}, expected {expected}")
        self.parameter, self.found, self.expected = parameter, found, expected

    def __reduce__(self) -> tuple[type["ArgumentError"], tuple[str, str, str]]:
        return type(self), (self.parameter, self.found, self.expected)

    @property
    def as_option(self) -> str:
        """The same, of the command line's option."""
        return f"--{self.parameter.replace('_', '-')}: found {self.found}, expected {self.expected}"


def printable(name: object) -> str:
    """A file's name on one line that any terminal, font and encoding can show: what can't be seen is written out."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in str(name))


class InputError(NeuralContoursError):
    """A file is missing, unreadable, or not what was expected.

    Args:
        path: The file, as the user named it.
        found: What was found in it.
        expected: What was expected instead.
    """

    def __init__(self, path: str | Path, found: str, expected: str) -> None:
        super().__init__(f"{printable(path)}: {' '.join(found.split())}; expected {' '.join(expected.split())}")
        self.path, self.found, self.expected = str(path), found, expected

    def __reduce__(self) -> tuple[type["InputError"], tuple[str, str, str]]:
        # Errors cross from worker processes; an exception is otherwise made again from its one message.
        return type(self), (self.path, self.found, self.expected)


class MeshError(InputError):
    """A mesh can't be read, is empty, or can't be repaired."""


class BatchError(NeuralContoursError):
    """Some items of a batch failed; all others were written."""
