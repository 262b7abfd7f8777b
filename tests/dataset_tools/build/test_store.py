"""The data folder: whole folders or none, damage found, one build at a time."""

import errno
import hashlib
import json
import multiprocessing
import os
from pathlib import Path

import pytest

from dataset_tools.build.manifest import damage, file_checksum
from dataset_tools.build.store import Store, ViewStatus, writing_to
from ncmodel.data.item import Item
from ncmodel.errors import InputError

FILES = {"a.txt": b"first", "drawings/0.png": b"second"}
MESH = hashlib.sha256(b"mesh").hexdigest()


@pytest.fixture
def store(tmp_path: Path) -> Store:
    made = Store(tmp_path / "data")
    with made.locked():
        pass
    return made


def write_shape(store: Store, name: str, status: str = "done", reason: str = "") -> None:
    record = json.dumps({"status": status, "reason": reason}).encode()
    store.write_folder(store.shape_folder(name), {"clean.json": record, "mesh.ply": b"mesh"}, "source")


def states(store: Store, shape: str, views: int = 1) -> list[tuple[str, str]]:
    return [(row.status, row.reason) for row in store.statuses(shape, views, store.duplicates())]


def test_a_folder_is_written_with_its_manifest(store: Store) -> None:
    target = store.view_folder(Item("cow", "1"))
    store.write_folder(target, FILES, "m")
    assert target.name == "cow_1"
    assert {
        str(p.relative_to(target)): p.read_bytes() for p in target.rglob("*.*") if p.name != "manifest.json"
    } == FILES
    assert damage(target, verify=True) == ""
    assert not list((store.root / ".tmp").iterdir())


def test_a_folder_replaces_the_one_before(store: Store) -> None:
    target = store.view_folder(Item("cow", "0"))
    store.write_folder(target, {"old.txt": b"x"}, "m")
    store.write_folder(target, FILES, "m")
    assert not (target / "old.txt").exists()
    assert damage(target, verify=True) == ""
    assert not list((store.root / ".tmp").iterdir())


def test_a_folder_that_could_not_be_written_leaves_nothing(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    written = Path.write_bytes

    def fill_the_disk(path: Path, data: bytes) -> int:
        if path.name == "0.png":
            raise OSError(errno.ENOSPC, "No space left on device", str(path))
        return written(path, data)

    monkeypatch.setattr(Path, "write_bytes", fill_the_disk)
    with pytest.raises(InputError, match="the disk is full"):
        store.write_folder(store.view_folder(Item("cow", "0")), FILES, MESH)
    assert not store.view_folder(Item("cow", "0")).exists()
    assert not list((store.root / ".tmp").iterdir())


@pytest.mark.parametrize(
    ("code", "text"), [(errno.EROFS, "can't be written"), (errno.EACCES, "can't be written"), (errno.EDQUOT, "full")]
)
def test_errors_of_the_disk_are_one_clear_line(code: int, text: str) -> None:
    with pytest.raises(InputError, match=text), writing_to(Path("data")):
        raise OSError(code, os.strerror(code))


def test_other_errors_of_the_system_pass() -> None:
    with pytest.raises(OSError, match="strange"), writing_to(Path("data")):
        raise OSError(errno.EIO, "strange")


def test_a_file_in_the_way_is_bad_input(tmp_path: Path) -> None:
    (tmp_path / "data").write_text("not a folder")
    with pytest.raises(InputError, match="can't be written"), Store(tmp_path / "data").locked():
        pass


@pytest.mark.parametrize(
    ("name", "content", "found_without_checksums", "reason"),
    [
        ("a.txt", b"fir", True, "a.txt has 3 bytes, expected 5"),
        ("a.txt", b"firsT", False, "a.txt was changed"),
        ("drawings/0.png", None, True, "drawings/0.png is missing"),
        ("manifest.json", b"{", True, "manifest.json is missing or damaged"),
        ("manifest.json", None, True, "manifest.json is missing or damaged"),
    ],
)
def test_damage_is_found(
    store: Store, name: str, content: bytes | None, found_without_checksums: bool, reason: str
) -> None:
    write_shape(store, "cow")
    folder = store.view_folder(Item("cow", "0"))
    store.write_folder(folder, FILES, "m")
    (folder / name).unlink() if content is None else (folder / name).write_bytes(content)
    assert damage(folder, verify=True) == reason
    assert bool(damage(folder)) == found_without_checksums
    (row,) = store.statuses("cow", 1, {}, verify=True)
    assert (row.status, row.reason) == ("damaged", reason)


def test_the_state_is_what_lies_on_disk(store: Store) -> None:
    assert states(store, "cow") == [("pending", "not cleaned yet")]
    write_shape(store, "cow")
    assert states(store, "cow", 2) == [("pending", ""), ("pending", "")]
    store.write_folder(store.view_folder(Item("cow", "1")), FILES, MESH)
    store.record_problem(store.view_folder(Item("cow", "0")), "failed", "too strange", MESH)
    assert states(store, "cow", 2) == [("failed", "too strange"), ("done", "")]
    store.write_folder(store.view_folder(Item("cow", "0")), FILES, MESH)
    assert states(store, "cow", 2) == [("done", ""), ("done", "")]


def test_noted_damage_counts_until_the_folder_is_written_again(store: Store) -> None:
    write_shape(store, "cow")
    store.write_folder(store.view_folder(Item("cow", "0")), FILES, MESH)
    store.record_problem(store.view_folder(Item("cow", "0")), "damaged", "a.txt was changed", MESH)
    assert states(store, "cow") == [("damaged", "a.txt was changed")]
    store.write_folder(store.view_folder(Item("cow", "0")), FILES, MESH)
    assert states(store, "cow") == [("done", "")]
    store.record_problem(store.shape_folder("cow"), "damaged", "mesh.ply was changed", "source")
    assert states(store, "cow") == [("damaged", "shape: mesh.ply was changed")]
    assert store.shape_record("cow") is None


def test_a_folder_is_removed_as_a_whole(store: Store) -> None:
    store.write_folder(store.view_folder(Item("cow", "0")), FILES, MESH)
    store.remove_folder(store.view_folder(Item("cow", "0")))
    store.remove_folder(store.view_folder(Item("cow", "0")))
    assert not store.view_folder(Item("cow", "0")).exists()
    assert not list((store.root / ".tmp").iterdir())


def test_a_shape_that_was_not_cleaned_has_no_views(store: Store) -> None:
    write_shape(store, "soup", "failed", "loose triangles")
    write_shape(store, "tiny", "skipped", "12 faces")
    write_shape(store, "calf")
    store.duplicates_path.write_text(json.dumps({"duplicates": {"calf": {"of": "cow"}}}))
    assert states(store, "soup") == [("failed", "loose triangles")]
    assert states(store, "tiny") == [("skipped", "12 faces")]
    assert states(store, "calf") == [("skipped", "duplicate of cow")]


def test_a_damaged_shape_is_told(store: Store) -> None:
    write_shape(store, "cow")
    (store.shape_folder("cow") / "clean.json").write_text("{")
    assert states(store, "cow") == [("damaged", "shape: clean.json has 1 bytes, expected 32")]
    assert store.shape_record("cow") is None


def test_the_index_reads_back(store: Store) -> None:
    rows = [ViewStatus("cow", 0, "done", "", 1.25), ViewStatus("a, b", 1, "failed", 'said "no",\nand left')]
    store.write_index(rows)
    assert store.index_path.read_text().splitlines()[0] == "shape,view,status,reason,seconds"
    assert store.read_index() == rows


def test_an_index_with_other_columns_is_bad_input(store: Store) -> None:
    store.index_path.write_text("shape,view\ncow,0\n")
    with pytest.raises(InputError, match="columns"):
        store.read_index()


def test_leftovers_of_a_killed_build_are_swept_away(store: Store) -> None:
    (store.root / ".tmp" / "half").mkdir()
    (store.root / ".tmp" / "half" / "depth.png").write_bytes(b"half a pict")
    (store.root / ".tmp-index.csv").write_text("half a tab")
    with store.locked():
        assert not list((store.root / ".tmp").iterdir())
        assert not (store.root / ".tmp-index.csv").exists()


def write_often(root: Path, times: int, content: bytes) -> None:
    store = Store(root)
    for _ in range(times):
        store.write_folder(store.view_folder(Item("cow", "0")), {"a.txt": content, "b.txt": content}, "m")


def test_processes_that_finish_the_same_folder_at_the_same_time_do_not_fail(store: Store) -> None:
    context = multiprocessing.get_context("spawn")
    others = [context.Process(target=write_often, args=(store.root, 150, content)) for content in (b"one", b"three")]
    for other in others:
        other.start()
    for other in others:
        other.join()
    assert [other.exitcode for other in others] == [0, 0]
    assert damage(store.view_folder(Item("cow", "0")), verify=True) == ""
    assert not list((store.root / ".tmp").iterdir())


def test_whoever_lost_its_folder_to_a_sweep_puts_no_half_of_it_in_place(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    written = Path.write_bytes

    def swept_after_the_first(path: Path, data: bytes) -> int:
        count = written(path, data)
        if path.name == "a.txt":
            with store.locked():
                pass
        return count

    monkeypatch.setattr(Path, "write_bytes", swept_after_the_first)
    with pytest.raises(FileNotFoundError):
        store.write_folder(store.view_folder(Item("cow", "0")), FILES, "m")
    assert not store.view_folder(Item("cow", "0")).exists()


def test_a_folder_replaced_while_it_is_verified_is_not_taken_for_damaged(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = store.view_folder(Item("cow", "0"))
    store.write_folder(target, FILES, "m")
    replaced: list[bool] = []

    def replace_first(path: Path) -> str:
        if not replaced:
            replaced.append(True)
            store.write_folder(target, {"a.txt": b"FIRST", "drawings/0.png": b"SECOND"}, "m")
        return file_checksum(path)

    monkeypatch.setattr("dataset_tools.build.manifest.file_checksum", replace_first)
    assert damage(target, verify=True) == ""


@pytest.mark.parametrize(
    "manifest", ["{}", '{"from": "m", "files": {}}', '{"from": "m", "files": {"a.txt": 5}}', "[1]"]
)
def test_a_manifest_that_is_none_is_damage(store: Store, manifest: str) -> None:
    store.write_folder(store.view_folder(Item("cow", "0")), FILES, "m")
    (store.view_folder(Item("cow", "0")) / "manifest.json").write_text(manifest)
    assert damage(store.view_folder(Item("cow", "0"))) == "manifest.json is missing or damaged"


def test_a_view_of_another_mesh_is_out_of_date(store: Store) -> None:
    write_shape(store, "cow")
    store.write_folder(store.view_folder(Item("cow", "0")), FILES, "another mesh")
    store.record_problem(store.view_folder(Item("cow", "1")), "failed", "too strange", "another mesh")
    assert states(store, "cow", 2) == [("pending", "its mesh has changed"), ("pending", "")]


def hold(root: Path, held: "multiprocessing.synchronize.Event") -> None:
    with Store(root).locked():
        held.set()
        held.wait(60)
        multiprocessing.Event().wait(60)


def test_two_builds_do_not_share_a_folder_and_a_killed_one_lets_go(store: Store) -> None:
    context = multiprocessing.get_context("spawn")
    held = context.Event()
    other = context.Process(target=hold, args=(store.root, held))
    other.start()
    try:
        assert held.wait(60)
        with pytest.raises(InputError, match=f"another build is at work in it .process {other.pid} on"), store.locked():
            pass
    finally:
        other.kill()
        other.join()
    with store.locked():
        pass
