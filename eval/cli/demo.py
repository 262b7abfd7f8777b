"""`ncontours demo`: everything in a row, on meshes that installed packages bundle."""

from pathlib import Path
from typing import Annotated

import typer

from ncmodel.cli.common import emit


def demo(
    out_dir: Annotated[Path, typer.Argument(help="Folder for everything that the demo makes.")],
    quick: Annotated[bool, typer.Option("--quick", help="Fewer shapes, smaller pictures: six minutes.")] = False,
    seed: Annotated[int, typer.Option(help="Of everything random.")] = 0,
    as_json: Annotated[bool, typer.Option("--json", help="Print the summary as one JSON object.")] = False,
) -> None:
    """Clean, draw, vote (simulated participants), train, evaluate: the whole pipeline. Started again, it goes on."""
    from eval.demo.pipeline import FULL, QUICK, claim_folder, pipeline_stages
    from eval.demo.report import summary_text, write_demo_report
    from eval.demo.stages import run_stages

    plan = QUICK if quick else FULL
    claim_folder(out_dir, f"quick = {str(quick).lower()}\nseed = {seed}\n")
    stages = pipeline_stages(out_dir, plan, seed)
    measured = run_stages(stages, out_dir)
    summary = write_demo_report(out_dir, plan, [(stage, measured[stage.name]) for stage in stages])
    emit(summary, as_json, summary_text(summary))
