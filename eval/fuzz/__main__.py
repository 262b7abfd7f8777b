"""Gives damaged files to all readers and keeps those that one of them neither reads nor refuses in one line.

python -m eval.fuzz -o FAULTS --inputs 6500 --seed 0
"""

from pathlib import Path
from typing import Annotated

import typer

from dataset_tools.build.worker_process import WorkerProcess
from eval.fuzz.samples import KINDS
from eval.fuzz.trials import damaged_file, try_all
from ncmodel.errors import ArgumentError


def main(
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for what fails, by kind and seed.")],
    inputs: Annotated[int, typer.Option(help="Files of all kinds together.", min=1)] = 1300,
    seed: Annotated[int, typer.Option(help="The first; each file has the next one.", min=0)] = 0,
    kinds: Annotated[str, typer.Option(help=f"Of {','.join(KINDS)}.")] = ",".join(KINDS),
) -> None:
    """Read damaged files; status 1 if one is neither read nor refused in one line."""
    chosen = kinds.split(",")
    unknown = [kind for kind in chosen if kind not in KINDS]
    if unknown:
        raise ArgumentError("kinds", unknown[0], f"some of {','.join(KINDS)}")
    output.mkdir(parents=True, exist_ok=True)
    worker, failed = WorkerProcess(), False
    typer.echo("| kind | seeds | read | refused | faults |\n|---|---|---|---|---|")
    try:
        for number, kind in enumerate(chosen):
            count = inputs // len(chosen) + (number < inputs % len(chosen))
            tally = try_all(kind, range(seed, seed + count), worker)
            faults = len(tally.faults)
            typer.echo(f"| {kind} | {seed} to {seed + count - 1} | {tally.read} | {tally.refused} | {faults} |")
            for fault in tally.faults:
                failed = True
                (output / f"{fault.seed}{kind if kind.startswith('.') else f'-{kind}'}").write_bytes(
                    damaged_file(kind, fault.seed)
                )
                typer.echo(f"{kind} {fault.seed}: {fault.why[:300]}", err=True)
    finally:
        worker.close()
    raise typer.Exit(int(failed))


if __name__ == "__main__":
    typer.run(main)
