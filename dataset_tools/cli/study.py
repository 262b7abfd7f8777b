"""`ncontours crowd study`: pairs of methods' drawings before people's eyes."""

from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dataset_tools.cli import options
from dataset_tools.cli.messages import emit_ingested, emit_simulated, emit_study_batch
from ncmodel.cli.common import emit
from ncmodel.errors import ArgumentError, InputError

if TYPE_CHECKING:
    from dataset_tools.study.analysis import StudyResult
    from dataset_tools.study.design import StudyKey

Answers = Annotated[Path, typer.Argument(help="Answers that `ncontours crowd study ingest` wrote.")]


def build(
    batch_dir: options.BatchDir,
    ours: Annotated[str, typer.Option(help="Our method and its drawings CASE.png: NAME=DIR.")],
    against: Annotated[
        list[str], typer.Option(help="A rival and its drawings of the same cases: NAME=DIR; repeatable.")
    ],
    renders: Annotated[Path, typer.Option(help="Renders of the shapes, CASE/*.png.")],
    pairs: Annotated[int, typer.Option(help="Comparisons in a questionnaire, each asked about twice.")] = 15,
    answers: Annotated[int, typer.Option(help="Consistent answers that each comparison should get.")] = 3,
    most_inconsistent: Annotated[int, typer.Option(help="With more inconsistent answers one is unreliable.")] = 7,
    base_url: options.BaseUrl = "images/",
    embed: options.Embed = False,
    drawing_side: options.DrawingSide = 768,
    render_side: options.RenderSide = 384,
    seed: options.Seed = 0,
    as_json: options.AsJson = False,
) -> None:
    """Make questionnaires that show our drawings beside other methods'."""
    from dataset_tools.questionnaires.batch_folder import Look
    from dataset_tools.study.design import StudyScheme, build_study
    from dataset_tools.study.stimuli import StudyFolders

    name, folder = _named(ours, "ours")
    folders = StudyFolders(folder, dict(_named(text, "against") for text in against), renders)
    scheme = StudyScheme(pairs, answers, most_inconsistent, seed)
    key, notes = build_study(folders, name, scheme, Look(drawing_side, render_side, base_url, embed), batch_dir)
    emit_study_batch(key, notes, len(key.comparisons), batch_dir, as_json)


def ingest(
    batch_dir: options.BatchDir,
    results: Annotated[list[Path], typer.Argument(help="Results files, as `ncontours crowd ingest` reads them.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Answer file to write or add to.")],
    as_json: options.AsJson = False,
) -> None:
    """Read results of a study into a file of answers; what it holds already isn't read twice."""
    from dataset_tools.study.analysis import ingest_study
    from dataset_tools.study.design import StudyKey
    from dataset_tools.votes.ingest import read_results

    emit_ingested(ingest_study(read_results(results), StudyKey.load(batch_dir), output), output, as_json)


def simulate(
    batch_dir: options.BatchDir,
    output: options.ResultsOut,
    participants: options.Participants = None,
    random_clickers: options.RandomClickers = 0.15,
    noise: options.Noise = 0.15,
    seed: options.Seed = 0,
    as_json: options.AsJson = False,
) -> None:
    """Let simulated participants with made-up preferences answer a study; their results say that they are simulated."""
    from dataset_tools.simulation.study_participants import StudyCrowd, simulate_study

    done = simulate_study(batch_dir, output, StudyCrowd(noise, random_clickers), participants, seed)
    emit_simulated(done, output, as_json)


def report(
    batch_dir: options.BatchDir,
    answers: Answers,
    output: options.HtmlOut,
    as_json: options.AsJson = False,
) -> None:
    """Count the consistent answers: which drawings people prefer, with confidence intervals."""
    from dataset_tools.study.design import StudyKey
    from dataset_tools.study.report import summary, write_study_report

    key = StudyKey.load(batch_dir)
    found = _evaluate(key, answers)
    write_study_report(found, key.ours, output)
    text = (
        f"{len(found.inconsistent)} participants, {len(found.unreliable)} unreliable; {len(found.short)} of "
        f"{len(found.comparisons)} comparisons short of {key.scheme.answers} consistent answers; see {output}"
    )
    emit({**summary(found, key.ours), "scheme": asdict(key.scheme)}, as_json, text)


def topup(
    batch_dir: options.BatchDir,
    answers: Answers,
    more_dir: Annotated[Path, typer.Argument(help="Folder to write the further questionnaires to.")],
    base_url: options.BaseUrl = "images/",
    embed: options.Embed = False,
    drawing_side: options.DrawingSide = 768,
    render_side: options.RenderSide = 384,
    seed: options.Seed = 0,
    as_json: options.AsJson = False,
) -> None:
    """Make questionnaires about the comparisons that are short of consistent answers; others fill them up."""
    from dataset_tools.questionnaires.batch_folder import Look
    from dataset_tools.study.design import StudyKey, build_study

    key = StudyKey.load(batch_dir)
    if key.folders is None:
        raise InputError(batch_dir / "key.json", "no folders of drawings", "a key that this version wrote")
    found = _evaluate(key, answers)
    if not found.short:
        emit({"questionnaires": 0, "comparisons": 0, "short": 0}, as_json, "no comparison is short of answers")
        return
    look, scheme = Look(drawing_side, render_side, base_url, embed), replace(key.scheme, seed=seed)
    more, notes = build_study(key.folders.under(batch_dir), key.ours, scheme, look, more_dir, found.short)
    emit_study_batch(more, notes, len(found.short), more_dir, as_json)


def _named(text: str, parameter: str) -> tuple[str, Path]:
    """A method's name and the folder of its drawings."""
    name, separator, folder = text.partition("=")
    if not (name and separator and folder):
        raise ArgumentError(parameter, repr(text), "NAME=DIR")
    return name, Path(folder)


def _evaluate(key: "StudyKey", answers: Path) -> "StudyResult":
    """The study's result so far, by its own rules."""
    from dataset_tools.study.analysis import evaluate_study, read_answers

    return evaluate_study(read_answers(answers), key.scheme.answers, key.scheme.most_inconsistent, key.comparisons)


group = typer.Typer(help="The perceptual study: pairs of methods' drawings.", no_args_is_help=True)
for command in (build, simulate, ingest, report, topup):
    group.command()(command)
