"""What the site is started with: its token, settings and files; where it listens."""

import json
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from dataset_tools.site.server import read_consent, read_token, site_parameters
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
