"""What the site is started with: its token, settings and files; where it listens."""

import json
import re
import shutil
import socket
import sqlite3
import stat
import subprocess
import sys
import urllib.error
import urllib.parse
import urllib.request
from pathlib import Path

import pytest

from dataset_tools.site.database import Policy
from dataset_tools.site.participant_pages import Settings
from dataset_tools.site.server import (
    SiteFiles,
    _listening,
    _open_files,
    make_app,
    read_consent,
    read_token,
    site_parameters,
)
from ncmodel.errors import InputError, UsageError


def test_tokens_are_made_private_and_refused_when_short(tmp_path: Path) -> None:
    token = read_token(tmp_path / "token")
    assert len(token) >= 24
    assert read_token(tmp_path / "token") == token
    assert stat.S_IMODE((tmp_path / "token").stat().st_mode) == 0o600
    (tmp_path / "short").write_text("abc")
    with pytest.raises(UsageError, match="expected 16 or more"):
        read_token(tmp_path / "short")


def test_settings_are_checked(tmp_path: Path) -> None:
    assert site_parameters("a, b_1") == ("a", "b_1")
    with pytest.raises(UsageError, match=r"^parameters: found 'a b'"):
        site_parameters("a b")
    (tmp_path / "empty").write_text("\n")
    with pytest.raises(InputError, match="no text"):
        read_consent(tmp_path / "empty")


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("completion_url", "javascript:alert(1)"),
        ("completion_url", "//evil.example/{code}"),
        ("completion_url", "http://[x"),
        ("public_url", "http://[x"),
        ("public_url", "https://host/path"),
    ],
)
def test_addresses_that_are_none_of_the_web_are_refused(name: str, value: str) -> None:
    with pytest.raises(UsageError, match=f"^{name}: found"):
        Settings(**{name: value})  # type: ignore[arg-type]


def test_connections_answer_without_waiting_for_receipts() -> None:
    with _listening("127.0.0.1", 0) as listener, socket.create_connection(listener.getsockname()):
        connection, _ = listener.accept()
        with connection:
            assert connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


def test_after_sigterm_the_database_file_is_whole(batch: Path, tmp_path: Path) -> None:
    """A copy of the file alone holds all, and the exit is no failure."""
    db = tmp_path / "votes.sqlite"
    command = [sys.executable, "-m", "ncmodel.cli.main", "crowd", "serve", str(batch), "--db", str(db), "--port", "0"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr
        base = re.search(r"http://[\d.:]+", process.stderr.readline())
        assert base
        body = urllib.parse.urlencode({"PROLIFIC_PID": "anna", "agree": "yes"}).encode()
        with pytest.raises(urllib.error.HTTPError, match="403"):  # begun, and without its cookie not let in
            urllib.request.urlopen(f"{base[0]}/start", body, timeout=60)
        assert Path(f"{db}-wal").stat().st_size
        process.terminate()
        assert process.wait(60) == 0
    assert not Path(f"{db}-wal").exists()
    shutil.copy(db, tmp_path / "copy.sqlite")
    with sqlite3.connect(tmp_path / "copy.sqlite") as copy:
        assert copy.execute("SELECT worker FROM participants").fetchall() == [("anna",)]


def test_where_it_listens_as_json(batch: Path, tmp_path: Path) -> None:
    """A program learns the port, the link and the token's file; a key that others can read is complained of."""
    copy = tmp_path / "batch"
    shutil.copytree(batch, copy)
    (copy / "key.json").chmod(0o644)
    command = [sys.executable, "-m", "ncmodel.cli.main", "crowd", "serve", str(copy), "--db", str(tmp_path / "db")]
    with subprocess.Popen([*command, "--port", "0", "--json"], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        lines: list[str] = []
        while not lines or lines[-1] != "}\n":
            lines.append(process.stdout.readline())
        process.terminate()
    found = json.loads("".join(lines))
    assert found["participants"] == f"http://127.0.0.1:{found['port']}/?PROLIFIC_PID=...&STUDY_ID=...&SESSION_ID=..."
    assert found["requester"].endswith("/admin")
    assert Path(found["token"]).read_text().strip()
    assert any("chmod 600" in note for note in found["notes"])


def test_files_that_others_can_open_are_told(batch: Path, tmp_path: Path) -> None:
    files = SiteFiles(shutil.copytree(batch, tmp_path / "batch"), tmp_path / "db", tmp_path / "token")
    made, store = make_app(files, Settings(), Policy())
    assert made.routes
    store.close()
    (files.batch_dir / "key.json").chmod(0o600)
    assert list(_open_files(files)) == []
    for path in (files.batch_dir / "key.json", files.database, files.token):
        path.chmod(0o640)
        assert [str(path) in note for note in _open_files(files)] == [True]
        path.chmod(0o600)
