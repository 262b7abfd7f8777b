"""Options that several commands of the crowd take."""

from pathlib import Path
from typing import Annotated

import typer

AsJson = Annotated[bool, typer.Option("--json", help="Print a summary as one JSON object.")]
Seed = Annotated[int, typer.Option(help="Of everything random.")]
BatchDir = Annotated[Path, typer.Argument(help="Folder of a batch of questionnaires.")]
BaseUrl = Annotated[str, typer.Option(help="What stands before the pictures' names in tasks.csv.")]
Embed = Annotated[bool, typer.Option(help="Put the pictures into tasks.csv, as data URIs.")]
DrawingSide = Annotated[int, typer.Option(help="Longest side of a drawing, pixels.")]
RenderSide = Annotated[int, typer.Option(help="Longest side of a render, pixels.")]
ResultsOut = Annotated[Path, typer.Option("--output", "-o", help="Results file to write.")]
HtmlOut = Annotated[Path, typer.Option("--output", "-o", help="HTML file to write.")]
Participants = Annotated[
    int | None, typer.Option(help="How many; by default until each questionnaire was answered reliably.")
]
RandomClickers = Annotated[float, typer.Option(help="Share of participants who click at random.")]
Noise = Annotated[float, typer.Option(help="Spread of the errors in judging drawings.")]
