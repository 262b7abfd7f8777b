"""Arguments and options that several commands take: each is spelt, typed and explained here."""

from pathlib import Path
from typing import Annotated, Literal

import typer

BatchDir = Annotated[Path, typer.Argument(help="Folder of a batch of questionnaires.")]
DataDir = Annotated[Path, typer.Argument(help="Folder that `ncontours dataset build` wrote.")]
VotesFile = Annotated[Path, typer.Argument(help="Votes that `ncontours crowd ingest` wrote.")]

AsJson = Annotated[bool, typer.Option("--json", help="Print a summary as one JSON object.")]
Seed = Annotated[int, typer.Option(help="Of everything random.")]
HtmlOut = Annotated[Path, typer.Option("--output", "-o", help="HTML file to write.")]
ResultsOut = Annotated[Path, typer.Option("--output", "-o", help="Results file to write.")]

Real = Annotated[int, typer.Option(help="Questions about items in each questionnaire.")]
Sentinels = Annotated[int, typer.Option(help="Sentinel questions in each questionnaire.")]
Pool = Annotated[int, typer.Option(help="Sentinels to draw from.")]
Artists = Annotated[
    Path | None,
    typer.Option(
        help="Folder of artists' drawings for sentinels, SHAPE_VIEW.png or SHAPE_VIEW/*.png; simulated by default."
    ),
]

BaseUrl = Annotated[str, typer.Option(help="What stands before the pictures' names in tasks.csv.")]
Embed = Annotated[bool, typer.Option(help="Put the pictures into tasks.csv, as data URIs.")]
DrawingSide = Annotated[int, typer.Option(help="Longest side of a drawing, pixels.")]
RenderSide = Annotated[int, typer.Option(help="Longest side of a render, pixels.")]

Participants = Annotated[
    int | None, typer.Option(help="How many; by default until each questionnaire was answered reliably.")
]
RandomClickers = Annotated[float, typer.Option(help="Share of participants who click at random.")]
Follow = Annotated[
    Literal["sketching", "frugal"],
    typer.Option(help="Whom simulated participants follow: artists who draw as people do, or few lines."),
]
Noise = Annotated[float, typer.Option(help="Spread of the errors in judging drawings.")]
