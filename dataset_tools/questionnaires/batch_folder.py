"""The files of a batch: template, task list, pictures under opaque names, key. What is asked is decided elsewhere."""

import base64
import csv
import json
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from dataset_tools.questionnaires.questionnaire import IMAGES_NAME, KEY_NAME, TASKS_NAME, TEMPLATE_NAME, Tokens
from dataset_tools.questionnaires.stimuli import DRAWING_LEVELS, image_pool
from ncmodel.errors import ArgumentError, UsageError
from ncmodel.files import write_text
from ncmodel.images import read_grey

Size = tuple[int, int]
Template = Callable[[int, int, Size, Size], str]
"""Makes the template from: questions, renders in each, (width, height) of drawings, (width, height) of renders."""


MAX_TEMPLATE = 64 * 1024
"""Bytes of the longest template that Turkle takes."""


@dataclass(frozen=True)
class Look:
    """How a batch's pictures reach participants.

    Attributes:
        drawing_side: Longest side of a drawing, pixels.
        render_side: Longest side of a render, pixels.
        base_url: What stands before the pictures' names in `tasks.csv`.
        embed: Put the pictures into `tasks.csv` themselves, as data URIs.
    """

    drawing_side: int = 512
    render_side: int = 384
    base_url: str = f"{IMAGES_NAME}/"
    embed: bool = False

    def __post_init__(self) -> None:
        for name in ("drawing_side", "render_side"):
            if not 16 <= getattr(self, name) <= 4096:
                raise ArgumentError(name, str(getattr(self, name)), "16..4096 pixels")


@dataclass(frozen=True)
class QuestionStimuli:
    """A question as shown.

    Attributes:
        field: Name of its form field.
        values: Answer values of the drawings, in order.
        drawings: Their pictures.
        renders: Pictures of the shape.
    """

    field: str
    values: tuple[str, ...]
    drawings: tuple[Path, ...]
    renders: tuple[Path, ...]


@dataclass(frozen=True)
class QuestionnaireStimuli:
    """A questionnaire as shown."""

    identifier: str
    questions: tuple[QuestionStimuli, ...]


@dataclass(frozen=True)
class BatchWriter:
    """Writes batch folders.

    Attributes:
        tokens: Names the pictures.
        look: How they are delivered.
        template: Makes the template.
    """

    tokens: Tokens
    look: Look
    template: Template

    def write(self, batch_dir: Path, stimuli: Sequence[QuestionnaireStimuli], key: Mapping[str, object]) -> list[str]:
        """Write a batch folder; it appears whole or not at all.

        Args:
            batch_dir: A folder that doesn't exist yet or is empty.
            stimuli: The questionnaires, all of one length, with as many renders in each question.
            key: What `key.json` holds.

        Returns:
            What the requester should know.

        Raises:
            UsageError: The folder holds something.
            InputError: A picture can't be read.
        """
        if batch_dir.exists() and any(batch_dir.iterdir()):
            raise UsageError(f"{batch_dir}: holds files already; a batch goes into a folder of its own")
        with _appearing(batch_dir) as folder:
            first = stimuli[0].questions[0]
            drawing_size = _frame(first.drawings[0], self.look.drawing_side)
            render_size = _frame(first.renders[0], self.look.render_side)
            self._write_pictures(folder / IMAGES_NAME, stimuli, drawing_size, render_size)
            self._write_tasks(folder, stimuli)
            text = self.template(len(stimuli[0].questions), len(first.renders), drawing_size, render_size)
            write_text(folder / TEMPLATE_NAME, text)
            write_text(folder / KEY_NAME, json.dumps(key, indent=1) + "\n")
            (folder / KEY_NAME).chmod(0o600)  # what answers mean is for the requester alone
        return self._notes(batch_dir, len(text.encode()))

    def _notes(self, batch_dir: Path, template_bytes: int) -> list[str]:
        notes = []
        if template_bytes > MAX_TEMPLATE:
            notes.append(
                f"{TEMPLATE_NAME} has {template_bytes} bytes, and Turkle takes {MAX_TEMPLATE}: ask fewer questions, or "
                "use a site of your own"
            )
        if "://" in self.look.base_url and not self.look.embed:
            notes.append(
                f"put the pictures of {batch_dir / IMAGES_NAME} at {self.look.base_url}, and nothing else: "
                f"{KEY_NAME} tells all answers"
            )
        return notes

    def _name(self, questionnaire: QuestionnaireStimuli, shown: QuestionStimuli, kind: str, place: int) -> str:
        """What a picture is called where it is shown: every showing has a name of its own."""
        return self.tokens(kind, questionnaire.identifier, shown.field, place) + ".png"

    def _write_pictures(
        self, folder: Path, stimuli: Sequence[QuestionnaireStimuli], drawing_size: Size, render_size: Size
    ) -> None:
        folder.mkdir()
        with image_pool(folder) as pool:
            for questionnaire in stimuli:
                for shown in questionnaire.questions:
                    for place, path in enumerate(shown.drawings, 1):
                        pool.add(self._name(questionnaire, shown, "drawing", place), path, drawing_size, DRAWING_LEVELS)
                    for place, path in enumerate(shown.renders, 1):
                        pool.add(self._name(questionnaire, shown, "render", place), path, render_size)

    def _write_tasks(self, folder: Path, stimuli: Sequence[QuestionnaireStimuli]) -> None:
        with (folder / TASKS_NAME).open("w", encoding="utf-8", newline="") as file:
            writer: csv.DictWriter[str] | None = None
            for questionnaire in stimuli:
                row = self._task(questionnaire, folder / IMAGES_NAME)
                if writer is None:
                    writer = csv.DictWriter(file, list(row), lineterminator="\n")
                    writer.writeheader()
                writer.writerow(row)

    def _task(self, questionnaire: QuestionnaireStimuli, images: Path) -> dict[str, str]:
        """A row of `tasks.csv`: the identifier, where each picture is, then the value of each answer."""
        row = {"questionnaire": questionnaire.identifier}
        for shown in questionnaire.questions:
            for kind, letter, count in (("drawing", "d", len(shown.drawings)), ("render", "r", len(shown.renders))):
                for place in range(1, count + 1):
                    name = self._name(questionnaire, shown, kind, place)
                    row[f"{shown.field}_{letter}{place}"] = self._address(images / name)
        for shown in questionnaire.questions:
            row |= {f"{shown.field}_v{place}": value for place, value in enumerate(shown.values, 1)}
        return row

    def _address(self, picture: Path) -> str:
        if self.look.embed:
            return "data:image/png;base64," + base64.b64encode(picture.read_bytes()).decode("ascii")
        base = self.look.base_url
        return (base if base.endswith("/") or not base else f"{base}/") + picture.name


@contextmanager
def _appearing(folder: Path) -> Iterator[Path]:
    """A folder aside that becomes `folder` when the block ends well, and vanishes when it doesn't."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    aside = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    try:
        yield aside
        aside.chmod(0o755)
        os.replace(aside, folder)
    except BaseException:
        shutil.rmtree(aside, ignore_errors=True)
        raise


def _frame(path: Path, longest: int) -> Size:
    """(width, height) that a picture is shown at so that its longest side is `longest`."""
    height, width = read_grey(path).shape
    scale = longest / max(height, width)
    return max(1, round(width * scale)), max(1, round(height * scale))
