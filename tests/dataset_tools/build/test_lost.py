"""What is lost in the middle of a build: worker processes, the data folder, views."""

import shutil
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TypeVar

import pytest

from dataset_tools.build import build as building
from dataset_tools.build.build import Summary, folder_status
from dataset_tools.build.runners import HereRunner, Outcome
from dataset_tools.build.tasks import ShapeTask, clean_shape, make_views
from dataset_tools.build.worker_process import Limits
from ncmodel.cli.main import main
from ncmodel.errors import InputError
from tests.helpers.builds import CONFIG, build, contents

T = TypeVar("T")
R = TypeVar("R")
REASON = "its process died with signal SIGKILL (no message)"


class Interrupted(HereRunner):
    """Has something happen in place of one kind of work, or after it."""

    def __init__(self, kind: object, happens: Callable[[], None] | None = None, after: bool = False) -> None:
        self._kind, self._happens, self._after = kind, happens, after

    def run(self, function: Callable[[T], R], tasks: Sequence[T], limits: Limits) -> Iterator[Outcome[T, R]]:
        """As `HereRunner` does; of the kind without anything that happens, no process survives."""
        if function is self._kind and self._happens is None:
            yield from (Outcome(task, None, REASON, killed=True) for task in tasks)
            return
        if function is self._kind and self._happens and not self._after:
            self._happens()
        yield from super().run(function, tasks, limits)
        if function is self._kind and self._happens and self._after:
            self._happens()


@pytest.fixture(scope="module")
def ball(meshes: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of one mesh."""
    folder = tmp_path_factory.mktemp("ball")
    shutil.copy(meshes / "ball.ply", folder)
    return folder


@pytest.mark.parametrize("kind", [clean_shape, make_views])
def test_what_was_killed_is_tried_again(
    kind: object, reference: tuple[Path, Summary], meshes: Path, tmp_path: Path
) -> None:
    """Without `--retry`: nothing is known against these shapes."""
    folder = tmp_path / "data"
    first = build(meshes, folder, Interrupted(kind))
    assert (first.made, first.count("done"), first.count("failed")) == (0, 0, 0 if kind is clean_shape else 2)
    left = [row for row in folder_status(folder) if row.status == "pending"]
    assert len(left) == first.missing == (8 if kind is clean_shape else 4)
    assert {row.reason for row in left} == {REASON}
    again = build(meshes, folder)
    assert (again.made, again.missing) == (4, 0)
    assert contents(folder) == contents(reference[0])


@pytest.mark.parametrize(("kind", "after"), [(clean_shape, False), (make_views, False), (make_views, True)])
def test_a_folder_that_is_removed_ends_the_build(kind: object, after: bool, ball: Path, tmp_path: Path) -> None:
    folder = tmp_path / "data"
    with pytest.raises(InputError, match=f"{folder}.*(removed while it was being built|there is no folder)"):
        build(ball, folder, Interrupted(kind, lambda: shutil.rmtree(folder), after))
    assert not folder.exists()


def test_a_folder_that_another_one_replaced_ends_the_build(ball: Path, tmp_path: Path) -> None:
    folder = tmp_path / "data"

    def replace() -> None:
        shutil.move(folder, tmp_path / "elsewhere")
        shutil.copytree(tmp_path / "elsewhere", folder)

    with pytest.raises(InputError, match="removed while it was being built"):
        build(ball, folder, Interrupted(make_views, replace, after=True))


def test_views_that_are_not_there_in_the_end_are_no_success(
    ball: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "data"

    def make_and_lose(task: ShapeTask) -> object:
        rows = make_views(task)
        shutil.rmtree(folder / "views")
        (folder / "views").mkdir()
        return rows

    monkeypatch.setattr(building, "make_views", make_and_lose)
    (tmp_path / "settings.toml").write_text(
        f"width = {CONFIG.width}\nheight = {CONFIG.height}\nrender_size = 32\nmin_faces = 100\n"
    )
    command = ["dataset", "build", str(ball), str(folder), "--config", str(tmp_path / "settings.toml")]
    assert main([*command, "--workers", "0"]) == 1
    assert "2 views are still to be made, reasons in" in capsys.readouterr().err
