"""How a data folder is written: how what lies in it gets there whole, and how its state is told.

A folder of results is written aside and renamed: it appears whole or not at all, whenever the writer dies. What
exists on disk is the state; `index.csv` only lists it. Beside its files, every folder has a `manifest.json` with
their sizes and checksums, by which damage is found later, and the checksum of what the folder was made from (a shape's
mesh file, a view's mesh): a folder made from something else than what is there now is out of date.
"""

import csv
import errno
import fcntl
import io
import json
import os
import shutil
import socket
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Any, Literal

from dataset_tools.build.manifest import MANIFEST, damage, manifest_of, read_json, read_manifest
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.errors import InputError
from ncmodel.files import write_text

Status = Literal["done", "failed", "skipped", "pending", "damaged"]

_ASIDE = ".tmp"
_LOCK = ".lock"
_FULL_DISK = (errno.ENOSPC, errno.EDQUOT)
_FORBIDDEN = (errno.EROFS, errno.EACCES, errno.EPERM)


@dataclass(frozen=True)
class ViewStatus:
    """One row of `index.csv`.

    Attributes:
        shape: The shape's name.
        view: Number of the view.
        status: "done"; "failed"; "skipped" (nothing to draw: low resolution, a duplicate); "pending"; or "damaged".
        reason: Why it isn't done.
        seconds: What it took, if it was done and the build that did it came to note it.
    """

    shape: str
    view: int
    status: Status
    reason: str = ""
    seconds: float | None = None

    @property
    def item(self) -> Item:
        """The view as an item."""
        return Item(self.shape, str(self.view))


class Store(DataFolder):
    """A data folder as a build sees it, which writes it."""

    @contextmanager
    def locked(self, sweep: bool = True) -> Iterator[None]:
        """Keep other builds out of the folder, which is made if it isn't there.

        The lock goes with the process that holds it, however it ends.

        Args:
            sweep: Remove what a build that was killed left aside.

        Raises:
            InputError: The folder can't be written, another build is at work in it, or it was removed meanwhile.
        """
        with writing_to(self.root):
            for folder in (self.shapes_folder, self.views_folder, self._problems, self.root / _ASIDE):
                folder.mkdir(parents=True, exist_ok=True)
            handle = open(self.root / _LOCK, "a+", encoding="utf-8")  # noqa: SIM115 - closed below
        with handle:
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                handle.seek(0)
                found = f"another build is at work in it ({handle.read().strip() or 'unknown'})"
                raise InputError(self.root, found, "one build at a time in a folder") from error
            handle.truncate(0)
            handle.write(f"process {os.getpid()} on {socket.gethostname()}\n")
            handle.flush()
            if sweep:
                with writing_to(self.root):
                    self._sweep()
            yield
            with suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(handle.fileno()), os.stat(self.root / _LOCK)):
                    return
            raise _removed(self.root)

    def write_folder(self, target: Path, files: Mapping[str, bytes], origin: str) -> None:
        """Write a folder of files and its manifest so that it appears whole, in place of what was there.

        Args:
            target: As `shape_folder` or `view_folder` give it.
            files: Name -> content.
            origin: Checksum of what the files were made from.

        Raises:
            InputError: The disk is full, or the folder can't be written.
        """
        with writing_to(self.root):
            (self.root / _ASIDE).mkdir(exist_ok=True)
            aside = Path(tempfile.mkdtemp(dir=self.root / _ASIDE))
            try:
                for name, data in {**files, MANIFEST: _json_bytes(manifest_of(files, origin))}.items():
                    (aside / name).parent.mkdir(exist_ok=True)
                    (aside / name).write_bytes(data)
                _open_to_others(aside)
                _replace(aside, target)
                self._problem_path(target).unlink(missing_ok=True)
            finally:
                shutil.rmtree(aside, ignore_errors=True)

    def record_problem(self, folder: Path, status: Status, reason: str, origin: str) -> None:
        """Keep the reason why a shape's or a view's folder isn't there, or not as it was, until it is written again.

        Args:
            folder: As `shape_folder` or `view_folder` give it.
            status: "failed", "damaged", or "pending" where another try may do.
            reason: One line.
            origin: As for `write_folder`; a problem with something else than what is there now counts no more.
        """
        path = self._problem_path(folder)
        with writing_to(self.root):
            path.parent.mkdir(exist_ok=True)
            write_text(path, json.dumps({"status": status, "reason": reason, "from": origin}) + "\n")

    def remove_folder(self, folder: Path) -> None:
        """Remove a folder of results, all of it at once."""
        with writing_to(self.root):
            _take_away(folder, Path(tempfile.mkdtemp(dir=self.root / _ASIDE)))

    def origin(self, folder: Path) -> str:
        """Checksum of what a folder was made from; "" where it isn't there or is damaged."""
        manifest = read_manifest(folder)
        return str(manifest["from"]) if manifest else ""

    def mesh_checksum(self, shape: str) -> str:
        """Of a shape's cleaned mesh, which its views are made from; "" where there is none."""
        manifest = read_manifest(self.shape_folder(shape)) or {"files": {}}
        return str(manifest["files"].get("mesh.ply", {}).get("sha256", ""))

    def shape_record(self, shape: str) -> dict[str, Any] | None:
        """What `clean.json` says of a shape; None when it hasn't been cleaned, or its folder is damaged."""
        folder = self.shape_folder(shape)
        return None if self._damage(folder, verify=False) else read_json(folder / "clean.json")

    def shapes(self) -> list[str]:
        """The shapes that were cleaned, whatever became of them."""
        try:
            return sorted(path.name for path in self.shapes_folder.iterdir() if path.is_dir())
        except FileNotFoundError:
            return []

    def duplicates(self) -> dict[str, str]:
        """Shape -> the shape that it is a duplicate of."""
        record = read_json(self.duplicates_path) or {}
        return {shape: str(found["of"]) for shape, found in record.get("duplicates", {}).items()}

    def statuses(
        self, shape: str, views: int, duplicates: Mapping[str, str], verify: bool = False
    ) -> Iterator[ViewStatus]:
        """The state of a shape's views, from what lies on disk.

        Args:
            shape: The shape's name.
            views: How many it should have.
            duplicates: As `duplicates` gives them.
            verify: Compare checksums too; otherwise only names and sizes of files.
        """
        status, reason = self._shape_status(shape, duplicates, verify)
        mesh = self.mesh_checksum(shape)
        for view in range(views):
            row = ViewStatus(shape, view, status, reason)
            if status == "done":
                row = ViewStatus(shape, view, *self._view_status(self.view_folder(row.item), mesh, verify))
            yield row

    def _shape_status(self, shape: str, duplicates: Mapping[str, str], verify: bool) -> tuple[Status, str]:
        folder = self.shape_folder(shape)
        if not folder.is_dir():
            problem = read_json(self._problem_path(folder))
            return "pending", str(problem["reason"]) if problem else "not cleaned yet"
        found = self._damage(folder, verify)
        record = read_json(folder / "clean.json")
        if found or record is None:
            return "damaged", f"shape: {found or 'clean.json is damaged'}"
        if record["status"] == "done" and shape in duplicates:
            return "skipped", f"duplicate of {duplicates[shape]}"
        return record["status"], record["reason"]

    def _view_status(self, folder: Path, mesh: str, verify: bool) -> tuple[Status, str]:
        found = self._damage(folder, verify)
        if folder.is_dir():
            if found:
                return "damaged", found
            return ("done", "") if self.origin(folder) == mesh else ("pending", "its mesh has changed")
        problem = read_json(self._problem_path(folder))
        current = problem is not None and problem.get("from") == mesh
        return (problem["status"], problem["reason"]) if problem and current else ("pending", "")

    def _damage(self, folder: Path, verify: bool) -> str:
        """What is wrong with a folder, by its files or as an earlier look at their checksums found."""
        problem = read_json(self._problem_path(folder))
        return damage(folder, verify) or (str(problem["reason"]) if problem else "")

    @property
    def _problems(self) -> Path:
        return self.root / "problems"

    def _problem_path(self, folder: Path) -> Path:
        return self._problems / folder.parent.name / f"{folder.name}.json"

    def write_index(self, rows: Sequence[ViewStatus]) -> None:
        """Write `index.csv`."""
        text = io.StringIO()
        table = csv.writer(text, lineterminator="\n")
        table.writerow([field.name for field in fields(ViewStatus)])
        for row in rows:
            *cells, seconds = astuple(row)
            table.writerow([*cells, "" if seconds is None else f"{seconds:.2f}"])
        with writing_to(self.root):
            write_text(self.index_path, text.getvalue())

    def read_index(self) -> list[ViewStatus]:
        """The rows of `index.csv`; none before the first build.

        Raises:
            InputError: It isn't such a table.
        """
        if not self.index_path.is_file():
            return []
        names = [field.name for field in fields(ViewStatus)]
        with open(self.index_path, encoding="utf-8", newline="") as file:
            table = csv.DictReader(file)
            if table.fieldnames != names:
                raise InputError(self.index_path, f"columns {table.fieldnames}", f"columns {names}")
            try:
                return [_index_row(row) for row in table]
            except (ValueError, TypeError) as error:
                raise InputError(
                    self.index_path, f"line {table.line_num} isn't a view", "the index of a build"
                ) from error

    def _sweep(self) -> None:
        """Remove what a build that was killed left aside."""
        for leftover in [path for path in (self.root / _ASIDE).iterdir() if path.is_dir()]:
            # Whoever still writes into it loses it whole, and can't put half of it in its place.
            _take_away(leftover, Path(tempfile.mkdtemp(dir=self.root / _ASIDE)))
        for leftover in (*self.root.glob(".tmp-*"), *self.root.glob("problems/*/.tmp-*")):
            leftover.unlink(missing_ok=True)


@contextmanager
def writing_to(root: Path) -> Iterator[None]:
    """Turn the errors of a disk that is full, can't be written or is gone into one clear line."""
    try:
        yield
    except OSError as error:
        if error.errno in _FULL_DISK:
            raise InputError(root, "the disk is full", "room for the data; what is done is kept") from error
        if error.errno in _FORBIDDEN or isinstance(error, NotADirectoryError | FileExistsError):
            raise InputError(root, f"can't be written ({error.strerror})", "a folder to write to") from error
        if isinstance(error, FileNotFoundError) and not root.exists():
            raise _removed(root) from error
        raise


def _removed(root: Path) -> InputError:
    return InputError(root, "removed while it was being built", "a folder that stays; the next build begins anew")


def _replace(aside: Path, target: Path) -> None:
    """Put a folder in its place, whatever is there and whoever else does the same at the same time."""
    target.parent.mkdir(parents=True, exist_ok=True)
    while True:
        try:
            aside.rename(target)
            return
        except OSError as error:
            if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
                raise
        # A folder can't be renamed over another one; for a moment neither is there, which reads as pending.
        _take_away(target, Path(tempfile.mkdtemp(dir=aside.parent)))


def _take_away(folder: Path, trash: Path) -> None:
    """Remove a folder, all of it at once: it is renamed into an empty one aside first. It may be gone already."""
    with suppress(FileNotFoundError):
        folder.rename(trash)
    shutil.rmtree(trash, ignore_errors=True)


def _open_to_others(folder: Path) -> None:
    """Give a folder made private by `tempfile` the usual permissions."""
    umask = os.umask(0)
    os.umask(umask)
    folder.chmod(0o777 & ~umask)


def _json_bytes(record: Any) -> bytes:
    return (json.dumps(record, indent=1) + "\n").encode()


def _index_row(row: dict[str, str]) -> ViewStatus:
    status: Any = row["status"]
    seconds = float(row["seconds"]) if row["seconds"] else None
    return ViewStatus(row["shape"], int(row["view"]), status, row["reason"], seconds)
