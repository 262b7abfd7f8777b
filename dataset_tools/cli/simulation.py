"""`ncontours crowd simulate` and `trial`: simulated participants."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from dataset_tools.cli import options
from dataset_tools.cli.messages import emit_simulated
from ncmodel.cli.common import emit, progress


def simulate(
    batch_dir: options.BatchDir,
    output: options.ResultsOut,
    data: Annotated[Path | None, typer.Option(help="The data folder; the batch knows it by default.")] = None,
    participants: options.Participants = None,
    random_clickers: options.RandomClickers = 0.15,
    noise: options.Noise = 0.2,
    follow: options.Follow = "sketching",
    seed: options.Seed = 0,
    as_json: options.AsJson = False,
) -> None:
    """Let simulated participants answer a batch; their results say that they are simulated."""
    from dataset_tools.questionnaires.questionnaire import Key
    from dataset_tools.simulation.crowd import simulate_batch
    from dataset_tools.simulation.participants import Crowd

    crowd = Crowd(noise=noise, random_clickers=random_clickers)
    with progress("items seen by simulated artists", len(Key.load(batch_dir).items)) as advance:
        done = simulate_batch(batch_dir, output, crowd, data, participants, seed, advance, follow)
    emit_simulated(done, output, as_json)


def trial(
    data_dir: options.DataDir,
    output: options.HtmlOut,
    participants: Annotated[int, typer.Option(help="Simulated participants.")] = 400,
    random_clickers: options.RandomClickers = 0.15,
    adversaries: Annotated[int, typer.Option(help="Simulated adversaries of each of ten kinds.")] = 6,
    noise: options.Noise = 0.2,
    items: Annotated[int, typer.Option(help="Views of the data folder to draw distances from.", min=1)] = 24,
    follow: options.Follow = "sketching",
    seed: options.Seed = 0,
    as_json: options.AsJson = False,
) -> None:
    """Try the rules on a simulated crowd with adversaries: whom and what they keep, and what they exclude wrongly."""
    from dataset_tools.simulation.crowd import sample_distances
    from dataset_tools.simulation.participants import Crowd
    from dataset_tools.simulation.rule_trial import run_trial
    from dataset_tools.simulation.rule_trial_report import as_text, write_trial

    with progress("items seen by simulated artists", items) as advance:
        known = sample_distances(data_dir, items, seed, advance, follow)
    crowd = Crowd(noise=noise, random_clickers=random_clickers)
    found = run_trial(known, crowd, participants, adversaries, seed)
    write_trial(found, output)
    emit(asdict(found), as_json, f"{as_text(found)}\n{output}")
