"""`ncontours dataset`: meshes in, views with candidate drawings out."""

from pathlib import Path
from typing import Annotated, Any

import typer

from ncmodel.cli.common import emit, progress
from ncmodel.errors import BatchError, UsageError

group = typer.Typer(help="Clean meshes, choose views, draw and select candidates.", no_args_is_help=True)


Json = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]
Up = Annotated[str | None, typer.Option(help="Upward axis of the mesh files, y or z. (default y)")]


@group.command()
def build(
    mesh_dir: Annotated[Path, typer.Argument(help="Folder with meshes, searched with its subfolders.")],
    data_dir: Annotated[Path, typer.Argument(help="Data folder to make or to go on with.")],
    config: Annotated[Path | None, typer.Option(help="Settings (TOML); options below override it.")] = None,
    views: Annotated[int | None, typer.Option(help="Views of each shape. (default 2)")] = None,
    size: Annotated[str | None, typer.Option(help="Pixels, N or WxH. (default 768)")] = None,
    seed: Annotated[int | None, typer.Option(help="Of azimuths and selection. (default 0)")] = None,
    up: Up = None,
    up_table: Annotated[Path | None, typer.Option(help="Axes of single files: a CSV with columns file, up.")] = None,
    split: Annotated[str, typer.Option(help="Only meshes whose names are for training, or for test; all.")] = "all",
    min_faces: Annotated[int | None, typer.Option(help="Skip shapes with fewer faces. (default 2000)")] = None,
    workers: Annotated[int | None, typer.Option(help="Processes; 0: this one, no limits. (default one a core)")] = None,
    scheduler: Annotated[str | None, typer.Option(help="Dask scheduler, tcp://HOST:PORT, instead of workers.")] = None,
    retry: Annotated[bool, typer.Option("--retry", help="Try again what failed before.")] = False,
    as_json: Json = False,
) -> None:
    """Clean every mesh, choose views, draw 264 candidates, select 8; goes on where it was stopped."""
    from dataset_tools.build.build import build_dataset
    from dataset_tools.build.mesh_files import find_sources, read_up_table
    from dataset_tools.build.runners import core_count, runner_for
    from dataset_tools.build.summary import summary_record, summary_text
    from dataset_tools.collection.selection import sources_of
    from ncmodel.data.data_folder import DataFolder
    from ncmodel.drawing.arguments import size_of

    width, height = size_of(size) if size else (None, None)
    chosen = {"views": views, "width": width, "height": height, "seed": seed, "up": up, "min_faces": min_faces}
    rules = read_up_table(up_table) if up_table else None
    settings = _settings(config, DataFolder(data_dir).config_path, {**chosen, "up_rules": rules})
    sources = sources_of(find_sources(mesh_dir, data_dir), split)
    with runner_for(core_count() if workers is None else workers, scheduler) as runner:
        summary = build_dataset(sources, data_dir, settings, runner, progress, retry)
    emit(summary_record(summary), as_json, summary_text(summary))
    failed, missing = summary.count("failed"), summary.missing
    if failed or missing:
        left = f"{missing} views are still to be made" if missing else ""
        told = "; ".join(filter(None, (f"{failed} views failed" if failed else "", left)))
        raise BatchError(f"{told}, reasons in {DataFolder(data_dir).index_path}")


@group.command()
def views(
    data_dir: Annotated[Path, typer.Argument(help="Data folder with the shapes.")],
    cameras: Annotated[Path, typer.Argument(help="Folder of camera files, SHAPE_VIEW.json each.")],
    as_json: Json = False,
) -> None:
    """Add views through given cameras to a data folder: where people drew from."""
    from dataset_tools.build.given_views import add_views, count_cameras

    with progress("views", count_cameras(cameras)) as advance:
        added = add_views(data_dir, cameras, advance)
    emit({"views": [item.name for item in added]}, as_json, f"{len(added)} views in {data_dir}")


@group.command()
def disjoint(
    mesh_dir: Annotated[Path, typer.Argument(help="Folder with meshes to test on, not yet in the data folder.")],
    data_dir: Annotated[Path, typer.Argument(help="Data folder that is trained on.")],
    as_json: Json = False,
) -> None:
    """Check that no mesh is a shape of a data folder again; exit 1 if one is."""
    from dataclasses import asdict

    from dataset_tools.build.mesh_files import find_sources
    from dataset_tools.collection.disjoint import shapes_known

    sources = find_sources(mesh_dir, None)
    with progress("meshes", len(sources)) as advance:
        found = shapes_known(sources, data_dir, advance)
    record = {"meshes": len(sources), "duplicates": [asdict(one) for one in found]}
    emit(record, as_json, f"{len(sources)} meshes, {len({one.shape for one in found})} of them in {data_dir}")
    if found:
        told = "; ".join(f"{one.shape} is {one.of} again ({one.distance:g} radii apart)" for one in found)
        raise BatchError(f"{mesh_dir}: {told}")


@group.command()
def shapes(
    mesh_dir: Annotated[Path, typer.Argument(help="Folder to write the meshes to, or to go on with.")],
    count: Annotated[int, typer.Option(help="How many.", min=1)] = 500,
    seed: Annotated[int, typer.Option(help="Other shapes.", min=0)] = 0,
    families: Annotated[str | None, typer.Option(help="Only these, a,b,c. (default all)")] = None,
    split: Annotated[str, typer.Option(help="training: without the test families; test: those alone; all.")] = "all",
    workers: Annotated[int | None, typer.Option(help="Processes; 0: this one. (default one a core)")] = None,
    as_json: Json = False,
) -> None:
    """Make a collection of shapes to train on, FAMILY_NUMBER.ply each; goes on where it was stopped."""
    from dataset_tools.build.runners import core_count, runner_for
    from dataset_tools.collection.families import held_out_families
    from dataset_tools.collection.selection import shape_names
    from dataset_tools.collection.writing import write_collection

    names = shape_names(count, seed, tuple(families.split(",")) if families is not None else None, split)
    with runner_for(core_count() if workers is None else workers) as runner, progress("shapes", count) as advance:
        done = write_collection(mesh_dir, names, runner, advance)
    record = {"made": done.made, "kept": done.kept, "failed": done.failed, "test_families": list(held_out_families())}
    emit(record, as_json, f"{done.made} shapes made, {done.kept} kept, in {mesh_dir}")
    if done.failed:
        raise BatchError(f"{len(done.failed)} shapes failed: {next(iter(done.failed.items()))}")


@group.command()
def clean(
    mesh: Annotated[Path, typer.Argument(help="Mesh file.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Cleaned mesh, *.ply.")],
    up: Up = None,
    weld: Annotated[float | None, typer.Option(help="Vertices closer than this share of the size become one.")] = None,
    snap: Annotated[float | None, typer.Option(help="Borders closer than this share of it are connected.")] = None,
    support: Annotated[float | None, typer.Option(help="Distance of vertices put beside hard edges; 0: none.")] = None,
    keep_hidden: Annotated[bool, typer.Option("--keep-hidden", help="Keep parts that can't be seen.")] = False,
    as_json: Json = False,
) -> None:
    """Repair one mesh: weld, connect, orient outwards, remove what is hidden, normalise; report what was done."""
    from dataset_tools.build.summary import clean_text
    from dataset_tools.cleaning.repair import CleanSettings, clean_file
    from ncmodel.files import write_bytes
    from ncmodel.readers.ply import ply_bytes

    if output.suffix.lower() != ".ply":
        raise UsageError(f"-o: found {output}, expected a file *.ply")
    chosen = {"weld": weld, "snap": snap, "support": support, "remove_hidden": False if keep_hidden else None}
    cleaned, report = clean_file(mesh, up or "y", _with(CleanSettings(), chosen))
    write_bytes(output, ply_bytes(cleaned))
    emit(report.to_record(), as_json, clean_text(report))


@group.command()
def status(
    data_dir: Annotated[Path, typer.Argument(help="Data folder.")],
    verify: Annotated[bool, typer.Option("--verify", help="Compare checksums: finds every damage.")] = False,
    as_json: Json = False,
) -> None:
    """Count what is done, failed (with reason), pending; exit 1 when something failed or is damaged."""
    from dataset_tools.build.build import folder_status
    from dataset_tools.build.summary import status_record, status_text

    rows = folder_status(data_dir, verify)
    emit(status_record(rows), as_json, status_text(rows))
    wrong = sum(row.status in ("failed", "damaged") for row in rows)
    if wrong:
        raise BatchError(f"{wrong} views failed or are damaged; the next build makes damaged ones again")


@group.command()
def export(
    view: Annotated[Path, typer.Argument(help="View folder, DATA_DIR/views/SHAPE_VIEW.")],
    output: Annotated[Path, typer.Argument(help="Folder to write.")],
    format_: Annotated[str, typer.Option("--format", help="Only neuralcontours.")] = "neuralcontours",
    size: Annotated[str, typer.Option(help="Pixels, N or WxH.")] = "1024x768",
    as_json: Json = False,
) -> None:
    """Write a view as the folder that the published code reads."""
    from ncmodel.data.data_folder import DataFolder
    from ncmodel.drawing.arguments import size_of
    from ncmodel.files import write_bytes
    from ncmodel.published.rendering import published_view

    _check_format(format_)
    data, item = DataFolder.of_view(view)
    files = published_view(data.open_view(item, size_of(size))).files()
    output.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        write_bytes(output / name, content)
    emit({"files": sorted(files), "folder": str(output)}, as_json, f"{len(files)} files in {output}")


@group.command(name="import")
def import_(
    folder: Annotated[Path, typer.Argument(help="Folder in the published code's format.")],
    output: Annotated[Path, typer.Argument(help="Line, feature, depth and shaded maps, *.npz.")],
    format_: Annotated[str, typer.Option("--format", help="Only neuralcontours.")] = "neuralcontours",
    as_json: Json = False,
) -> None:
    """Read a folder of the published code as the maps that our model takes."""
    from dataset_tools.build.encoding import npz
    from ncmodel.files import write_bytes
    from ncmodel.published.folder import read_folder

    _check_format(format_)
    if output.suffix.lower() != ".npz":
        raise UsageError(f"found {output}, expected a file *.npz")
    arrays = read_folder(folder).arrays()
    write_bytes(output, npz(**arrays))
    shapes = {name: list(array.shape) for name, array in arrays.items()}
    emit({"file": str(output), "arrays": shapes}, as_json, f"{len(arrays)} arrays in {output}")


@group.command()
def sheet(
    data_dir: Annotated[Path, typer.Argument(help="Data folder.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Picture, *.png.")],
    names: Annotated[list[str] | None, typer.Option("--view", help="SHAPE_VIEW, repeatable. (default all)")] = None,
) -> None:
    """Draw a contact sheet: renders and selected drawings of each view."""
    from dataset_tools.candidates.contact_sheet import data_sheet
    from ncmodel.images import write_png

    if output.suffix.lower() != ".png":
        raise UsageError(f"-o: found {output}, expected a file *.png")
    write_png(output, data_sheet(data_dir, names or ()))


@group.command()
def levels(
    data_dir: Annotated[Path, typer.Argument(help="Data folder.")],
    as_json: Json = False,
) -> None:
    """Measure how much each threshold of the candidates keeps on the views, and how many drawings differ."""
    from dataset_tools.build.summary import thresholds_text
    from dataset_tools.build.threshold_study import study_thresholds

    study = study_thresholds(data_dir)
    emit(study.to_record(), as_json, thresholds_text(study))


@group.command()
def bench(as_json: Json = False) -> None:
    """Measure a view by stage, the ways to its distances, and builds with one and two workers."""
    from dataset_tools.build import costs
    from dataset_tools.simulation.shapes import bumpy_torus, make_shapes
    from ncmodel.report.text import text_table

    with progress("bench", costs.STEPS) as advance:
        parts = costs.dataset_parts(bumpy_torus(costs.VIEW_FACES), make_shapes(costs.BUILD_SHAPES), advance)
    text = "\n\n".join(f"{part.text}\n{text_table(part.rows)}" for part in parts)
    emit({part.name: part.record for part in parts}, as_json, text)


def _check_format(name: str) -> None:
    if name != "neuralcontours":
        raise UsageError(f"--format: found {name!r}, expected neuralcontours")


def _settings(config: Path | None, earlier: Path, chosen: dict[str, Any]) -> Any:
    """Settings of a file, of the folder or the defaults, with what was chosen on the command line instead."""
    from dataset_tools.build.config import BuildConfig
    from ncmodel.config import read_config

    base = config or (earlier if earlier.is_file() else None)
    return _with(read_config(BuildConfig, base) if base else BuildConfig(), chosen)


def _with(settings: Any, chosen: dict[str, Any]) -> Any:
    from dataclasses import replace

    try:
        return replace(settings, **{key: value for key, value in chosen.items() if value is not None})
    except ValueError as error:
        raise UsageError(str(error)) from error
