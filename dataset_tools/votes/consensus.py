"""From votes to ranking pairs: consensus on each item, and shapes held out for validation."""

import hashlib
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import pandas as pd

from dataset_tools.questionnaires.identical_drawings import ALL_DIFFERENT, Twins, distinct, from_text
from dataset_tools.votes.dawid_skene import one_coin
from dataset_tools.votes.reliability import Participant, assess, counted
from dataset_tools.votes.votes import ITEM, drawings_of, items_of
from ncmodel.data.item import Item
from ncmodel.data.pairs import Pair
from ncmodel.errors import ArgumentError

Method = Literal["majority", "one-coin"]


@dataclass(frozen=True)
class Rules:
    """How votes become pairs.

    Attributes:
        method: "majority": the paper's rule. "one-coin": the posterior of Dawid and Skene's model with one accuracy a
            participant.
        least: Votes that must agree. With "majority" they must also be more than half of the item's votes: of 3 votes
            2. Where two drawings tie, neither has more than half, so a tie is never accepted.
        posterior: With "one-coin", how sure the model must be.
        unreliable_too: Keep the votes of participants who failed a sentinel (for "one-coin", which weighs them itself).
        strict: Exclude participants who show signs of not looking too, not only those who failed a sentinel.
        held_out: Share of the shapes held out for validation.
        validation_shapes: The shapes to hold out, instead of a share.
        seed: Of the choice of shapes to hold out.
    """

    method: Method = "majority"
    least: int = 2
    posterior: float = 0.9
    unreliable_too: bool = False
    strict: bool = False
    held_out: float = 0.1
    validation_shapes: tuple[str, ...] = ()
    seed: int = 0

    def __post_init__(self) -> None:
        if self.method not in get_args(Method):
            raise ArgumentError("method", repr(self.method), " or ".join(get_args(Method)))
        if self.least < 1:
            raise ArgumentError("least", str(self.least), "1 or more")
        if not 0.0 <= self.held_out < 1.0:
            raise ArgumentError("held_out", str(self.held_out), "a share in 0..1, 1 excluded")
        if not 0.0 < self.posterior <= 1.0:
            raise ArgumentError("posterior", str(self.posterior), "a probability in 0..1, 0 excluded")


@dataclass(frozen=True)
class Verdict:
    """What participants made of an item.

    Attributes:
        item: The item.
        votes: Choice (-1 none, 0..7) -> votes that count; those for twins count for the first of them.
        choice: What they agree on (-1: that none is good); None without consensus.
        sources: Where the votes came from.
        twins: Which of the drawings are the same picture.
    """

    item: Item
    votes: Mapping[int, int]
    choice: int | None
    sources: tuple[str, ...]
    twins: Twins

    @property
    def total(self) -> int:
        """Votes that count."""
        return sum(self.votes.values())

    @property
    def best(self) -> int | None:
        """The drawing that they agree on, if any."""
        return self.choice if self.choice is not None and self.choice >= 0 else None

    @property
    def others(self) -> list[int]:
        """The drawings that differ from the best one and from each other: what it is better than."""
        return [index for index in distinct(self.twins) if index != self.best]


@dataclass(frozen=True)
class Aggregated:
    """Verdicts on all items, participants, and which shapes are held out."""

    verdicts: Sequence[Verdict]
    participants: Mapping[str, Participant]
    validation: frozenset[str]

    @property
    def reliable_share(self) -> float:
        """Share of the participants who are reliable."""
        return sum(person.reliable for person in self.participants.values()) / max(1, len(self.participants))

    def pairs(self) -> list[Pair]:
        """The ranking pairs: of each accepted item the best drawing against the others (seven, without twins)."""
        return [
            Pair(
                verdict.item,
                verdict.best,
                other,
                split="validation" if verdict.item.shape in self.validation else "train",
                votes_for=verdict.votes[verdict.best],
                votes=verdict.total,
                source="+".join(verdict.sources),
            )
            for verdict in self.verdicts
            if verdict.best is not None
            for other in verdict.others
        ]

    def summary(self) -> dict[str, object]:
        """Counts and rates for people and `--json`."""
        accepted = [verdict for verdict in self.verdicts if verdict.best is not None]
        votes = sum(verdict.total for verdict in self.verdicts)
        none = sum(verdict.votes.get(-1, 0) for verdict in self.verdicts)
        out = sum(verdict.item.shape in self.validation for verdict in accepted)
        unreliable = {p.worker: list(p.reasons) for p in self.participants.values() if not p.reliable}
        return {
            "participants": len(self.participants),
            "reliable": len(self.participants) - len(unreliable),
            "unreliable": unreliable,
            "simulated": any("simulated" in p.sources for p in self.participants.values()),
            "items": len(self.verdicts),
            "votes": votes,
            "accepted": len(accepted),
            "accepted_rate": len(accepted) / max(1, len(self.verdicts)),
            "agreed_none": sum(verdict.choice == -1 for verdict in self.verdicts),
            "none_rate": none / max(1, votes),
            "pairs": sum(len(verdict.others) for verdict in accepted),
            "train_items": len(accepted) - out,
            "validation_items": out,
            "validation_shapes": sorted(self.validation),
        }


def aggregate(votes: pd.DataFrame, rules: Rules) -> Aggregated:
    """Verdicts and held-out shapes from votes; neither depends on the votes' order.

    Raises:
        UsageError: A shape to hold out has no votes.
    """
    participants = assess(votes, rules.strict)
    kept = counted(votes, participants, rules.unreliable_too)
    items = items_of(votes[~votes["sentinel"]])
    shapes = {item.shape for item in items}
    unknown = sorted(set(rules.validation_shapes) - shapes)
    if unknown:
        have = "which has" if len(unknown) == 1 else "which have"
        found = f"{', '.join(unknown)}, {have} no votes"
        raise ArgumentError("validation_shapes", found, f"some of the {len(shapes)} shapes that were voted on")
    validation = rules.validation_shapes or _held_out(shapes, rules)
    return Aggregated(_verdicts(items, kept, rules), participants, frozenset(validation))


def _verdicts(items: Sequence[Item], kept: pd.DataFrame, rules: Rules) -> list[Verdict]:
    counts: dict[Item, Counter[int]] = {item: Counter() for item in items}
    sources: dict[Item, set[str]] = {item: set() for item in items}
    twins: dict[Item, Twins] = {}
    drawn = kept.assign(drawing=drawings_of(kept)).value_counts([*ITEM, "drawing", "source", "twins"])
    for shape, view, drawing, source, text, count in drawn.reset_index().itertuples(index=False):
        item = Item(shape, view)
        counts[item][drawing] += count
        sources[item].add(source)
        same = from_text(text)
        twins[item] = max(twins.get(item, same), same)
    believed = one_coin(kept) if rules.method == "one-coin" else {}
    return [
        Verdict(
            item,
            dict(sorted(counts[item].items())),
            believed[item].choice_above(rules.posterior)
            if item in believed and rules.method == "one-coin"
            else _majority(counts[item], rules.least),
            tuple(sorted(sources[item])),
            twins.get(item, ALL_DIFFERENT),
        )
        for item in items
    ]


def _majority(counts: Counter[int], least: int) -> int | None:
    """The choice of more than half of the voters, at least `least` of them."""
    choice, count = max(counts.items(), key=lambda pair: pair[1], default=(0, 0))
    return choice if count >= least and 2 * count > counts.total() else None


def _held_out(shapes: Iterable[str], rules: Rules) -> list[str]:
    """The share of shapes to hold out, chosen by a hash of their names: at least one where a share is asked for."""
    ranked = sorted(shapes, key=lambda shape: hashlib.blake2b(f"{rules.seed} {shape}".encode()).digest())
    count = round(rules.held_out * len(ranked))
    if rules.held_out > 0 and len(ranked) > 1:
        count = min(max(count, 1), len(ranked) - 1)
    return ranked[:count] if len(ranked) > 1 else []
