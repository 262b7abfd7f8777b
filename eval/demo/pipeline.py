"""The whole pipeline, from mesh files to an evaluated model, on meshes that installed packages bundle."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from eval.demo.stages import Stage, command_stage
from ncmodel.errors import InputError, UsageError
from ncmodel.files import write_text

BUNDLED = ("bunny.obj", "airplane.obj", "cow.obj", "bone.ply", "rangemaps/face000.ply")
"""Real meshes among the sample meshes in pymeshlab's wheel. No model is trained on them."""


@dataclass(frozen=True)
class Plan:
    """How much the demo does.

    Attributes:
        training: Made shapes to train on.
        test: Made shapes of families that nothing is trained on.
        size: Pixels of a view's side.
        effort: Of the search for thresholds.
        tuning_views: Training views that baselines are tuned on.
        epochs: Passes over the training data in each stage; the preset's by default.
        bundled: The real meshes, which nothing is trained on either.
        smoke: Whether it only shows that everything works.
    """

    training: int
    test: int
    size: int
    effort: str
    tuning_views: int
    epochs: int | None = None
    bundled: tuple[str, ...] = BUNDLED
    smoke: bool = False


NOISE = 0.15
"""Of simulated participants: three in five views then find a consensus, as with the paper's participants."""
LEAST_FACES = 500
"""Some of the made shapes are coarse."""
VALIDATION_SHARE = 8
"""Of the shapes that may be trained on, every so many-th watches over training instead."""

FULL = Plan(training=64, test=8, size=768, effort="balanced", tuning_views=12)
QUICK = Plan(
    training=12, test=2, size=384, effort="draft", tuning_views=4, bundled=("bunny.obj", "cow.obj"), smoke=True
)


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
    held_out = held_out_shapes(plan, seed)
    seeded = ("--seed", str(seed))
    meshes, data = out / "meshes", out / "data"
    batch, results = out / "batch", out / "simulated-results.csv"
    votes, pairs = out / "votes.csv", out / "pairs.jsonl"
    epochs = () if plan.epochs is None else ("--epochs", plan.epochs)
    training, model = out / "training-pairs.jsonl", out / "model.safetensors"

    def command(name: str, title: str, *argv: object, output: Path, resumes: bool = True) -> Stage:
        return command_stage(name, title, [str(word) for word in argv], (output,), resumes)

    def shapes(name: str, title: str, count: int, split: str) -> Stage:
        last = meshes / f"{_shape_names(count, seed, split)[-1]}.ply"
        return command(
            name, title, *("dataset", "shapes", meshes, "--count", count, "--split", split, *seeded), output=last
        )

    return [
        Stage("bundled", "Link real meshes", link_bundled, (meshes, plan.bundled), (meshes,)),
        shapes("shapes", "Make shapes to train on", plan.training, "training"),
        shapes("test-shapes", "Make shapes of families that nothing is trained on", plan.test, "test"),
        command(
            "dataset",
            "Clean, two views each, 264 candidates, 8 selected",
            *("dataset", "build", meshes, data, "--workers", 2, "--size", plan.size, "--min-faces", LEAST_FACES),
            *seeded,
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
        command(
            "compare",
            "Draw the held-out views by every method, by this model and by the one that ships",
            *("compare", data, pairs, "--model", model, "--model", "default", "-o", out / "comparison"),
            *("--shapes", ",".join(held_out)),
            *("--preset", plan.effort, "--tuning-views", plan.tuning_views, "--workers", 2),
            output=out / "comparison" / "compare.json",
        ),
    ]


def held_out_shapes(plan: Plan, seed: int = 0) -> list[str]:
    """The shapes that nothing is trained on: all real ones, and made ones of families of their own."""
    return [*(Path(name).stem for name in plan.bundled), *_shape_names(plan.test, seed, "test")]


def _shape_names(count: int, seed: int, split: str) -> list[str]:
    from dataset_tools.collection.selection import shape_names

    return shape_names(count, seed, split=split)


def link_bundled(folder: Path, names: Sequence[str]) -> None:
    """Link meshes that pymeshlab's wheel bundles.

    Raises:
        InputError: The installed pymeshlab lacks its sample meshes.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for path in bundled_meshes(names):
        link = folder / path.name
        link.unlink(missing_ok=True)
        link.symlink_to(path)


def split_for_training(pairs: Path, held_out: Sequence[str], output: Path) -> None:
    """Write the pairs that training may see: none of held-out shapes, and a validation split of its own.

    The choice of the best epoch looks at validation pairs, so these can't be the ones that the result is measured on.
    """
    from ncmodel.data.pairs import read_pairs, write_pairs

    kept = [pair for pair in read_pairs(pairs) if pair.item.shape not in held_out]
    shapes = sorted({pair.item.shape for pair in kept})
    watching = set(shapes[VALIDATION_SHARE // 2 :: VALIDATION_SHARE])
    write_pairs(
        output, (replace(pair, split="validation" if pair.item.shape in watching else "train") for pair in kept)
    )


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
