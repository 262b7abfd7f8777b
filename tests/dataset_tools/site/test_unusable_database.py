"""A database that can't be used is told by what is in the way: a lock, permissions, or that it is something else."""

import sqlite3
from pathlib import Path

import pytest

from dataset_tools.site.database import Policy, SiteStore
from dataset_tools.votes.results_sqlite import read_site_results, unusable_database
from ncmodel.errors import InputError
from tests.helpers.site_client import Clock


@pytest.fixture
def database(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for module in ("dataset_tools.site.database", "dataset_tools.votes.results_sqlite"):
        monkeypatch.setattr(f"{module}.LOCK_SECONDS", 0.05)
    path = tmp_path / "site.sqlite"
    SiteStore(path, ["a"], Policy(), Clock()).close()
    return path


@pytest.mark.parametrize("mode", ["NORMAL", "EXCLUSIVE"])
def test_a_locked_database_is_in_use(database: Path, mode: str) -> None:
    other = sqlite3.connect(database, isolation_level=None)
    other.execute(f"PRAGMA locking_mode = {mode}")
    other.execute("BEGIN EXCLUSIVE")
    try:
        with pytest.raises(InputError, match=r"in use \(database is locked\)"):
            SiteStore(database, ["a"], Policy(), Clock())
        if mode == "EXCLUSIVE":  # else reading goes on beside the lock
            with pytest.raises(InputError, match=r"in use \(database is locked\)"):
                list(read_site_results(database))
    finally:
        other.close()
    SiteStore(database, ["a"], Policy(), Clock()).close()


def test_a_read_only_database_is_none_to_write_to(database: Path) -> None:
    read_only = sqlite3.connect(f"{database.as_uri()}?mode=ro", uri=True)
    with pytest.raises(sqlite3.OperationalError) as raised:
        read_only.execute("INSERT INTO meta VALUES ('a', 'b')")
    assert "may be read and written" in str(unusable_database(database, raised.value))
    read_only.close()


def test_something_else_is_no_database(database: Path) -> None:
    database.write_text("neither SQLite nor anything else" * 100)
    with pytest.raises(InputError, match="no site's database"):
        SiteStore(database, ["a"], Policy(), Clock())
