"""Drawings that are the same picture count as one, from the questionnaire to the ranking pairs."""

import csv
import json
import shutil
from collections import Counter
from pathlib import Path

import pytest

from dataset_tools.questionnaires.batch import make_batch
from dataset_tools.questionnaires.batch_folder import Look
from dataset_tools.questionnaires.identical_drawings import (
    ALL_DIFFERENT,
    distinct,
    find_twins,
    from_record,
    from_text,
    item_twins,
    items_to_ask_about,
    to_record,
    to_text,
)
from dataset_tools.questionnaires.questionnaire import Key, Scheme
from dataset_tools.questionnaires.sentinels import ArtistsFolder
from dataset_tools.simulation.crowd import simulate_batch
from dataset_tools.simulation.participants import Crowd
from dataset_tools.votes.agreement import agreeing_share, krippendorff_alpha
from dataset_tools.votes.consensus import Rules, aggregate
from dataset_tools.votes.dawid_skene import one_coin
from dataset_tools.votes.ingest import ingest_results, top_up_needs
from dataset_tools.votes.votes import read_votes, to_frame
from ncmodel.cli.main import main
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.errors import InputError
from tests.helpers.crowd_data import make_artists, make_data, vote

PAIRED = (0, 1, 2, 3, 0, 1, 2, 3)
"""Four different drawings, each shown twice."""

CROWD = Crowd(noise=3.0, far=1.0, random_clickers=0.0, slip=0.0)
"""Participants who hardly see which drawing is nearer, and never fail a sentinel."""


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four views, of which one has four different drawings and one a single one."""
    data = make_data(tmp_path_factory.mktemp("twins") / "data", shapes=4, views=1)
    for name, first in (("shape_0_0", (0, 1, 2, 3)), ("shape_1_0", (0, 0, 0, 0))):
        drawings = data / "views" / name / "drawings"
        for index in range(8):
            if first[index % 4] != index:
                shutil.copy(drawings / f"{first[index % 4]}.png", drawings / f"{index}.png")
    return data


def test_twins_are_found_by_their_pictures(data: Path, tmp_path: Path) -> None:
    assert item_twins(DataFolder(data), Item("shape_0", "0")) == PAIRED
    assert item_twins(DataFolder(data), Item("shape_1", "0")) == (0,) * 8
    assert item_twins(DataFolder(data), Item("shape_2", "0")) == ALL_DIFFERENT
    assert distinct(PAIRED) == [0, 1, 2, 3]
    (tmp_path / "0.png").write_bytes(b"a")
    with pytest.raises(InputError, match=r"1\.png: can't be read"):
        find_twins([tmp_path / "0.png", tmp_path / "1.png"])


def test_twins_in_files() -> None:
    for twins, text in ((PAIRED, "4=0 5=1 6=2 7=3"), (ALL_DIFFERENT, "")):
        assert to_text(twins) == text
        assert from_text(text) == twins
        assert from_record(json.loads(json.dumps(to_record(twins)))) == twins
    for wrong in ("0=4", "3=3", "9=0", "4=0 5=4", "x=0", "4", "4=-1", "=", "-1=0"):
        with pytest.raises(ValueError, match=r"."):
            from_text(wrong)


def test_a_view_with_one_drawing_is_not_asked_about(data: Path) -> None:
    assert len(DataFolder(data).items()) == 4
    assert items_to_ask_about(DataFolder(data)) == [Item(f"shape_{number}", "0") for number in (0, 2, 3)]


def test_where_no_view_has_a_choice_there_is_nothing_to_ask(tmp_path: Path) -> None:
    data = make_data(tmp_path / "data", shapes=1, views=1)
    drawings = data / "views/shape_0_0/drawings"
    for index in range(1, 8):
        shutil.copy(drawings / "0.png", drawings / f"{index}.png")
    with pytest.raises(InputError, match="the eight drawings of every view are one"):
        items_to_ask_about(DataFolder(data))


def test_a_vote_for_either_twin_counts_for_both() -> None:
    votes = [vote(f"w{i}", "shape", choice, twins=PAIRED) for i, choice in enumerate((5, 1, 2))]
    verdict = aggregate(to_frame(votes), Rules()).verdicts[0]
    assert (verdict.votes, verdict.best, verdict.others) == ({1: 2, 2: 1}, 1, [0, 2, 3])
    apart = to_frame(vote(v.worker, "shape", v.choice) for v in votes)
    assert aggregate(apart, Rules()).verdicts[0].best is None


def test_no_pair_is_made_of_twins_and_none_twice() -> None:
    votes = [vote(f"w{i}", "shape", choice, twins=PAIRED) for i, choice in enumerate((5, 1, 5))]
    found = aggregate(to_frame(votes), Rules())
    assert [(pair.better, pair.worse) for pair in found.pairs()] == [(1, 0), (1, 2), (1, 3)]
    assert found.summary()["pairs"] == 3
    assert all(pair.votes_for == 3 for pair in found.pairs())


def test_agreement_takes_twins_as_one() -> None:
    places = [(w, s) for w in range(2) for s in range(8)]
    votes = to_frame(vote(f"w{w}", f"s{s}", s % 4 + 4 * (w % 2), twins=PAIRED) for w, s in places)
    assert krippendorff_alpha(votes) == pytest.approx(1.0)
    assert agreeing_share(votes) == {"w0": (8, 8), "w1": (8, 8)}


def test_one_coin_spreads_errors_over_what_there_is() -> None:
    """Closed form for one unanimous item: the odds of right against each of 4 wrong choices, not 8."""
    votes = [vote(f"w{w}", "shape", choice, twins=PAIRED) for w, choice in enumerate((3, 7, 3))]
    belief = one_coin(to_frame(votes))[Item("shape", "0")].probabilities
    right = float(belief[4])
    accuracy = (right + 4) / (1 + 6)
    odds = (accuracy / ((1 - accuracy) / 4)) ** 3
    assert right == pytest.approx(odds / (odds + 4), abs=1e-6)
    assert belief[5:].sum() == 0.0, "drawings that repeat earlier ones can't be right on their own"


def test_twins_from_data_to_pairs(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    small = ["--drawing-side", "32", "--render-side", "32", "--sentinels", "2", "--pool", "3"]
    assert main(["crowd", "build", str(data), str(tmp_path / "b"), *small]) == 0
    assert "not asked about 1 view" in capsys.readouterr().err
    key = Key.load(tmp_path / "b")
    twins = {q.item: q.twins for one in key.questionnaires.values() for q in one.questions if not q.sentinel}
    assert twins[Item("shape_0", "0")] == PAIRED
    assert twins[Item("shape_2", "0")] == ALL_DIFFERENT
    simulate_batch(tmp_path / "b", tmp_path / "r.csv", CROWD, participants=30)
    ingest_results(tmp_path / "b", [tmp_path / "r.csv"], tmp_path / "v.csv")
    votes = read_votes(tmp_path / "v.csv")
    chosen = Counter(votes[(votes["shape"] == "shape_0") & (votes["view"] == "0") & ~votes["sentinel"]]["choice"])
    assert max(chosen) > 3, "votes keep what was clicked"
    found = aggregate(votes, Rules(least=1))
    verdict = next(verdict for verdict in found.verdicts if verdict.item == Item("shape_0", "0"))
    assert max(verdict.votes) <= 3
    assert verdict.total == sum(chosen.values())
    assert Item("shape_1", "0") not in top_up_needs(data, tmp_path / "v.csv", 99)


def test_stand_ins_of_a_sentinel_are_different_pictures(data: Path, tmp_path: Path) -> None:
    items, artists = items_to_ask_about(DataFolder(data)), make_artists(tmp_path / "artists", data)
    for item in items:
        shutil.copy(artists / item.name / "0.png", artists / item.name / "1.png")
    scheme = Scheme(real=1, sentinels=1, pool=2)
    make_batch(data, tmp_path / "b", dict.fromkeys(items, 9), scheme, Look(64, 64), ArtistsFolder(artists))
    key = Key.load(tmp_path / "b")
    with (tmp_path / "b/tasks.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    asked = [(row, question) for row in rows for question in key.questionnaires[row["questionnaire"]].questions]
    assert any(question.sentinel for _, question in asked)
    for row, question in asked:
        shown = [(tmp_path / "b" / row[f"{question.field}_d{place}"]).read_bytes() for place in range(1, 9)]
        assert len(set(shown)) == len(distinct(question.twins))


def test_votes_without_the_column_have_no_twins(tmp_path: Path) -> None:
    header = "worker,assignment,questionnaire,question,shape,view,choice,sentinel,passed,seconds,source"
    (tmp_path / "v.csv").write_text(f"{header}\nw,a,q,1,s,0,3,0,,,mturk\n")
    assert read_votes(tmp_path / "v.csv")["twins"].tolist() == [""]
    (tmp_path / "w.csv").write_text(f"{header},twins\nw,a,q,1,s,0,3,0,,,mturk,7=9\n")
    with pytest.raises(InputError, match=r"row 2: twins is '7=9'"):
        read_votes(tmp_path / "w.csv")
