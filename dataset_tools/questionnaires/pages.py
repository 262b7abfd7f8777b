"""The pages that participants see, from the templates in `mturk_templates`."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from dataset_tools.questionnaires.questionnaire import NONE, field_name
from ncmodel.data.item import DRAWINGS

Size = tuple[int, int]

_VERBATIM = re.compile(r"""("[^"]*"|'[^']*'|/\*.*?\*/)""")
_SIGN = re.compile(r" ?([=(){}\[\],;:?!&|<>*+-]+) ?")


@dataclass(frozen=True)
class ShownDrawing:
    """A drawing that can be chosen."""

    value: str
    image: str


@dataclass(frozen=True)
class ShownAnswer:
    """An answer in words, chosen with a key."""

    value: str
    label: str
    key: int


@dataclass(frozen=True)
class ShownQuestion:
    """A question as a page shows it: addresses of pictures and values of answers."""

    field: str
    renders: Sequence[str]
    drawings: Sequence[ShownDrawing]
    others: Sequence[ShownAnswer]


@dataclass(frozen=True)
class Wording:
    """What a page says.

    Attributes:
        title: Heading.
        lead: First paragraph of the instructions.
        rules: Points to heed.
        example: Captions with the paths of small drawings, the good one first.
        question: What every question asks.
        keys: Which keys choose.
        closing: Last paragraph of the instructions.
        thanks: Shown before sending.
    """

    title: str
    lead: str
    rules: Sequence[str]
    example: Sequence[tuple[str, Sequence[str]]]
    question: str
    keys: str
    closing: str
    thanks: str


_MUG = ("M18 16v40c0 8 36 8 36 0V16", "M18 16a18 6 0 0 1 36 0a18 6 0 0 1-36 0")
_HANDLE = ("M54 22c20-5 20 33 0 28", "M54 28c11-3 11 20 0 16")
_CLUTTER = tuple(f"M{x} {22 + x % 5}v{30 + x % 4}" for x in range(21, 53, 3)) + (
    "M18 30c8 6 28 6 36 0",
    "M18 44c8 6 28 6 36 0",
)

BEST_DRAWING = Wording(
    title="Which line drawing shows the shape best?",
    lead="Each question shows a 3D shape from several sides, and eight line drawings of it.",
    rules=(
        "Choose the drawing that best conveys the shape, and that others would most likely choose too.",
        "A good drawing has the lines that matter: not too few, not too many, and none in the wrong place.",
        "If no drawing shows the shape well, choose “none of these line drawings are good”.",
        "Look at the shape and at every drawing before you choose. Some questions check that you did.",
    ),
    example=(
        ("Good", (*_MUG, *_HANDLE)),
        ("Too few lines", (_MUG[0], _MUG[1])),
        ("Too many lines", (*_MUG, *_HANDLE, *_CLUTTER)),
    ),
    question="Which drawing best conveys the shape, and would others most likely choose too?",
    keys="1 to 8 choose a drawing, 0 chooses none",
    closing="We record your answers, how long each takes and your participant number, nothing else about you. "
    "You can go back and change answers, and you may close the page and return to it on the same device.",
    thanks="You can still go back and change answers. Otherwise please send them now.",
)

BETTER_OF_TWO = Wording(
    title="Which of two line drawings shows the shape better?",
    lead="Each question shows a 3D shape from three sides, and two line drawings of it.",
    rules=(
        "Choose the drawing that best conveys the shape.",
        "If both convey it equally well, say so; if neither conveys it well, say so too.",
        "Look at the shape and at both drawings before you choose. Some pairs come twice to check that you did.",
    ),
    example=BEST_DRAWING.example,
    question="Which drawing best conveys the shape?",
    keys="1 chooses the left drawing, 2 the right one, 3 both, 0 none",
    closing=BEST_DRAWING.closing,
    thanks=BEST_DRAWING.thanks,
)


def pair_template(length: int, renders: int, drawing_size: Size, render_size: Size) -> str:
    """The template of a batch of pair questionnaires; arguments as those of `batch_template`."""
    others = [
        ShownAnswer("both", "Both convey the shape equally well", 3),
        ShownAnswer(NONE, "Neither conveys it well", 0),
    ]
    questions = _placeholders(length, renders, 2, others)
    return fragment("${questionnaire}", questions, BETTER_OF_TWO, drawing_size, render_size)


def batch_template(length: int, renders: int, drawing_size: Size, render_size: Size) -> str:
    """The template of a batch of 8-drawing questionnaires: an HTML fragment with `${name}` placeholders.

    Args:
        length: Questions in a questionnaire.
        renders: Renders of the shape in a question.
        drawing_size: (width, height) of the drawings.
        render_size: (width, height) of the renders.
    """
    others = [ShownAnswer(NONE, "None of these line drawings are good", 0)]
    questions = _placeholders(length, renders, DRAWINGS, others)
    return fragment("${questionnaire}", questions, BEST_DRAWING, drawing_size, render_size)


def _placeholders(length: int, renders: int, drawings: int, others: Sequence[ShownAnswer]) -> list[ShownQuestion]:
    """Questions whose pictures and values are columns of the task list."""
    questions = []
    for number in range(1, length + 1):
        name = field_name(number, length)
        shown = [ShownDrawing(f"${{{name}_v{i}}}", f"${{{name}_d{i}}}") for i in range(1, drawings + 1)]
        questions.append(ShownQuestion(name, [f"${{{name}_r{i}}}" for i in range(1, renders + 1)], shown, others))
    return questions


def fragment(
    identifier: str,
    questions: Sequence[ShownQuestion],
    text: Wording,
    drawing_size: Size,
    render_size: Size,
) -> str:
    """A questionnaire as an HTML fragment, to stand in a form.

    Args:
        identifier: The questionnaire's opaque name.
        questions: In order.
        text: What it says.
        drawing_size: (width, height) of the drawings.
        render_size: (width, height) of the renders.
    """
    return render(
        "questionnaire.html.j2",
        identifier=identifier,
        questions=questions,
        text=text,
        drawing_shape=f"{drawing_size[0]}/{drawing_size[1]}",
        render_shape=f"{render_size[0]}/{render_size[1]}",
        style=_inline("questionnaire.css"),
        script=_inline("questionnaire.js"),
    )


def render(template: str, **values: Any) -> str:
    """A template filled in; a value that is missing raises."""
    return _environment().get_template(template).render(**values)


@cache
def asset(name: str) -> str:
    """The text of a style sheet or script that belongs to the templates."""
    return resources.files("mturk_templates").joinpath(name).read_text(encoding="utf-8")


def _inline(name: str) -> Markup:
    """A style sheet or script of ours to stand in a page, without indentation and lines that are comments.

    Scripts lose the spaces around their signs too: with these, the paper's questionnaire wouldn't fit into a template.
    """
    lines = (line.strip() for line in asset(name).splitlines())
    kept = [line for line in lines if line and not (line.startswith("/*") and line.endswith("*/"))]
    return Markup("\n".join(map(_tight, kept) if name.endswith(".js") else kept))


def _tight(line: str) -> str:
    """A line of a script without spaces around signs, except in strings and comments."""
    parts = _VERBATIM.split(line)
    return "".join(part if i % 2 else _SIGN.sub(r"\1", part) for i, part in enumerate(parts))


@cache
def _environment() -> Environment:
    return Environment(
        loader=PackageLoader("mturk_templates", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
