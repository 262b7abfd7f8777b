"""Who can be relied on: participants who passed every sentinel, and which of their questionnaires counts."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from dataset_tools.votes.careless_responding import flags
from dataset_tools.votes.votes import Vote


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


def assess(votes: Iterable[Vote], strict: bool = False) -> dict[str, Participant]:
    """Every participant, by name, in order of names.

    One failed sentinel, in whichever questionnaire, makes a participant unreliable (appendix 5). The first
    questionnaire is the one that was sent first; where times are unknown they come last, and among equals the
    assignment's name decides, so the order of votes never matters.

    Args:
        votes: All votes.
        strict: Count signs of not looking (`suspicion.flags`) as reasons too.
    """
    by_worker: dict[str, list[Vote]] = {}
    for vote in votes:
        by_worker.setdefault(vote.worker, []).append(vote)
    signs = flags([vote for own in by_worker.values() for vote in own]) if strict else {}
    return {worker: _assess(worker, by_worker[worker], signs.get(worker, ())) for worker in sorted(by_worker)}


def _assess(worker: str, votes: Sequence[Vote], signs: Sequence[str]) -> Participant:
    sent: dict[tuple[str, str], str] = {}
    for vote in votes:
        sent[vote.assignment, vote.questionnaire] = vote.submitted or "~"  # sorts after every time
    first, *later = sorted(sent, key=lambda name: (sent[name], name))
    checks = [vote for vote in votes if vote.sentinel]
    failed = sum(not vote.passed for vote in checks)
    reasons = (*((f"failed {failed} of {len(checks)} sentinels",) if failed else ()), *signs)
    sources = tuple(sorted({vote.source for vote in votes}))
    return Participant(worker, first, reasons, len(checks), failed, tuple(later), sources)


def counted(votes: Iterable[Vote], participants: Mapping[str, Participant], unreliable_too: bool = False) -> list[Vote]:
    """The votes that count: of each reliable participant the first questionnaire, without its sentinels.

    An item that a participant saw twice there counts once, as answered first.

    Args:
        votes: All votes.
        participants: As `assess` found them.
        unreliable_too: Keep the votes of unreliable participants.
    """
    kept: dict[tuple[str, str, str], Vote] = {}
    for vote in votes:
        participant = participants[vote.worker]
        if vote.sentinel or (vote.assignment, vote.questionnaire) != participant.assignment:
            continue
        if participant.reliable or unreliable_too:
            place = (vote.worker, vote.shape, vote.view)
            held = kept.get(place)
            if held is None or (vote.question, vote.choice) < (held.question, held.choice):
                kept[place] = vote
    return [kept[place] for place in sorted(kept)]
