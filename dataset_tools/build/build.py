"""From mesh files to views with their candidates: resumable, the same bytes whatever the number of workers."""

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from dataset_tools.build.config import BuildConfig
from dataset_tools.build.mesh_files import Source, content_checksum
from dataset_tools.build.runners import Runner
from dataset_tools.build.store import Status, Store, ViewStatus, writing_to
from dataset_tools.build.tasks import CleanTask, ShapeTask, clean_shape, failed_files, make_views
from dataset_tools.build.worker_process import Limits
from dataset_tools.cleaning.near_duplicates import (
    Comparison,
    candidate_pairs,
    compare,
    compared_before,
    decide,
    to_json,
)
from ncmodel.config import read_config, write_config
from ncmodel.errors import InputError
from ncmodel.files import write_text
from ncmodel.progress import Progress, silent

INDEX_SECONDS = 5.0
"""How often `index.csv` is brought up to date during a build."""

_NOT_THERE: tuple[Status, ...] = ("pending", "damaged")
"""Views that every build makes."""


@dataclass(frozen=True)
class Summary:
    """What a build came to.

    Attributes:
        rows: The state of every view.
        made: Views made by this run.
        seconds: Duration of this run.
        missing: Views of this run's shapes that it could neither make nor tell a fault of: the next one tries again.
    """

    rows: Sequence[ViewStatus]
    made: int
    seconds: float
    missing: int = 0

    def count(self, status: str) -> int:
        """Views in this state."""
        return sum(row.status == status for row in self.rows)


def build_dataset(
    sources: Sequence[Source],
    data_dir: str | Path,
    config: BuildConfig,
    runner: Runner,
    progress: Progress = silent,
    retry: bool = False,
) -> Summary:
    """Clean the shapes, choose views, draw and select candidates, and write all into a data folder.

    What is there already is kept; what is missing, damaged or pending is made, and so is what was made from a mesh file
    with other content.

    Args:
        sources: The shapes.
        data_dir: The data folder, new or of an earlier build with the same settings.
        config: The settings.
        runner: What runs the work.
        progress: What reports it.
        retry: Try again what failed before.

    Raises:
        InputError: The folder was built with other settings, can't be written, is in use, or was removed meanwhile.
    """
    begin = time.monotonic()
    store = Store(data_dir)
    with store.locked():
        _settle_config(store, config)
        board = _Board(store, [source.name for source in sources], config.views)
        _clean_shapes(store, sources, config, runner, progress, retry)
        if config.duplicate_distance > 0:
            _find_duplicates(store, board.shapes, config, runner, progress)
        board.refresh()
        _drop_outdated(store, list(board.rows.values()))
        made = _make_views(store, sources, config, runner, progress, retry, board)
        board.refresh()
        shapes = {source.name for source in sources}
        missing = sum(row.shape in shapes and row.status in _NOT_THERE for row in board.rows.values())
        return Summary(list(board.rows.values()), made, time.monotonic() - begin, missing)


def folder_status(data_dir: str | Path, verify: bool = False) -> list[ViewStatus]:
    """The state of every view of a data folder.

    Args:
        data_dir: The data folder.
        verify: Compare checksums, which finds damage that leaves sizes as they are.

    Raises:
        InputError: It isn't a data folder.
    """
    store = Store(data_dir)
    if not store.config_path.is_file():
        raise InputError(data_dir, "no config.toml in it", "a folder made by `ncontours dataset build`")
    config = read_config(BuildConfig, store.config_path)
    earlier = store.read_index()
    seconds = {(row.shape, row.view): row.seconds for row in earlier}
    duplicates = store.duplicates()
    rows = [
        replace(row, seconds=seconds.get((row.shape, row.view)))
        for shape in sorted({*store.shapes(), *(row.shape for row in earlier)})
        for row in store.statuses(shape, config.views, duplicates, verify)
    ]
    damaged = {row.shape for row in rows if row.status == "damaged"}
    if verify and damaged:
        # Neither where nothing can be written nor beside a build; damage is told there all the same.
        with suppress(InputError), store.locked(sweep=False):
            _remember_damage(store, [row for shape in damaged for row in store.statuses(shape, config.views, {}, True)])
    return rows


def _remember_damage(store: Store, rows: Sequence[ViewStatus]) -> None:
    """Note what only checksums tell, so that the next build makes it again without reading every file."""
    for row in rows:
        if row.status == "damaged":
            of_shape = row.reason.startswith("shape: ")
            folder = store.shape_folder(row.shape) if of_shape else store.view_folder(row.item)
            store.record_problem(folder, "damaged", row.reason.removeprefix("shape: "), store.origin(folder))


def _settle_config(store: Store, config: BuildConfig) -> None:
    """Keep the settings beside the data; data made with others don't mix with it."""
    if store.config_path.exists():
        earlier = read_config(BuildConfig, store.config_path)
        for name in config.differences(earlier):
            before, now = getattr(earlier, name), getattr(config, name)
            raise InputError(store.config_path, f"{name} is {before}", f"{now}, as asked for; or a new folder")
        if config == earlier:
            return
    with writing_to(store.root):
        write_text(store.config_path, write_config(config))


class _Board:
    """The state of all views, and `index.csv` following it."""

    def __init__(self, store: Store, shapes: Sequence[str], views: int) -> None:
        self.store, self.views = store, views
        earlier = store.read_index()
        self.seconds = {(row.shape, row.view): row.seconds for row in earlier}
        self.shapes = sorted({*shapes, *store.shapes(), *(row.shape for row in earlier)})
        self.rows: dict[tuple[str, int], ViewStatus] = {}
        self.refresh()

    def refresh(self) -> None:
        """Take the state from disk."""
        duplicates = self.store.duplicates()
        for shape in self.shapes:
            for row in self.store.statuses(shape, self.views, duplicates):
                self.rows[shape, row.view] = replace(row, seconds=self.seconds.get((shape, row.view)))
        self._write()

    def put(self, row: ViewStatus) -> None:
        """Note the outcome of one view."""
        self.rows[row.shape, row.view] = row
        self.seconds[row.shape, row.view] = row.seconds
        if time.monotonic() - self.written > INDEX_SECONDS:
            self._write()

    def _write(self) -> None:
        self.store.write_index(list(self.rows.values()))
        self.written = time.monotonic()


def _clean_shapes(
    store: Store, sources: Sequence[Source], config: BuildConfig, runner: Runner, progress: Progress, retry: bool
) -> None:
    tasks = []
    with progress("read", len(sources)) as advance:
        for source in sources:
            record, content = store.shape_record(source.name), content_checksum(source.path)
            up = config.upward(source.place)
            current = record is not None and (record.get("sha256"), record.get("up")) == (content, up)
            if record is None or not current or (retry and record["status"] == "failed"):
                settings = (config.min_faces, config.clean)
                where = str(source.path), source.place
                tasks.append(CleanTask(str(store.root), *where, content, source.name, up, *settings))
            advance(source.name)
    if not tasks:
        return
    with progress("clean", len(tasks)) as advance:
        for outcome in runner.run(clean_shape, tasks, config.limits.clean):
            task = outcome.task
            if outcome.killed:
                store.record_problem(store.shape_folder(task.name), "pending", outcome.reason, task.sha256)
            elif outcome.result is None:
                store.write_folder(store.shape_folder(task.name), failed_files(task, outcome.reason), task.sha256)
            advance(task.name)


def _find_duplicates(
    store: Store, shapes: Sequence[str], config: BuildConfig, runner: Runner, progress: Progress
) -> None:
    """Compare shapes that may be duplicates, and note which are; what was compared before is not compared again."""
    records = {shape: store.shape_record(shape) for shape in shapes}
    moments = {s: np.array(record["invariants"]) for s, record in records.items() if record and "invariants" in record}
    pairs = candidate_pairs(moments)
    checksums = {shape: store.mesh_checksum(shape) for pair in pairs for shape in pair}
    known = compared_before(store.duplicates_path, checksums)
    distances = {pair: known[pair] for pair in pairs if pair in known}
    tasks = []
    for first, second in pairs:
        if (first, second) not in known:
            meshes = str(store.mesh_path(first)), str(store.mesh_path(second))
            tasks.append(Comparison(first, second, meshes))
    if tasks:
        with progress("duplicates", len(tasks)) as advance:
            for outcome in runner.run(compare, tasks, config.limits.clean):
                if outcome.result is not None:
                    distances[outcome.task.first, outcome.task.second] = outcome.result
                advance(outcome.task.second)
    with writing_to(store.root):
        found = decide(distances, config.duplicate_distance)
        write_text(store.duplicates_path, to_json(distances, found, checksums))


def _drop_outdated(store: Store, rows: Sequence[ViewStatus]) -> None:
    """Remove views whose mesh is another one now, or is gone."""
    for row in rows:
        folder = store.view_folder(row.item)
        current = row.status in ("done", "damaged") or store.origin(folder) == store.mesh_checksum(row.shape)
        if not current and folder.is_dir():
            store.remove_folder(folder)


def _make_views(
    store: Store,
    sources: Sequence[Source],
    config: BuildConfig,
    runner: Runner,
    progress: Progress,
    retry: bool,
    board: _Board,
) -> int:
    again = (*_NOT_THERE, "failed") if retry else _NOT_THERE
    tasks = []
    for source in sources:
        if (store.shape_record(source.name) or {}).get("status") != "done":
            continue
        missing = tuple(v for v in range(config.views) if board.rows[source.name, v].status in again)
        if missing:
            tasks.append(ShapeTask(str(store.root), source.name, missing, config))
    made = 0
    if not tasks:
        return made
    with progress("views", sum(len(task.views) for task in tasks)) as advance:
        for row in _view_outcomes(runner, tasks):
            if row.status == "done":
                made += 1
            else:
                folder = store.view_folder(row.item)
                store.remove_folder(folder)  # a damaged one, if any
                store.record_problem(folder, row.status, row.reason, store.mesh_checksum(row.shape))
            board.put(row)
            advance(row.item.name)
    return made


def _view_outcomes(runner: Runner, tasks: Sequence[ShapeTask]) -> Iterator[ViewStatus]:
    """One row a view. Of a shape that was lost, each view is tried again alone: only some may be to blame."""
    again = []
    for limits, group in _by_size(tasks).items():
        for outcome in runner.run(make_views, group, limits):
            task = outcome.task
            if outcome.result is not None:
                yield from outcome.result
            elif len(task.views) > 1:
                again += [replace(task, views=(view,)) for view in task.views]
            else:
                yield ViewStatus(task.name, task.views[0], "pending" if outcome.killed else "failed", outcome.reason)
    if again:
        yield from _view_outcomes(runner, again)


def _by_size(tasks: Sequence[ShapeTask]) -> Mapping[Limits, list[ShapeTask]]:
    """Tasks by what they may take; nearly all of a build make the same number of views."""
    groups: dict[Limits, list[ShapeTask]] = {}
    for task in tasks:
        groups.setdefault(task.config.limits.making(len(task.views)), []).append(task)
    return groups
