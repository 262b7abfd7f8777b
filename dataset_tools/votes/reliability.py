"""Who can be relied on: participants who passed every sentinel, and which of their questionnaires counts."""

from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from dataset_tools.votes.careless_responding import flags
from dataset_tools.votes.votes import ITEM

ANSWERING = ["worker", "assignment", "questionnaire"]
"""The columns that say which answered questionnaire a vote is in."""

_LAST = "~"
"""Sorts after every time."""


@dataclass(frozen=True)
class Participant:
    """What is known of one participant.

    Attributes:
        worker: Identifies the participant.
        assignment: The questionnaire that counts: the first.
        reasons: Why the answers are ignored; none for a reliable participant.
        sentinels: Sentinels answered.
        failed: Of these, how many wrongly.
        later: Assignments after the first, which don't count.
        sources: Where the answers came from.
    """

    worker: str
    assignment: tuple[str, str]
    reasons: tuple[str, ...]
    sentinels: int
    failed: int
    later: tuple[tuple[str, str], ...]
    sources: tuple[str, ...]

    @property
    def reliable(self) -> bool:
        """Whether the answers count."""
        return not self.reasons


def assess(votes: pd.DataFrame, strict: bool = False) -> dict[str, Participant]:
    """Every participant, by name, in order of names.

    One failed sentinel, in whichever questionnaire, makes a participant unreliable (appendix 5). The first
    questionnaire is the one that was sent first; where times are unknown they come last, and among equals the
    assignment's name decides, so the order of votes never matters.

    Args:
        votes: All votes.
        strict: Count signs of not looking (`careless_responding.flags`) as reasons too.
    """
    signs = flags(votes) if strict else {}
    answerings = _answerings(votes)
    sources = votes.groupby("worker")["source"].unique()
    checks = votes[votes["sentinel"]].groupby("worker")["passed"]
    asked, passed = checks.size().to_dict(), checks.sum().to_dict()
    found = {}
    for worker, own in answerings.items():
        sentinels = asked.get(worker, 0)
        failed = sentinels - passed.get(worker, 0)
        reasons = (*((f"failed {failed} of {sentinels} sentinels",) if failed else ()), *signs.get(worker, ()))
        first, *later = own
        found[worker] = Participant(
            worker, first, reasons, sentinels, failed, tuple(later), tuple(sorted(sources[worker]))
        )
    return found


def _answerings(votes: pd.DataFrame) -> dict[str, list[tuple[str, str]]]:
    """Worker -> (assignment, questionnaire) of all that was answered, as it was sent."""
    sent = votes.assign(submitted=votes["submitted"].replace("", _LAST)).groupby(ANSWERING)["submitted"].max()
    ordered = sent.reset_index().sort_values(["worker", "submitted", "assignment", "questionnaire"])
    found: dict[str, list[tuple[str, str]]] = {}
    for worker, assignment, questionnaire in ordered[ANSWERING].itertuples(index=False):
        found.setdefault(worker, []).append((assignment, questionnaire))
    return found


def counted(votes: pd.DataFrame, participants: Mapping[str, Participant], unreliable_too: bool = False) -> pd.DataFrame:
    """The votes that count: of each reliable participant the first questionnaire, without its sentinels.

    An item that a participant saw twice there counts once, as answered first.

    Args:
        votes: All votes.
        participants: As `assess` found them.
        unreliable_too: Keep the votes of unreliable participants.

    Returns:
        Some of the rows, by worker and item.
    """
    first = {(p.worker, *p.assignment) for p in participants.values() if p.reliable or unreliable_too}
    mine = pd.MultiIndex.from_frame(votes[ANSWERING]).isin(first)
    kept = votes[mine & ~votes["sentinel"]].sort_values(["worker", *ITEM, "question", "choice"])
    return kept.drop_duplicates(["worker", *ITEM], ignore_index=True)
