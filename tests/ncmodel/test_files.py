"""Files that are written whole: through links and into pipes, with the permissions of what they replace."""

import os
import signal
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from ncmodel.errors import InputError
from ncmodel.files import atomic, check_writable, write_bytes, write_text


def test_write_replaces_what_a_link_leads_to(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    target, link = tmp_path / "real" / "votes.csv", tmp_path / "votes.csv"
    link.symlink_to(target)
    for text in ("first", "second"):  # the link dangles before the first
        write_text(link, text)
        assert link.is_symlink()
        assert target.read_text() == text
    assert os.listdir(target.parent) == ["votes.csv"]


def test_write_goes_into_a_pipe(tmp_path: Path) -> None:
    pipe, got = tmp_path / "out.svg", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()), daemon=True)
    reader.start()
    data = bytes(range(256)) * 1000  # more than a pipe holds
    write_bytes(pipe, data)
    reader.join(10)
    assert got == [data]
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert os.listdir(tmp_path) == ["out.svg"]


def test_devices_and_folders_are_refused(tmp_path: Path) -> None:
    (tmp_path / "null.csv").symlink_to(os.devnull)
    for path, found in ((os.devnull, "a device"), (tmp_path / "null.csv", "a device"), (tmp_path, "a folder")):
        for write in (check_writable, lambda path: write_text(path, "votes")):
            with pytest.raises(InputError, match=found):
                write(path)
    assert stat.S_ISCHR(os.stat(os.devnull).st_mode)


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o444])
def test_a_replaced_file_keeps_its_permissions(tmp_path: Path, mode: int) -> None:
    votes = tmp_path / "votes.csv"
    votes.write_text("before")
    votes.chmod(mode)
    write_text(votes, "after")
    assert votes.read_text() == "after"
    assert stat.S_IMODE(votes.stat().st_mode) == mode


def test_a_new_file_gets_the_usual_permissions(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        write_text(tmp_path / "new.csv", "votes")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "new.csv").stat().st_mode) == 0o640


_WRITER = """
import sys
from ncmodel.files import atomic
with atomic(sys.argv[1]) as aside:
    aside.write_text("private votes")
    print(aside, flush=True)
    sys.stdin.read()
"""


def test_the_next_process_removes_what_a_killed_one_left(tmp_path: Path) -> None:
    votes, foreign = tmp_path / "votes.csv", tmp_path / ".tmp-of-somebody-else"
    foreign.write_text("kept")
    writer = subprocess.Popen(
        [sys.executable, "-c", _WRITER, str(votes)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    with writer:
        assert writer.stdout is not None
        left = Path(writer.stdout.readline().strip())
        writer.send_signal(signal.SIGKILL)
    assert left.parent == tmp_path
    assert left.exists()
    assert stat.S_IMODE(left.stat().st_mode) == 0o600
    with atomic(votes) as being_written:
        assert not left.exists()
        # A process that starts now leaves what is being written alone.
        command = "import sys; from ncmodel.files import write_text; write_text(sys.argv[1], 'theirs')"
        subprocess.run([sys.executable, "-c", command, str(tmp_path / "theirs.csv")], check=True)
        assert being_written.exists()
        being_written.write_text("ours")
    assert sorted(os.listdir(tmp_path)) == [foreign.name, "theirs.csv", "votes.csv"]
