"""`ncontours crowd`: questionnaires out, votes in, ranking pairs from them."""

import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dataset_tools.cli import study
from dataset_tools.cli.crowd_options import (
    AsJson,
    BaseUrl,
    BatchDir,
    DrawingSide,
    Embed,
    HtmlOut,
    Noise,
    Participants,
    RandomClickers,
    RenderSide,
    ResultsOut,
    Seed,
)
from dataset_tools.cli.ingested import emit_ingested
from ncmodel.cli.common import emit, progress
from ncmodel.errors import InputError, UsageError

if TYPE_CHECKING:
    from dataset_tools.questionnaires.batch import Built
    from dataset_tools.site.server import Addresses

DataDir = Annotated[Path, typer.Argument(help="Folder that `ncontours dataset build` wrote.")]
VotesFile = Annotated[Path, typer.Argument(help="Votes that `ncontours crowd ingest` wrote.")]

Real = Annotated[int, typer.Option(help="Questions about items in each questionnaire.")]
Sentinels = Annotated[int, typer.Option(help="Sentinel questions in each questionnaire.")]
Pool = Annotated[int, typer.Option(help="Sentinels to draw from.")]
Votes = Annotated[int, typer.Option(help="Answers that each item gets.")]
Artists = Annotated[
    Path | None,
    typer.Option(
        help="Folder of artists' drawings for sentinels, SHAPE_VIEW.png or SHAPE_VIEW/*.png; simulated by default."
    ),
]


def build(
    data_dir: DataDir,
    batch_dir: BatchDir,
    real: Real = 30,
    sentinels: Sentinels = 5,
    pool: Pool = 15,
    votes: Votes = 3,
    artists: Artists = None,
    base_url: BaseUrl = "images/",
    embed: Embed = False,
    drawing_side: DrawingSide = 512,
    render_side: RenderSide = 384,
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Make questionnaires about all views of a data set: template.html, tasks.csv, images and key.json."""
    from dataset_tools.questionnaires.batch_folder import Look
    from dataset_tools.questionnaires.identical_drawings import items_to_ask_about
    from dataset_tools.questionnaires.questionnaire import Scheme
    from dataset_tools.simulation.crowd import make_batch
    from ncmodel.data.data_folder import DataFolder

    scheme, data = Scheme(real, sentinels, pool, votes, seed), DataFolder(data_dir)
    needs = dict.fromkeys(items_to_ask_about(data), votes)
    left_out = len(data.items()) - len(needs)
    if left_out:
        sys.stderr.write(f"note: not asked about {left_out} views whose eight drawings are one and the same\n")
    look = Look(drawing_side, render_side, base_url, embed)
    _emit_built(make_batch(data_dir, batch_dir, needs, scheme, look, artists), batch_dir, as_json)


def _emit_built(built: "Built", batch_dir: Path, as_json: bool) -> None:
    for note in built.notes:
        sys.stderr.write(f"note: {note}\n")
    text = (
        f"{built.questionnaires} questionnaires of {built.real} items and {built.sentinels} sentinels, "
        f"{built.items} items, in {batch_dir}"
    )
    emit(asdict(built), as_json, text)


def serve(
    batch_dir: BatchDir,
    db: Annotated[Path, typer.Option(help="Database of answers; made if there is none.")],
    port: Annotated[int, typer.Option(help="Port to listen on; 0 takes a free one.", min=0, max=65535)] = 8000,
    host: Annotated[str, typer.Option(help="Address to listen on.")] = "127.0.0.1",
    public_url: Annotated[
        str, typer.Option(help="The address that participants use, where a proxy stands before.")
    ] = "",
    parameters: Annotated[
        str, typer.Option(help="Recruiting parameters in the link; the first says who the participant is.")
    ] = "PROLIFIC_PID,STUDY_ID,SESSION_ID",
    open_to_all: Annotated[bool, typer.Option(help="Let people without that parameter take part.")] = False,
    completion_code: Annotated[str, typer.Option(help="Code to show at the end.")] = "",
    completion_url: Annotated[
        str, typer.Option(help="Where the end page leads; {code} is the code.")
    ] = "https://app.prolific.com/submissions/complete?cc={code}",
    consent: Annotated[Path | None, typer.Option(help="Text file of the consent page, a paragraph a line.")] = None,
    contact: Annotated[str, typer.Option(help="Whom participants ask.")] = "",
    places: Annotated[int, typer.Option(help="Participants wanted for each questionnaire.", min=1)] = 1,
    abandoned_after: Annotated[
        float, typer.Option(help="Minutes after which an idle questionnaire is given away.")
    ] = 60.0,
    replace_unreliable: Annotated[
        bool, typer.Option(help="Offer unreliable participants' questionnaires again.")
    ] = False,
    taken_part: Annotated[
        list[Path] | None,
        typer.Option(
            help="Votes, answers or database of an earlier round, whose participants can't again; repeatable."
        ),
    ] = None,
    token_file: Annotated[
        Path | None, typer.Option(help="File with the requester's token; DB.token by default.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print where it listens as one JSON object.")] = False,
) -> None:
    """Serve a batch as a web site of its own, for participants of Prolific or anybody with the link."""
    from dataset_tools.site.database import Policy
    from dataset_tools.site.participant_pages import CONSENT, Settings
    from dataset_tools.site.server import SiteFiles, read_consent, site_parameters
    from dataset_tools.site.server import serve as serve_site
    from dataset_tools.votes.ingest import workers_of

    if abandoned_after <= 0:
        raise UsageError(f"--abandoned-after is {abandoned_after}, expected minutes > 0")
    settings = Settings(
        parameters=site_parameters(parameters),
        open_to_all=open_to_all,
        completion_code=completion_code,
        completion_url=completion_url,
        consent=read_consent(consent) if consent else CONSENT,
        contact=contact,
        public_url=public_url.rstrip("/"),
    )
    files = SiteFiles(batch_dir, db, token_file or db.with_name(db.name + ".token"))
    policy = Policy(places, 60 * abandoned_after, replace_unreliable, workers_of(taken_part or ()))

    def announce(found: "Addresses") -> None:
        if as_json:
            emit(found.record(), as_json)
            sys.stdout.flush()
        else:
            sys.stderr.write(found.text() + "\n")

    serve_site(files, settings, policy, host, port, announce)


def simulate(
    batch_dir: BatchDir,
    output: ResultsOut,
    data: Annotated[Path | None, typer.Option(help="The data folder; the batch knows it by default.")] = None,
    participants: Participants = None,
    random_clickers: RandomClickers = 0.15,
    noise: Noise = 0.55,
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Let simulated participants answer a batch; their results say that they are simulated."""
    from dataset_tools.questionnaires.questionnaire import Key
    from dataset_tools.simulation.crowd import simulate_batch
    from dataset_tools.simulation.participants import Crowd

    with progress("items seen by simulated artists", len(Key.load(batch_dir).items)) as advance:
        done = simulate_batch(
            batch_dir, output, Crowd(noise=noise, random_clickers=random_clickers), data, participants, seed, advance
        )
    emit(done, as_json, f"{done['simulated_participants']} simulated participants in {output}")


def ingest(
    batch_dir: BatchDir,
    results: Annotated[
        list[Path], typer.Argument(help="Results files: CSV of Mechanical Turk or Turkle, or a site's database.")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="Vote file to write or add to.")],
    as_json: AsJson = False,
) -> None:
    """Read results into a vote file; what it holds already isn't read twice."""
    from dataset_tools.votes.ingest import ingest_results

    done = ingest_results(batch_dir, results, output)
    emit_ingested(done, output, as_json)


def aggregate(
    votes: VotesFile,
    output: Annotated[Path, typer.Option("--output", "-o", help="Ranking pairs to write.")],
    method: Annotated[str, typer.Option(help="majority (the paper's rule) or one-coin (Dawid-Skene).")] = "majority",
    least: Annotated[int, typer.Option(help="Votes that must agree (and be more than half).")] = 2,
    posterior: Annotated[float, typer.Option(help="With one-coin: how sure the model must be.")] = 0.9,
    unreliable_too: Annotated[bool, typer.Option(help="Keep votes of participants who failed a sentinel.")] = False,
    strict: Annotated[bool, typer.Option(help="Exclude participants who show signs of not looking, too.")] = False,
    held_out: Annotated[float, typer.Option(help="Share of shapes held out for validation.")] = 0.1,
    validation_shapes: Annotated[str, typer.Option(help="Comma-separated shapes to hold out instead.")] = "",
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Turn votes into ranking pairs: reliable participants, consensus, shapes held out."""
    from dataset_tools.votes.consensus import Rules
    from dataset_tools.votes.consensus import aggregate as find_consensus
    from dataset_tools.votes.votes import read_votes
    from ncmodel.data.pairs import write_pairs

    if method not in ("majority", "one-coin"):
        raise UsageError(f"--method is {method!r}, expected majority or one-coin")
    shapes = tuple(name.strip() for name in validation_shapes.split(",") if name.strip())
    rules = Rules(
        "majority" if method == "majority" else "one-coin",
        least,
        posterior,
        unreliable_too,
        strict,
        held_out,
        shapes,
        seed,
    )
    found = find_consensus(read_votes(votes), rules)
    if not found.verdicts:
        raise InputError(votes, "no vote on any item", "votes that `ncontours crowd ingest` wrote")
    write_pairs(output, found.pairs())
    summary = found.summary()
    text = "{reliable} of {participants} participants reliable, {accepted} of {items} items accepted, {pairs} pairs"
    emit(summary, as_json, text.format(**summary) + f" in {output}")


def topup(
    data_dir: DataDir,
    votes: VotesFile,
    batch_dir: BatchDir,
    real: Real = 30,
    sentinels: Sentinels = 5,
    pool: Pool = 15,
    wanted: Annotated[int, typer.Option("--votes", help="Votes of reliable participants that each item gets.")] = 3,
    artists: Artists = None,
    base_url: BaseUrl = "images/",
    embed: Embed = False,
    drawing_side: DrawingSide = 512,
    render_side: RenderSide = 384,
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Make questionnaires about exactly the items that are still short of votes."""
    from dataset_tools.questionnaires.batch_folder import Look
    from dataset_tools.questionnaires.questionnaire import Scheme
    from dataset_tools.simulation.crowd import make_batch
    from dataset_tools.votes.ingest import top_up_needs

    scheme = Scheme(real, sentinels, pool, wanted, seed)
    needs = top_up_needs(data_dir, votes, wanted)
    if not needs:
        emit({"questionnaires": 0, "items": 0}, as_json, "no item is short of votes")
        return
    look = Look(drawing_side, render_side, base_url, embed)
    _emit_built(make_batch(data_dir, batch_dir, needs, scheme, look, artists, fill=False), batch_dir, as_json)


def audit(
    votes: VotesFile,
    output: HtmlOut,
    data: Annotated[Path | None, typer.Option(help="The data folder, to show the drawings of contested items.")] = None,
    as_json: AsJson = False,
) -> None:
    """Look into the votes of a study: agreement, consensus, biases, times, participants, contested items."""
    from dataset_tools.votes.audit import audit as look_into
    from dataset_tools.votes.audit import write_audit
    from dataset_tools.votes.consensus import Rules
    from dataset_tools.votes.votes import read_votes

    found = look_into(read_votes(votes), Rules())
    write_audit(found, output, data)
    summary = found.summary()
    alpha = "not defined" if found.alpha is None else f"{found.alpha:.2f}"
    text = "{accepted} of {items} items accepted, {participants} participants".format(**summary)
    emit(summary, as_json, f"{text}, alpha {alpha}; see {output}")


def review(
    votes: VotesFile,
    results: Annotated[Path, typer.Argument(help="Results CSV of Mechanical Turk.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="CSV to write.")],
    as_json: AsJson = False,
) -> None:
    """Fill in the Approve and Reject columns of a results CSV, by who passed the sentinels."""
    from dataset_tools.votes.approvals import write_review
    from dataset_tools.votes.reliability import assess
    from dataset_tools.votes.votes import read_votes

    counts = write_review(results, assess(read_votes(votes)), output)
    emit(counts, as_json, "{approved} approved, {rejected} rejected, {unknown} unknown".format(**counts))


def trial(
    data_dir: DataDir,
    output: HtmlOut,
    participants: Annotated[int, typer.Option(help="Simulated participants.")] = 400,
    random_clickers: RandomClickers = 0.15,
    adversaries: Annotated[int, typer.Option(help="Simulated adversaries of each of ten kinds.")] = 6,
    noise: Noise = 0.55,
    items: Annotated[int, typer.Option(help="Views of the data folder to draw distances from.", min=1)] = 24,
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Try the rules on a simulated crowd with adversaries: whom and what they keep, and what they exclude wrongly."""
    from dataset_tools.simulation.crowd import sample_distances
    from dataset_tools.simulation.participants import Crowd
    from dataset_tools.simulation.rule_trial import run_trial
    from dataset_tools.simulation.rule_trial_report import as_text, write_trial

    with progress("items seen by simulated artists", items) as advance:
        known = sample_distances(data_dir, items, seed, advance)
    crowd = Crowd(noise=noise, random_clickers=random_clickers)
    found = run_trial(known, crowd, participants, adversaries, seed)
    write_trial(found, output)
    emit(asdict(found), as_json, f"{as_text(found)}\n{output}")


group = typer.Typer(help="Questionnaires for people, and ranking pairs from their votes.", no_args_is_help=True)
for command in (build, serve, simulate, ingest, aggregate, topup, audit, review, trial):
    group.command()(command)
group.add_typer(study.group, name="study")
