"""`ncontours crowd build` and `topup`: questionnaires out."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dataset_tools.cli import options
from dataset_tools.cli.messages import emit_batch, write_notes
from ncmodel.cli.common import emit

if TYPE_CHECKING:
    from dataset_tools.questionnaires.sentinels import SentinelDrawings

Votes = Annotated[int, typer.Option(help="Answers that each item gets.")]
ReliableVotes = Annotated[int, typer.Option("--votes", help="Votes of reliable participants that each item gets.")]


def build(
    data_dir: options.DataDir,
    batch_dir: options.BatchDir,
    real: options.Real = 30,
    sentinels: options.Sentinels = 5,
    pool: options.Pool = 15,
    votes: Votes = 3,
    artists: options.Artists = None,
    base_url: options.BaseUrl = "images/",
    embed: options.Embed = False,
    drawing_side: options.DrawingSide = 512,
    render_side: options.RenderSide = 384,
    seed: options.Seed = 0,
    as_json: options.AsJson = False,
) -> None:
    """Make questionnaires about all views of a data set: template.html, tasks.csv, images and key.json."""
    from dataset_tools.questionnaires.batch import make_batch
    from dataset_tools.questionnaires.batch_folder import Look
    from dataset_tools.questionnaires.identical_drawings import items_to_ask_about
    from dataset_tools.questionnaires.questionnaire import Scheme
    from ncmodel.data.data_folder import DataFolder

    scheme, look = Scheme(real, sentinels, pool, votes, seed), Look(drawing_side, render_side, base_url, embed)
    data = DataFolder(data_dir)
    needs = dict.fromkeys(items_to_ask_about(data), votes)
    left_out = len(data.items()) - len(needs)
    write_notes([f"not asked about {left_out} views whose eight drawings are one and the same"] if left_out else [])
    emit_batch(make_batch(data_dir, batch_dir, needs, scheme, look, _artists(artists, data_dir)), batch_dir, as_json)


def topup(
    data_dir: options.DataDir,
    votes: options.VotesFile,
    batch_dir: options.BatchDir,
    real: options.Real = 30,
    sentinels: options.Sentinels = 5,
    pool: options.Pool = 15,
    wanted: ReliableVotes = 3,
    artists: options.Artists = None,
    base_url: options.BaseUrl = "images/",
    embed: options.Embed = False,
    drawing_side: options.DrawingSide = 512,
    render_side: options.RenderSide = 384,
    seed: options.Seed = 0,
    as_json: options.AsJson = False,
) -> None:
    """Make questionnaires about exactly the items that are still short of votes."""
    from dataset_tools.questionnaires.batch import make_batch
    from dataset_tools.questionnaires.batch_folder import Look
    from dataset_tools.questionnaires.questionnaire import Scheme
    from dataset_tools.votes.ingest import top_up_needs

    scheme, look = Scheme(real, sentinels, pool, wanted, seed), Look(drawing_side, render_side, base_url, embed)
    needs = top_up_needs(data_dir, votes, wanted)
    if not needs:
        emit({"questionnaires": 0, "items": 0}, as_json, "no item is short of votes")
        return
    report = make_batch(data_dir, batch_dir, needs, scheme, look, _artists(artists, data_dir), fill=False)
    emit_batch(report, batch_dir, as_json)


def _artists(folder: Path | None, data_dir: Path) -> "SentinelDrawings":
    """Where sentinels' drawings come from: a folder, or simulated artists."""
    from dataset_tools.questionnaires.sentinels import ArtistsFolder
    from dataset_tools.simulation.crowd import SimulatedArtists

    return ArtistsFolder(folder) if folder else SimulatedArtists(data_dir)
