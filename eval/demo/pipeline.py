"""The whole pipeline, from mesh files to an evaluated model, on meshes that installed packages bundle."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from eval.demo.stages import Stage, command_stage
from ncmodel.errors import InputError, UsageError
from ncmodel.files import write_bytes, write_text

BUNDLED = ("bunny.obj", "airplane.obj", "cow.obj", "bone.ply", "rangemaps/face000.ply")
"""Real meshes among the sample meshes in pymeshlab's wheel."""


@dataclass(frozen=True)
class Plan:
    """How much the demo does.

    Attributes:
        made: Shapes made in code, besides the bundled meshes.
        held_out: How many of these are kept from training, besides the real ones.
        size: Pixels of a view's side.
        effort: Of the search for thresholds.
        epochs: Passes over the training data in each stage; the preset's by default.
        bundled: The bundled meshes that take part.
        real_held_out: The shapes among these that are kept from training.
    """

    made: int
    held_out: int
    size: int
    effort: str
    epochs: int | None = None
    bundled: tuple[str, ...] = BUNDLED
    real_held_out: tuple[str, ...] = ("bunny", "cow")


NOISE = 0.15
"""Of simulated participants: three in five views then find a consensus, as with the paper's participants."""

FULL = Plan(made=80, held_out=10, size=768, effort="balanced")
QUICK = Plan(made=11, held_out=2, size=384, effort="draft")


def claim_folder(out_dir: Path, settings: str) -> None:
    """Make the folder, or check that the demo made it with the same settings.

    Raises:
        UsageError: It was made with others, or holds something else.
    """
    record = out_dir / "demo.toml"
    if record.exists():
        if record.read_text(encoding="utf-8") != settings:
            raise UsageError(f"{out_dir}: made with other settings ({record}); expected the same or another folder")
        return
    if out_dir.exists() and any(out_dir.iterdir()):
        raise UsageError(f"{out_dir}: holds files that the demo didn't make, expected a new or empty folder")
    out_dir.mkdir(parents=True, exist_ok=True)
    write_text(record, settings)


def pipeline_stages(out: Path, plan: Plan, seed: int) -> list[Stage]:
    """The stages, in order."""
    from eval.demo.held_out import draw_held_out, split_for_training

    held_out = held_out_shapes(plan)
    seeded = ("--seed", str(seed))
    meshes, data = out / "meshes", out / "data"
    batch, results = out / "batch", out / "simulated-results.csv"
    votes, pairs = out / "votes.csv", out / "pairs.jsonl"
    epochs = () if plan.epochs is None else ("--epochs", plan.epochs)
    training, model = out / "training-pairs.jsonl", out / "model.safetensors"

    def command(name: str, title: str, *argv: object, output: Path, resumes: bool = True) -> Stage:
        return command_stage(name, title, [str(word) for word in argv], (output,), resumes)

    return [
        Stage("meshes", "Collect and make meshes", make_meshes, (meshes, plan, seed), (meshes,)),
        command(
            "dataset",
            "Clean, two views each, 264 candidates, 8 selected",
            *("dataset", "build", meshes, data, "--workers", 2, "--size", plan.size, *seeded),
            output=data / "index.csv",
        ),
        command(
            "questionnaires",
            "Make questionnaires",
            *("crowd", "build", data, batch, *seeded),
            output=batch,
            resumes=False,
        ),
        command(
            "simulate",
            "Simulated participants answer",
            *("crowd", "simulate", batch, "-o", results, "--data", data, "--noise", NOISE, *seeded),
            output=results,
        ),
        command(
            "ingest",
            "Read the votes",
            *("crowd", "ingest", batch, results, "-o", votes),
            output=votes,
            resumes=False,
        ),
        command(
            "aggregate",
            "Reliability, consensus, ranking pairs",
            *("crowd", "aggregate", votes, "-o", pairs, "--validation-shapes", ",".join(held_out), *seeded),
            output=pairs,
        ),
        Stage(
            "split",
            "Keep the held-out shapes from training",
            split_for_training,
            (pairs, held_out, training),
            (training,),
        ),
        command(
            "train",
            "Train the ranking module and the image branch",
            *("train", data, training, "-o", model, "--preset", "tiny", *epochs, *seeded),
            output=model,
        ),
        Stage(
            "drawings",
            "Draw the held-out views by every method",
            draw_held_out,
            (out, held_out, plan.effort),
            (out / "held-out" / "model.json",),
        ),
    ]


def held_out_shapes(plan: Plan) -> list[str]:
    """The shapes that training never sees: real ones, and the last of those made."""
    from dataset_tools.simulation.shapes import shape_names

    return [*plan.real_held_out, *shape_names(plan.made)[-plan.held_out :]]


def make_meshes(folder: Path, plan: Plan, seed: int) -> None:
    """Link the meshes that pymeshlab's wheel bundles, and write those made in code.

    Raises:
        InputError: The installed pymeshlab lacks its sample meshes.
    """
    from dataset_tools.simulation.shapes import make_shapes
    from ncmodel.mesh.ply import ply_bytes

    folder.mkdir(parents=True, exist_ok=True)
    for path in bundled_meshes(plan.bundled):
        link = folder / path.name
        link.unlink(missing_ok=True)
        link.symlink_to(path)
    for mesh in make_shapes(plan.made, seed):
        write_bytes(folder / f"{mesh.name}.ply", ply_bytes(mesh))


def bundled_meshes(names: Sequence[str] = BUNDLED) -> list[Path]:
    """Sample meshes that pymeshlab's wheel bundles.

    Raises:
        InputError: The installed pymeshlab lacks them.
    """
    import importlib.util

    spec = importlib.util.find_spec("pymeshlab")
    if spec is None or spec.origin is None:
        raise InputError("pymeshlab", "not installed", "the package with its sample meshes")
    samples = Path(spec.origin).parent / "tests" / "sample_meshes"
    for name in names:
        if not (samples / name).is_file():
            raise InputError(samples / name, "no such file", "a mesh that pymeshlab's wheel bundles")
    return [samples / name for name in names]
