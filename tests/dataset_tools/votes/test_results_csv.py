"""Results files that are wide where no platform makes them wide."""

import time
from pathlib import Path

from dataset_tools.votes.results_csv import Answered, read_csv_results


def test_a_header_of_very_many_columns_is_read_in_time(tmp_path: Path) -> None:
    names = ["AssignmentId", "Input.questionnaire", "WorkerId", *(f"Answer.q{n}" for n in range(100_000))]
    path = tmp_path / "wide.csv"
    path.write_text(",".join(names) + "\n" + ",".join(["a", "b", "w", *("1" for _ in names[3:])]) + "\n")
    begin = time.process_time()
    (answered,) = read_csv_results(path)
    assert isinstance(answered, Answered)
    assert len(answered.answers) == 100_000
    assert time.process_time() - begin < 20
    path.write_text(",".join([*names, names[-1]]) + "\n" + ",".join(["a", "b", "w", *("1" for _ in names[2:])]) + "\n")
    (same,) = read_csv_results(path)
    assert isinstance(same, Answered)
    assert same.answers == answered.answers
