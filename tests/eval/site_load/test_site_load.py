"""The measurement of the site: it counts what was lost, and a small crowd loses nothing while the site is killed."""

import json
import shutil
import signal
import sqlite3
from pathlib import Path

import pytest

from dataset_tools.questionnaires.batch import make_batch
from dataset_tools.questionnaires.batch_folder import Look
from dataset_tools.questionnaires.questionnaire import Scheme
from dataset_tools.questionnaires.sentinels import ArtistsFolder
from eval.site_load.__main__ import SIGNALS, Trial, count_lost, run_trial, table
from eval.site_load.participants import Record
from ncmodel.data.data_folder import DataFolder
from tests.helpers.crowd_data import make_artists, make_data

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def batch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("load")
    data = make_data(folder / "data", shapes=8, views=1)
    artists = make_artists(folder / "artists", data)
    needs = dict.fromkeys(DataFolder(data).items(), 2)
    make_batch(data, folder / "batch", needs, Scheme(real=4, sentinels=2, pool=4), Look(32, 32), ArtistsFolder(artists))
    return folder / "batch"


def test_what_the_database_lacks_is_counted(tmp_path: Path) -> None:
    with sqlite3.connect(tmp_path / "db") as db:
        db.execute("CREATE TABLE participants (id, worker, state)")
        db.execute("CREATE TABLE answers (participant, field, value)")
        db.execute("INSERT INTO participants VALUES ('a', 'anna', 'finished'), ('b', 'ben', 'active')")
        db.execute("INSERT INTO answers VALUES ('a', 'q01', 'x'), ('b', 'q01', 'y')")
    kept = Record("anna", {"q01": "x"}, finished=True)
    assert count_lost([kept], tmp_path / "db") == 0
    assert count_lost([kept, Record("ben", {"q01": "y", "q02": "z"})], tmp_path / "db") == 1
    assert count_lost([kept, Record("ben", {"q01": "x"}, finished=True)], tmp_path / "db") == 2


def test_a_small_crowd_loses_nothing(batch: Path) -> None:
    done = run_trial(batch, Trial(4, silent=20, signals=(signal.SIGKILL,), behind_nginx=False), ROOT)
    assert (done.finished, done.acknowledged, done.lost) == (4, 4 * 6, 0)
    assert done.errors, "the site was away"
    assert "4 answering, 20 silent, SIGKILL" in table([done])


@pytest.mark.slow
def test_two_hundred_behind_nginx_lose_nothing(batch: Path) -> None:
    if not shutil.which("nginx"):
        pytest.skip("needs nginx: apt-get install nginx-light")
    done = run_trial(batch, Trial(200, silent=1000, signals=SIGNALS), ROOT)
    assert (done.finished, done.acknowledged, done.lost) == (200, 200 * 6, 0), json.dumps(done.errors)
