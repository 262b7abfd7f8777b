"""Simulated participants: plausible artists, choices near them, and the word 'simulated' everywhere."""

import csv
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from dataset_tools.questionnaires.batch import make_batch
from dataset_tools.questionnaires.batch_folder import Look
from dataset_tools.questionnaires.questionnaire import NONE, Question, Scheme
from dataset_tools.simulation.adversaries import KINDS
from dataset_tools.simulation.artists import ArtistDrawings, crowd_artists
from dataset_tools.simulation.crowd import SimulatedArtists, sample_distances, simulate_batch
from dataset_tools.simulation.participants import Crowd, attentive, distances_between, make_crowd
from dataset_tools.simulation.rule_trial import run_trial
from dataset_tools.simulation.rule_trial_report import as_text, write_trial
from dataset_tools.votes.approvals import write_review
from dataset_tools.votes.audit import audit, write_audit
from dataset_tools.votes.careless_responding import flags
from dataset_tools.votes.consensus import Rules, aggregate
from dataset_tools.votes.ingest import ingest_results, top_up_needs
from dataset_tools.votes.reliability import assess
from dataset_tools.votes.votes import read_votes, to_frame
from ncmodel.data.data_folder import DataFolder
from ncmodel.data.item import Item
from ncmodel.errors import InputError, UsageError
from ncmodel.types import Floats
from tests.helpers.crowd_data import make_data, scribble

LENIENT = Crowd(noise=0.02, far=1.0, random_clickers=0.3)
"""The fixture's candidates are scribbles: far from what any artist draws."""


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_data(tmp_path_factory.mktemp("simulated") / "data", shapes=4, views=2)


@pytest.fixture(scope="module")
def answered(data: Path) -> Path:
    """A batch of the data folder, answered by simulated participants, ingested."""
    folder = data.parent / "run"
    folder.mkdir()
    scheme = Scheme(real=6, sentinels=2, pool=4)
    make_batch(
        data, folder / "batch", dict.fromkeys(DataFolder(data).items(), 3), scheme, Look(32, 32), SimulatedArtists(data)
    )
    simulate_batch(folder / "batch", folder / "results.csv", LENIENT, participants=12, seed=1)
    ingest_results(folder / "batch", [folder / "results.csv"], folder / "votes.csv")
    return folder


def test_drawings_are_kept_and_said_to_be_simulated(data: Path) -> None:
    drawings = ArtistDrawings(DataFolder(data), crowd_artists(2))
    item = DataFolder(data).items()[0]
    paths = drawings.paths(item)
    assert [path.name for path in paths] == ["0.png", "1.png"]
    assert "simulated" in paths[0].parts
    before = paths[0].stat().st_mtime_ns
    assert drawings.paths(item)[0].stat().st_mtime_ns == before
    assert drawings.inks(item)[0].shape == (96, 96)
    for other in (crowd_artists(2, seed=9), crowd_artists(2, kind="frugal")):
        assert ArtistDrawings(DataFolder(data), other).folder != drawings.folder, "other tastes, other drawings"
    with pytest.raises(InputError):
        drawings.paths(Item("nobody", "0"))


def test_distances_are_symmetric_chamfer_in_shares_of_the_side() -> None:
    blank = np.zeros((768, 768), dtype=np.float32)
    lines = []
    for column in (100, 140):
        ink = blank.copy()
        ink[:, column : column + 4] = 1.0
        lines.append(ink)
    found = distances_between(lines, [*lines, blank])
    assert found[0, 0] == 0.0
    assert found[0, 1] == pytest.approx(40 / 768, abs=2 / 768)
    assert found[0, 1] == pytest.approx(found[1, 0])
    assert found[0, 2] == pytest.approx(np.sqrt(2), abs=1e-6)


def question(sentinel: bool = False) -> Question:
    return Question("q01", Item("s", "0"), sentinel, {f"v{i}": i for i in (3, 1, 0, 2, 7, 5, 6, 4)})


def near(best: int, far: float = 0.02) -> Callable[[Item], Floats]:
    distance = np.full((1, 8), far)
    distance[0, best] = 0.0005
    return lambda item: distance


def test_attentive_participants_choose_what_is_near() -> None:
    rng = np.random.default_rng(0)
    sharp = attentive(Crowd(noise=0.01, slip=0.0), near(6), 0)
    assert {sharp(question(), i, rng).value for i in range(50)} == {"v6"}
    blurred = attentive(Crowd(noise=1.5, slip=0.0), near(6), 0)
    found = Counter(blurred(question(), i, rng).value for i in range(400))
    assert found.most_common(1)[0][0] == "v6"
    assert len(found) > 3
    assert {sharp(question(sentinel=True), i, rng).value for i in range(50)} == {"v0"}


def test_attentive_participants_find_nothing_good_where_all_are_far() -> None:
    answer = attentive(Crowd(noise=0.1, slip=0.0), lambda item: np.full((1, 8), 0.2), 0)
    assert {answer(question(), i, np.random.default_rng(i)).value for i in range(20)} == {NONE}


def test_the_stated_share_clicks_at_random() -> None:
    people = make_crowd(200, Crowd(random_clickers=0.15), near(0), 1, np.random.default_rng(0))
    assert Counter(person.kind for person in people) == {"attentive": 170, "random clicker": 30}
    assert all(person.name.startswith("simulated") for person in people)
    with pytest.raises(UsageError, match=r"^random_clickers: found"):
        Crowd(random_clickers=1.5)


def test_everything_says_that_it_is_simulated(answered: Path, tmp_path: Path) -> None:
    with (answered / "results.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 12
    assert all("simulated" in row["WorkerId"] + row["RequesterAnnotation"] for row in rows)
    votes = read_votes(answered / "votes.csv")
    assert set(votes["source"]) == {"simulated"}
    found = aggregate(votes, Rules())
    assert found.summary()["simulated"] is True
    assert {pair.source for pair in found.pairs()} == {"simulated"}
    write_audit(audit(votes, Rules()), tmp_path / "audit.html", None)
    assert "simulated" in (tmp_path / "audit.html").read_text()


def test_random_clickers_are_excluded_and_their_items_topped_up(answered: Path, data: Path, tmp_path: Path) -> None:
    votes = read_votes(answered / "votes.csv")
    people = assess(votes)
    assert 3 <= sum(not person.reliable for person in people.values()) <= 5
    needs = top_up_needs(data, answered / "votes.csv", 20)
    good = [worker for worker, person in people.items() if person.reliable]
    asked = votes[~votes["sentinel"] & votes["worker"].isin(good)]
    have = Counter(map(Item, asked["shape"], asked["view"]))
    assert needs == {item: 20 - have[item] for item in DataFolder(data).items()}
    scheme, artists = Scheme(real=6, sentinels=2, pool=4), SimulatedArtists(data)
    built = make_batch(data, tmp_path / "more", needs, scheme, Look(16, 16), artists, fill=False)
    assert built.spare_votes < built.questionnaires


def test_a_batch_is_answered_until_everybody_who_counts_is_reliable(answered: Path, tmp_path: Path) -> None:
    done = simulate_batch(answered / "batch", tmp_path / "r.csv", Crowd(random_clickers=0.4), seed=3)
    ingest_results(answered / "batch", [tmp_path / "r.csv"], tmp_path / "v.csv")
    people = assess(read_votes(tmp_path / "v.csv"))
    assert sum(person.reliable for person in people.values()) == done["questionnaires"]
    assert len(people) == done["simulated_participants"]


def test_same_seed_same_answers(answered: Path, tmp_path: Path) -> None:
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        simulate_batch(answered / "batch", tmp_path / name, LENIENT, participants=12, seed=seed)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes() == (answered / "results.csv").read_bytes()
    assert (tmp_path / "a").read_bytes() != (tmp_path / "c").read_bytes()


def test_audit_shows_contested_items(answered: Path, data: Path, tmp_path: Path) -> None:
    found = audit(read_votes(answered / "votes.csv"), Rules())
    write_audit(found, tmp_path / "audit.html", data)
    text = (tmp_path / "audit.html").read_text()
    assert text.count("data:image/png") % 9 == 0
    assert "http://" not in text.replace("http://www.w3.org", "")
    summary = found.summary()
    assert summary["alpha"] is None or -1 <= float(str(summary["alpha"])) <= 1
    assert sum(found.bias.counts) <= len(found.kept)


def test_review_approves_and_rejects(answered: Path, tmp_path: Path) -> None:
    people = assess(read_votes(answered / "votes.csv"))
    counts = write_review(answered / "results.csv", people, tmp_path / "review.csv")
    assert counts["unknown"] == 0
    with (tmp_path / "review.csv").open() as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        reliable = people[row["WorkerId"]].reliable
        assert (row["Approve"] == "X", bool(row["Reject"])) == (reliable, not reliable)
        assert "sentinel" not in row["Reject"]
    with (answered / "results.csv").open() as file:
        before = list(csv.DictReader(file))
    assert [row["Answer.q01"] for row in rows] == [row["Answer.q01"] for row in before]


@pytest.fixture(scope="module")
def known() -> Floats:
    rng = np.random.default_rng(0)
    base = np.exp(rng.normal(-6, 0.5, (20, 1, 8)))
    return np.asarray(base * np.exp(rng.normal(0, 0.15, (20, 3, 8))))


def test_a_trial_tells_whom_the_rules_keep(known: Floats, tmp_path: Path) -> None:
    found = run_trial(known, Crowd(), participants=100, adversaries=2, seed=0)
    kinds = {kind.kind: kind for kind in found.kinds}
    assert set(KINDS) < set(kinds)
    assert (kinds["attentive"].participants, kinds["random clicker"].participants) == (85, 15)
    assert kinds["attentive"].excluded <= 5
    for kind in ("random clicker", "always first", "always none", "straight-liner", "scripted", "quitter"):
        assert kinds[kind].excluded == kinds[kind].participants, kind
    assert kinds["copy by a second account"].excluded == 0
    assert kinds["copy by a second account"].excluded_strict == 2
    rules = {rule.rule: rule for rule in found.rules}
    everything, paper = rules["all votes, majority"], rules["the paper's rule"]
    assert paper.right > everything.right
    assert paper.pairs_right > everything.pairs_right > paper.right
    assert paper.wrongly_kept < everything.wrongly_kept
    assert rules["only those who look"].right > everything.right
    write_trial(found, tmp_path / "trial.html")
    assert "simulated" in (tmp_path / "trial.html").read_text()
    assert len(as_text(found).splitlines()) == len(found.kinds) + len(found.rules) + 3
    assert run_trial(known, Crowd(), 100, 2, 0) == found


def test_honest_participants_are_rarely_flagged(known: Floats) -> None:
    found = run_trial(known, Crowd(random_clickers=0.0), participants=150, adversaries=0, seed=1)
    (honest,) = found.kinds
    assert honest.excluded_strict - honest.excluded <= 2


def test_distances_are_sampled_from_a_data_folder(data: Path) -> None:
    assert sample_distances(data, 3, seed=0).shape == (3, 5, 8)


def test_flags_say_what_was_seen(answered: Path) -> None:
    assert all(signs for signs in flags(read_votes(answered / "votes.csv")).values())
    assert flags(to_frame([])) == {}


def test_a_scribble_is_no_participant() -> None:
    """The fixture draws something: distances between its pictures aren't all zero."""
    rng = np.random.default_rng(0)
    found = distances_between([scribble(rng, 3)], [scribble(rng, 5)])
    assert found[0, 0] > 0
