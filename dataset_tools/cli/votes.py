"""`ncontours crowd ingest`, `aggregate`, `audit` and `review`: votes in, ranking pairs from them."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from dataset_tools.cli import options
from dataset_tools.cli.messages import emit_ingested
from ncmodel.cli.common import emit
from ncmodel.errors import InputError

if TYPE_CHECKING:
    from dataset_tools.votes.consensus import Method


def ingest(
    batch_dir: options.BatchDir,
    results: Annotated[
        list[Path], typer.Argument(help="Results files: CSV of Mechanical Turk or Turkle, or a site's database.")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="Vote file to write or add to.")],
    as_json: options.AsJson = False,
) -> None:
    """Read results into a vote file; what it holds already isn't read twice."""
    from dataset_tools.votes.ingest import ingest_results

    emit_ingested(ingest_results(batch_dir, results, output), output, as_json)


def aggregate(
    votes: options.VotesFile,
    output: Annotated[Path, typer.Option("--output", "-o", help="Ranking pairs to write.")],
    method: Annotated[str, typer.Option(help="majority (the paper's rule) or one-coin (Dawid-Skene).")] = "majority",
    least: Annotated[int, typer.Option(help="Votes that must agree (and be more than half).")] = 2,
    posterior: Annotated[float, typer.Option(help="With one-coin: how sure the model must be.")] = 0.9,
    unreliable_too: Annotated[bool, typer.Option(help="Keep votes of participants who failed a sentinel.")] = False,
    strict: Annotated[bool, typer.Option(help="Exclude participants who show signs of not looking, too.")] = False,
    held_out: Annotated[float, typer.Option(help="Share of shapes held out for validation.")] = 0.1,
    validation_shapes: Annotated[str, typer.Option(help="Comma-separated shapes to hold out instead.")] = "",
    seed: options.Seed = 0,
    as_json: options.AsJson = False,
) -> None:
    """Turn votes into ranking pairs: reliable participants, consensus, shapes held out."""
    from dataset_tools.votes.consensus import Rules
    from dataset_tools.votes.consensus import aggregate as find_consensus
    from dataset_tools.votes.votes import read_votes
    from ncmodel.data.pairs import write_pairs

    shapes = tuple(name.strip() for name in validation_shapes.split(",") if name.strip())
    rules = Rules(cast("Method", method), least, posterior, unreliable_too, strict, held_out, shapes, seed)
    found = find_consensus(read_votes(votes), rules)
    if not found.verdicts:
        raise InputError(votes, "no vote on any item", "votes that `ncontours crowd ingest` wrote")
    write_pairs(output, found.pairs())
    summary = found.summary()
    text = "{reliable} of {participants} participants reliable, {accepted} of {items} items accepted, {pairs} pairs"
    emit(summary, as_json, text.format(**summary) + f" in {output}")


def audit(
    votes: options.VotesFile,
    output: options.HtmlOut,
    data: Annotated[Path | None, typer.Option(help="The data folder, to show the drawings of contested items.")] = None,
    as_json: options.AsJson = False,
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
    votes: options.VotesFile,
    results: Annotated[Path, typer.Argument(help="Results CSV of Mechanical Turk.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="CSV to write.")],
    as_json: options.AsJson = False,
) -> None:
    """Fill in the Approve and Reject columns of a results CSV, by who passed the sentinels."""
    from dataset_tools.votes.approvals import write_review
    from dataset_tools.votes.reliability import assess
    from dataset_tools.votes.votes import read_votes

    counts = write_review(results, assess(read_votes(votes)), output)
    emit(counts, as_json, "{approved} approved, {rejected} rejected, {unknown} unknown".format(**counts))
