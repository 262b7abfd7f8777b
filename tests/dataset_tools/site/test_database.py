"""The database hands out each place once, takes back what was abandoned, and is private."""

import stat
import threading
from pathlib import Path

import pytest
from starlette.applications import Starlette

from dataset_tools.site.database import Policy, Refusal, SiteStore, State
from ncmodel.errors import InputError
from tests.helpers.site_client import Clock, begin


def test_abandoned_questionnaires_return(tmp_path: Path) -> None:
    clock = Clock()
    store = SiteStore(tmp_path / "db", ["a"], Policy(abandoned_after=60), clock)
    first = store.begin("anna", {})
    assert store.begin("ben", {}) is Refusal.FULL
    clock.now += 61
    second = store.begin("ben", {})
    assert isinstance(second, str)
    assert not isinstance(second, Refusal)
    lost = store.find(first)
    assert lost is not None
    assert lost.state is State.ABANDONED
    assert not store.save(lost.id, {"q01": ("x", 1.0)})
    clock.now += 61
    back = store.find(first)
    assert back is not None
    assert back.state is State.ABANDONED, "ben was only just not seen: his place isn't given up before somebody asks"
    assert [entry.state for entry in store.assignments()] == [State.ABANDONED, State.ABANDONED]
    back = store.find(first)
    assert back is not None
    assert back.state is State.ACTIVE, "the place is free again"
    store.close()


def test_unreliable_participants_can_be_replaced(tmp_path: Path) -> None:
    for replace, expected in ((False, True), (True, False)):
        store = SiteStore(tmp_path / f"db{replace}", ["a"], Policy(replace_unreliable=replace), Clock())
        entry = store.find(store.begin("anna", {}))
        assert entry is not None
        assert store.finish(entry.id, lambda answers: False)
        assert (store.begin("ben", {}) is Refusal.FULL) is expected
        store.close()


def test_the_database_holds_no_secret_and_is_private(site: Starlette, tmp_path: Path) -> None:
    client = begin(site, "anna")
    secret = client.cookies["nc_session"]
    dump = b"".join(path.read_bytes() for path in tmp_path.glob("votes.sqlite*"))
    assert secret.encode() not in dump
    assert stat.S_IMODE((tmp_path / "votes.sqlite").stat().st_mode) == 0o600


def test_a_database_of_another_batch_or_none_is_refused(tmp_path: Path) -> None:
    SiteStore(tmp_path / "db", ["a", "b"], Policy(), Clock()).close()
    with pytest.raises(InputError, match="answers to another batch"):
        SiteStore(tmp_path / "db", ["c"], Policy(), Clock())
    (tmp_path / "text").write_text("this is no database, and long enough not to be taken for an empty one")
    with pytest.raises(InputError, match="database"):
        SiteStore(tmp_path / "text", ["a"], Policy(), Clock())


def test_concurrent_starts_never_share_a_place(tmp_path: Path) -> None:
    store = SiteStore(tmp_path / "db", [f"q{i}" for i in range(20)], Policy(), Clock())
    found: list[str | Refusal] = []
    threads = [threading.Thread(target=lambda i=i: found.append(store.begin(f"w{i % 30}", {}))) for i in range(60)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    entries = store.assignments()
    assert len(entries) == 20
    assert len({entry.questionnaire for entry in entries}) == 20
    assert len({entry.worker for entry in entries}) == 20
    assert sum(isinstance(one, Refusal) for one in found) == 20, "ten workers found no place, twice"
    store.close()
