"""The approve/reject file of old: a results CSV with X in Approve or a reason in Reject, to be uploaded again."""

import csv
from collections.abc import Mapping
from pathlib import Path

from dataset_tools.votes.reliability import Participant
from dataset_tools.votes.tables import open_table
from ncmodel.errors import InputError
from ncmodel.files import atomic

REASON = "Answers to control questions with a known answer were wrong."


def write_review(results: Path, participants: Mapping[str, Participant], out: Path) -> dict[str, int]:
    """Copy a results CSV with its Approve and Reject columns filled in; rows of unknown workers stay as they are.

    Reasons given to participants don't say which questions check them.

    Args:
        results: Mechanical Turk's results CSV.
        participants: As `reliability.assess` found them.
        out: File to write.

    Returns:
        Counts of approved, rejected and unknown rows.

    Raises:
        InputError: The file can't be read or has no WorkerId column.
    """
    counts = {"approved": 0, "rejected": 0, "unknown": 0}
    try:
        with open_table(results, ["WorkerId"]) as rows, atomic(out) as aside:
            header = next(rows, [])
            names = [name for name in header if name not in ("Approve", "Reject")]
            if "WorkerId" not in names:
                raise InputError(results, f"columns {', '.join(names[:6])}", "a results CSV with WorkerId")
            with aside.open("w", encoding="utf-8", newline="") as file:
                writer = csv.DictWriter(file, [*names, "Approve", "Reject"], extrasaction="ignore", lineterminator="\n")
                writer.writeheader()
                for cells in filter(None, rows):
                    row = dict(zip(header, cells, strict=False))
                    verdict = _verdict(participants.get(row.get("WorkerId", "").strip()))
                    counts[verdict] += 1
                    approve, reject = "X" if verdict == "approved" else "", REASON if verdict == "rejected" else ""
                    writer.writerow({**row, "Approve": approve, "Reject": reject})
    except OSError as error:
        raise InputError(results, f"can't be read ({error.strerror})", "a results CSV") from error
    except (csv.Error, UnicodeDecodeError) as error:
        raise InputError(results, f"not CSV in UTF-8 or UTF-16 ({error})", "a results CSV") from error
    return counts


def _verdict(participant: Participant | None) -> str:
    if participant is None:
        return "unknown"
    return "approved" if participant.reliable else "rejected"
