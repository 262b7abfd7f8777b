"""Results files of simulated participants: in Mechanical Turk's format, every row marked as simulated."""

import csv
import json
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from hashlib import blake2b
from pathlib import Path

from dataset_tools.votes.results_csv import SIMULATED
from ncmodel.files import atomic

MTURK_COLUMNS = (
    "HITId", "HITTypeId", "Title", "Description", "Keywords", "Reward", "CreationTime", "MaxAssignments",
    "RequesterAnnotation", "AssignmentDurationInSeconds", "AutoApprovalDelayInSeconds", "Expiration",
    "NumberOfSimilarHITs", "LifetimeInSeconds", "AssignmentId", "WorkerId", "AssignmentStatus", "AcceptTime",
    "SubmitTime", "AutoApprovalTime", "ApprovalTime", "RejectionTime", "RequesterFeedback", "WorkTimeInSeconds",
    "LifetimeApprovalRate", "Last30DaysApprovalRate", "Last7DaysApprovalRate",
)  # fmt: skip
"""The columns of a results file before Input.* and Answer.*, in Mechanical Turk's order."""

EPOCH = datetime(2026, 1, 5, 9, 0, 0, tzinfo=UTC)
"""When the first simulated participant begins."""


@dataclass(frozen=True)
class Response:
    """What a participant answers to one question, and how long it takes."""

    value: str
    seconds: float


@dataclass(frozen=True)
class Submission:
    """A questionnaire as a simulated participant sends it.

    Attributes:
        worker: The participant's name, which says that it is simulated.
        kind: What kind of participant it is.
        questionnaire: Which questionnaire.
        responses: Field -> response.
    """

    worker: str
    kind: str
    questionnaire: str
    responses: Mapping[str, Response]


def crowd_name(seed: int, questionnaires: Iterable[str]) -> str:
    """How the names of a batch's simulated participants begin: nobody is named twice in two batches."""
    return f"simulated-{blake2b(f'{seed} {list(questionnaires)}'.encode(), digest_size=2).hexdigest()}"


def write_results(path: Path, submissions: Iterable[Submission], fields: Iterable[str]) -> Counter[str]:
    """Write a results file in Mechanical Turk's format, every row of it marked as simulated.

    Returns:
        Kind of participant -> how many answered.
    """
    answers = [f"Answer.{name}" for name in (*fields, "seconds")]
    kinds: Counter[str] = Counter()
    with atomic(path) as aside, aside.open("w", encoding="utf-8", newline="") as file:
        header = [*MTURK_COLUMNS, "Input.questionnaire", *answers, "Approve", "Reject"]
        writer = csv.DictWriter(file, header, restval="", lineterminator="\n")
        writer.writeheader()
        for number, one in enumerate(submissions, 1):
            kinds[one.kind] += 1
            writer.writerow(_result(number, one))
    return kinds


def _result(number: int, submission: Submission) -> dict[str, str]:
    total = sum(response.seconds for response in submission.responses.values())
    begin = EPOCH + timedelta(minutes=3 * number)
    return {
        "HITId": f"simulated-{submission.questionnaire}",
        "Title": "Answered by simulated participants",
        "RequesterAnnotation": SIMULATED,
        "MaxAssignments": "1",
        "AssignmentId": f"{submission.worker}-{submission.questionnaire}",
        "WorkerId": submission.worker,
        "AssignmentStatus": "Submitted",
        "AcceptTime": _clock(begin),
        "SubmitTime": _clock(begin + timedelta(seconds=total)),
        "WorkTimeInSeconds": str(round(total)),
        "Input.questionnaire": submission.questionnaire,
        **{f"Answer.{field}": response.value for field, response in submission.responses.items()},
        "Answer.seconds": json.dumps(
            {field: round(response.seconds, 1) for field, response in submission.responses.items()}
        ),
    }


def _clock(moment: datetime) -> str:
    return moment.strftime("%a %b %d %H:%M:%S UTC %Y")
