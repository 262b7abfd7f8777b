"""The perceptual study asks every pair twice and counts consistent answers only."""

import csv
import json
import random
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from dataset_tools.questionnaires.batch_folder import Look
from dataset_tools.questionnaires.questionnaire import NONE
from dataset_tools.simulation.study_participants import StudyCrowd, simulate_study
from dataset_tools.site.served_batch import SiteBatch
from dataset_tools.study.analysis import PairAnswer, evaluate_study, ingest_study, read_answers
from dataset_tools.study.design import BOTH, Preference, StudyKey, StudyScheme, build_study
from dataset_tools.study.report import summary, write_study_report
from dataset_tools.study.stimuli import Comparison, StudyFolders
from dataset_tools.votes.results_csv import Answered, read_csv_results
from ncmodel.cli.main import main
from ncmodel.errors import InputError, UsageError
from ncmodel.images import from_ink, write_png
from tests.helpers.crowd_data import scribble

CASES, RIVALS = 12, ("contours", "canny")


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> StudyFolders:
    root = tmp_path_factory.mktemp("study")
    for number, name in enumerate(("ours", *RIVALS)):
        (root / name).mkdir()
        for case in range(CASES):
            write_png(root / name / f"case_{case}.png", from_ink(scribble(np.random.default_rng([number, case]), 4)))
    for case in range(CASES):
        (root / "renders" / f"case_{case}").mkdir(parents=True)
        for view in range(3):
            picture = from_ink(scribble(np.random.default_rng([9, case, view]), 9))
            write_png(root / "renders" / f"case_{case}" / f"{view}.png", picture)
    return StudyFolders(root / "ours", {name: root / name for name in RIVALS}, root / "renders")


@pytest.fixture(scope="module")
def batch(folders: StudyFolders, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("batch") / "study"
    build_study(folders, "NCs", StudyScheme(pairs=8), Look(48, 32), folder)
    return folder


def test_the_paper_scheme_is_the_default() -> None:
    assert StudyScheme() == StudyScheme(pairs=15, answers=3, most_inconsistent=7)


def test_every_pair_is_asked_twice_with_sides_swapped_in_another_order(batch: Path) -> None:
    key = StudyKey.load(batch)
    asked: Counter[Comparison] = Counter()
    for questions in key.questionnaires.values():
        first, second = questions[:8], questions[8:]
        assert {q.comparison for q in first} == {q.comparison for q in second}
        assert [q.comparison for q in first] != [q.comparison for q in second]
        assert not any(q.flipped for q in first)
        assert all(q.flipped for q in second)
        assert len({q.comparison.case for q in first}) == 8, "no case twice where that can be avoided"
        sides = {q.comparison: next(iter(q.answers.values())) for q in first}
        assert all(next(iter(q.answers.values())) != sides[q.comparison] for q in second)
        asked.update(q.comparison for q in first)
    assert set(asked) == {Comparison(f"case_{c}", rival) for c in range(CASES) for rival in RIVALS}
    assert min(asked.values()) == 3


def test_the_batch_is_like_any_other(batch: Path) -> None:
    """The site takes it, every picture is there, and names tell nothing."""
    site = SiteBatch(batch)
    key = StudyKey.load(batch)
    for name, questions in key.questionnaires.items():
        page = site.fragment(name, {"q01": BOTH})
        assert page.count("<input type=radio") == 16 * 4
        assert page.count(" checked") == 1
        assert "${" not in page
        assert not any(word in page for word in ("canny", "contours", "case_", "ours"))
        for question in questions:
            assert all(site.accepts(name, question.field, value) for value in question.answers)
    with (batch / "tasks.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert all((batch / cell).is_file() for row in rows for cell in row.values() if cell.endswith(".png"))
    assert len({path.stat().st_size for path in (batch / "images").iterdir()}) == 2


def results(batch: Path, people: dict[str, float]) -> list[Answered]:
    """Answers of workers who prefer ours, each with a chance to answer at random."""
    key = StudyKey.load(batch)
    rng = random.Random(0)
    found = []
    names = list(key.questionnaires)
    for number, (worker, chance) in enumerate(people.items()):
        name = names[number % len(names)]
        answers = {}
        for question in key.questionnaires[name]:
            best = next(v for v, meaning in question.answers.items() if meaning is Preference.OURS)
            answers[question.field] = rng.choice(list(question.answers)) if rng.random() < chance else best
        found.append(Answered(worker, f"a-{worker}", name, answers, {"q01": 4.0}, None, "", "mturk", worker))
    return found


def test_inconsistent_workers_are_unreliable(batch: Path, tmp_path: Path) -> None:
    people = {f"good{i}": 0.0 for i in range(9)} | {"clicker": 1.0}
    done = ingest_study(results(batch, people), StudyKey.load(batch), tmp_path / "answers.csv")
    assert (done.assignments, done.votes, done.problems) == (10, 160, [])
    again = ingest_study(results(batch, people), StudyKey.load(batch), tmp_path / "answers.csv")
    assert (again.known_assignments, again.votes) == (10, 0)
    answers = list(read_answers(tmp_path / "answers.csv"))
    found = evaluate_study(answers, most_inconsistent=3)
    assert found.unreliable == {"clicker"}
    assert found.inconsistent["good0"] == 0
    assert all(set(counts) == {Preference.OURS} for counts in found.counts.values())
    assert sum(sum(counts.values()) for counts in found.counts.values()) == 9 * 8
    random.Random(1).shuffle(answers)
    assert evaluate_study(answers, most_inconsistent=3) == found


def answer(worker: str, first: Preference, second: Preference | None, case: str = "c") -> list[PairAnswer]:
    both = [(False, first)] + ([(True, second)] if second else [])
    return [
        PairAnswer(worker, f"a-{worker}", "q", 1 + flipped, case, "r", flipped, given, None, "mturk")
        for flipped, given in both
    ]


def test_only_equal_answers_count_and_three_of_them() -> None:
    ours, rival = Preference.OURS, Preference.RIVAL
    votes = [*answer("a", ours, ours), *answer("b", ours, rival), *answer("c", rival, rival), *answer("d", ours, None)]
    found = evaluate_study(votes)
    assert dict(found.counts["r"]) == {ours: 1, rival: 1}
    assert found.short == {Comparison("c", "r"): 1}
    assert found.inconsistent == {"a": 0, "b": 1, "c": 0, "d": 1}
    many = [entry for worker in "abcdefg" for entry in answer(worker, ours, ours)]
    assert sum(evaluate_study(many).counts["r"].values()) == 3
    assert evaluate_study(many).short == {}


def test_more_than_seven_inconsistent_is_unreliable_and_seven_is_not() -> None:
    for wrong, unreliable in ((7, False), (8, True)):
        votes = []
        for number in range(15):
            second = Preference.RIVAL if number < wrong else Preference.OURS
            votes += answer("w", Preference.OURS, second, f"case{number}")
        assert ("w" in evaluate_study(votes).unreliable) is unreliable


def test_report(batch: Path, tmp_path: Path) -> None:
    ingest_study(results(batch, {f"g{i}": 0.3 for i in range(9)}), StudyKey.load(batch), tmp_path / "answers.csv")
    found = evaluate_study(read_answers(tmp_path / "answers.csv"))
    write_study_report(found, "NCs", tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text()
    assert "NCs against canny" in text
    assert "simulated" not in text
    figures = summary(found, "NCs")
    assert json.dumps(figures, allow_nan=False)
    assert set(figures["rivals"]) == set(RIVALS)  # type: ignore[call-overload]


def test_results_files_are_read(batch: Path, tmp_path: Path) -> None:
    key = StudyKey.load(batch)
    name = next(iter(key.questionnaires))
    row = {"WorkerId": "w", "AssignmentId": "a", "Input.questionnaire": name, "Answer.q01": NONE, "Answer.q02": "what"}
    with (tmp_path / "r.csv").open("w") as file:
        writer = csv.DictWriter(file, list(row))
        writer.writeheader()
        writer.writerow(row)
    done = ingest_study(read_csv_results(tmp_path / "r.csv"), key, tmp_path / "answers.csv")
    assert done.votes == 1
    assert "q02 is 'what'" in str(done.problems[0])


def test_bad_input(folders: StudyFolders, batch: Path, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no rivals"):
        build_study(StudyFolders(folders.ours, {}, folders.renders), "x", StudyScheme(), Look(), tmp_path / "b")
    with pytest.raises(InputError, match="no drawings"):
        build_study(StudyFolders(tmp_path, folders.rivals, folders.renders), "x", StudyScheme(), Look(), tmp_path / "b")
    with pytest.raises(InputError, match=r"case_0\.png: no such file"):
        build_study(
            StudyFolders(folders.ours, {"r": tmp_path}, folders.renders), "x", StudyScheme(), Look(), tmp_path / "b"
        )
    with pytest.raises(InputError, match="0 renders"):
        build_study(StudyFolders(folders.ours, folders.rivals, tmp_path), "x", StudyScheme(), Look(), tmp_path / "b")
    (tmp_path / "key.json").write_text(json.dumps({"questionnaires": {"a": {"questions": [{}]}}}))
    with pytest.raises(InputError, match="not the key of a study"):
        StudyKey.load(tmp_path)


def test_comparisons_that_nobody_answered_are_short(batch: Path) -> None:
    key = StudyKey.load(batch)
    found = evaluate_study([], asked=key.comparisons)
    assert found.short == dict.fromkeys(key.comparisons, 3)
    assert len(found.comparisons) == CASES * len(RIVALS)
    assert set(found.counts) == set(RIVALS)
    one = answer("w", Preference.OURS, Preference.OURS, case="case_0")
    some = evaluate_study([replace(a, rival="canny") for a in one], asked=key.comparisons).short
    assert some[Comparison("case_0", "canny")] == 2
    assert some[Comparison("case_0", "contours")] == 3


def test_a_topup_asks_about_what_is_short_in_whole_questionnaires(folders: StudyFolders, tmp_path: Path) -> None:
    short = {Comparison("case_3", "canny"): 2, Comparison("case_5", "contours"): 1}
    key, _ = build_study(folders, "NCs", StudyScheme(pairs=8), Look(16, 16), tmp_path / "more", short)
    assert len(key.questionnaires) == 2, "the fewest that can hold two answers to one comparison"
    asked = Counter(q.comparison for questions in key.questionnaires.values() for q in questions if not q.flipped)
    assert all(asked[comparison] >= lacking for comparison, lacking in short.items())
    assert {len(questions) for questions in key.questionnaires.values()} == {16}
    assert StudyKey.load(tmp_path / "more") == key
    first, _ = build_study(folders, "NCs", StudyScheme(pairs=8), Look(16, 16), tmp_path / "first")
    assert not set(first.questionnaires) & set(key.questionnaires)


def test_the_loop_by_commands(
    folders: StudyFolders, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Build, simulate, ingest, report, top up, again and again until no comparison is short."""
    monkeypatch.chdir(tmp_path)
    against = [word for name, folder in folders.rivals.items() for word in ("--against", f"{name}={folder}")]
    small = ["--drawing-side", "16", "--render-side", "16"]
    pictures = ["--ours", f"NCs={folders.ours}", *against, "--renders", str(folders.renders), *small]

    def study(*arguments: str) -> dict[str, Any]:
        capsys.readouterr()
        assert main(["crowd", "study", *arguments, "--json"]) == 0
        record = json.loads(capsys.readouterr().out)
        assert isinstance(record, dict)
        return record

    built = study("build", "batch0", *pictures)
    assert built == {"questionnaires": 5, "comparisons": 24, "short": 24, "notes": []}
    lacking = []
    for turn in range(12):
        done = study("simulate", f"batch{turn}", "-o", "results.csv", "--noise", "0.3", "--random-clickers", "0.4")
        assert "simulated participant" in Path("results.csv").read_text()
        ingested = study("ingest", f"batch{turn}", "results.csv", "-o", "answers.csv")
        assert ingested["assignments"] == done["simulated_participants"]
        report = study("report", "batch0", "answers.csv", "-o", "report.html")
        assert report["simulated"] is True
        assert report["comparisons"] == 24
        assert "simulated: nobody gave" in Path("report.html").read_text()
        lacking.append(report["answers_lacking"])
        if study("topup", "batch0", "answers.csv", f"batch{turn + 1}", *small)["questionnaires"] == 0:
            break
    assert lacking[0] > 0, "clickers and second thoughts leave some short"
    assert lacking == sorted(lacking, reverse=True)
    assert lacking[-1] == 0
    assert all(sum(rival[one.value]["count"] for one in Preference) == 36 for rival in report["rivals"].values())


def test_simulated_participants_favour_no_method(batch: Path, tmp_path: Path) -> None:
    """Appeals are made up alike for all methods, so over many seeds ours wins about half of what is decided."""
    won = lost = 0
    for seed in range(20):
        simulate_study(batch, tmp_path / "r.csv", StudyCrowd(random_clickers=0.0), 9, seed)
        (tmp_path / "a.csv").unlink(missing_ok=True)
        ingest_study(read_csv_results(tmp_path / "r.csv"), StudyKey.load(batch), tmp_path / "a.csv")
        found = evaluate_study(read_answers(tmp_path / "a.csv"))
        won += sum(counts.get(Preference.OURS, 0) for counts in found.counts.values())
        lost += sum(counts.get(Preference.RIVAL, 0) for counts in found.counts.values())
    assert won + lost > 500
    assert 0.4 < won / (won + lost) < 0.6


def test_a_study_too_small_to_find_clickers_says_so(folders: StudyFolders, tmp_path: Path) -> None:
    _, notes = build_study(folders, "NCs", StudyScheme(pairs=7), Look(16, 16), tmp_path / "b")
    assert "nobody is unreliable" in "".join(notes)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"case_3"', '"case_x"'),
        ('"rival"', '"ours"'),
        ('"flipped": true', '"flipped": false'),
        ('"field": "q02"', '"field": "q01"'),
        ('"options": {', '"options": [], "x": {'),
    ],
)
def test_a_key_that_does_not_ask_twice_is_refused(batch: Path, tmp_path: Path, old: str, new: str) -> None:
    text = (batch / "key.json").read_text()
    assert old in text
    (tmp_path / "key.json").write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match="not the key of a study"):
        StudyKey.load(tmp_path)


def test_pictures_that_are_the_same_are_noted(folders: StudyFolders, tmp_path: Path) -> None:
    alike = StudyFolders(folders.ours, {"twin": folders.ours, **folders.rivals}, folders.renders)
    _, notes = build_study(alike, "NCs", StudyScheme(pairs=8), Look(16, 16), tmp_path / "b")
    assert notes == ["12 of 36 comparisons show the same picture twice: only chance decides them"]
