"""`ncontours crowd`: questionnaires out, votes in, ranking pairs from them."""

import typer

from dataset_tools.cli import study
from dataset_tools.cli.questionnaires import build, topup
from dataset_tools.cli.simulation import simulate, trial
from dataset_tools.cli.site import backup, links, serve
from dataset_tools.cli.votes import aggregate, audit, ingest, review

group = typer.Typer(help="Questionnaires for people, and ranking pairs from their votes.", no_args_is_help=True)
for command in (build, serve, links, backup, simulate, ingest, aggregate, topup, audit, review, trial):
    group.command()(command)
group.add_typer(study.group, name="study")
