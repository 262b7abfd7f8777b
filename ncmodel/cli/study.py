"""`ncontours crowd study`: pairs of methods' drawings before people's eyes."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from ncmodel.cli.common import emit
from ncmodel.cli.ingested import emit_ingested
from ncmodel.errors import UsageError

AsJson = Annotated[bool, typer.Option("--json", help="Print a summary as one JSON object.")]
BatchDir = Annotated[Path, typer.Argument(help="Folder of the study's questionnaires.")]


def register(group: typer.Typer) -> None:
    """Add the commands to the group of crowd commands."""
    study = typer.Typer(help="The perceptual study: pairs of methods' drawings.", no_args_is_help=True)
    for command in (build, ingest, report):
        study.command(command.__name__)(command)
    group.add_typer(study, name="study")


def build(
    batch_dir: BatchDir,
    ours: Annotated[str, typer.Option(help="Our method and its drawings CASE.png: NAME=DIR.")],
    against: Annotated[
        list[str], typer.Option(help="A rival and its drawings of the same cases: NAME=DIR; repeatable.")
    ],
    renders: Annotated[Path, typer.Option(help="Renders of the shapes, CASE/*.png.")],
    pairs: Annotated[int, typer.Option(help="Comparisons in a questionnaire, each asked about twice.")] = 15,
    answers: Annotated[int, typer.Option(help="Consistent answers that each comparison should get.")] = 3,
    most_inconsistent: Annotated[int, typer.Option(help="With more inconsistent answers one is unreliable.")] = 7,
    base_url: Annotated[str, typer.Option(help="What stands before the pictures' names in tasks.csv.")] = "images/",
    embed: Annotated[bool, typer.Option(help="Put the pictures into tasks.csv, as data URIs.")] = False,
    drawing_side: Annotated[int, typer.Option(help="Longest side of a drawing, pixels.")] = 768,
    render_side: Annotated[int, typer.Option(help="Longest side of a render, pixels.")] = 384,
    seed: Annotated[int, typer.Option(help="Of everything random.")] = 0,
    as_json: AsJson = False,
) -> None:
    """Make questionnaires that show our drawings beside other methods'."""
    from dataset_tools.batch_files import Look
    from dataset_tools.study import StudyFolders, StudyScheme, build_study

    name, folder = _named(ours, "--ours")
    folders = StudyFolders(folder, dict(_named(text, "--against") for text in against), renders)
    scheme = StudyScheme(pairs, answers, most_inconsistent, seed)
    key = build_study(folders, name, scheme, Look(drawing_side, render_side, base_url, embed), batch_dir)
    comparisons = {question.comparison for questions in key.questionnaires.values() for question in questions}
    record = {"questionnaires": len(key.questionnaires), "comparisons": len(comparisons)}
    emit(record, as_json, f"{len(key.questionnaires)} questionnaires, {len(comparisons)} comparisons, in {batch_dir}")


def _named(text: str, option: str) -> tuple[str, Path]:
    name, separator, folder = text.partition("=")
    if not (name and separator and folder):
        raise UsageError(f"{option}: found {text!r}, expected NAME=DIR")
    return name, Path(folder)


def ingest(
    batch_dir: BatchDir,
    results: Annotated[list[Path], typer.Argument(help="Results files, as `ncontours crowd ingest` reads them.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Answer file to write or add to.")],
    as_json: AsJson = False,
) -> None:
    """Read results of a study into a file of answers; what it holds already isn't read twice."""
    from dataset_tools.collect import read_results
    from dataset_tools.study import StudyKey
    from dataset_tools.study_answers import ingest_study

    emit_ingested(ingest_study(read_results(results), StudyKey.load(batch_dir), output), output, as_json)


def report(
    batch_dir: BatchDir,
    answers: Annotated[Path, typer.Argument(help="Answers that `ncontours crowd study ingest` wrote.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="HTML file to write.")],
    as_json: AsJson = False,
) -> None:
    """Count the consistent answers: which drawings people prefer, with confidence intervals."""
    from dataset_tools.study import StudyKey
    from dataset_tools.study_answers import evaluate_study, read_answers
    from dataset_tools.study_report import summary, write_study_report

    key = StudyKey.load(batch_dir)
    found = evaluate_study(read_answers(answers), key.scheme.answers, key.scheme.most_inconsistent)
    write_study_report(found, key.ours, output)
    figures = summary(found, key.ours)
    people, out = len(found.inconsistent), len(found.unreliable)
    emit({**figures, "scheme": asdict(key.scheme)}, as_json, f"{people} participants, {out} unreliable; see {output}")
