"""Campaigns of pairs of bodies: every verdict is compared with an exact oracle's.

In: how pairs are drawn, decided by the oracle and asked of the core; peers. Out: a `PairCampaign`, see `campaign`.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, Protocol, TypeVar

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.campaign.cases import shrink
from plannercheck.evaluation.campaign.posed_pairs import ANY_OFFSET, UNFIT, HasPolytope, Outcome, PosedPairs, limited
from plannercheck.evaluation.campaign.supervised_process import Peer, Supervised, loaded
from plannercheck.evaluation.campaign.tallies import (
    EXCEPTION,
    FAILURES,
    KEPT,
    TIMEOUT,
    WRONG,
    Column,
    Entry,
    Tally,
    table,
)

if TYPE_CHECKING:
    from typing import Self

# Who decides the truth. Its outcomes are ASKED or what it notes, INSIDE: a part of one body is inside the other.
TRUTH, ASKED, INSIDE = "truth", "asked", "inside"
_RIGHT = "right"


class CaseBody(HasPolytope, Protocol):
    """A body that can be kept, and made smaller."""

    @property
    def parts(self) -> int:
        """How many parts it has that a smaller one may do without."""

    def some(self, rows: list[int]) -> Self:
        """The body of some of its parts."""

    def document(self) -> dict[str, Any]:
        """Its numbers."""


AnyBody = TypeVar("AnyBody", bound=CaseBody)


@dataclass(frozen=True, eq=False)
class PairCase(Generic[AnyBody]):
    """Two bodies at their poses (4, 4), m; the name says what failed."""

    name: str
    p: AnyBody
    r: AnyBody
    pose_p: Floats
    pose_r: Floats

    def document(self) -> dict[str, Any]:
        """What is kept."""
        bodies = {"p": self.p.document(), "r": self.r.document()}
        return {"name": self.name, **bodies, "pose_p": self.pose_p, "pose_r": self.pose_r}

    @property
    def drawn(self) -> PosedPairs[AnyBody]:
        """A draw of this pair alone."""
        return PosedPairs("case", self.name, self.p, self.r, self.pose_p[None], self.pose_r[None], (ANY_OFFSET,))


def pair_case(document: dict[str, Any], body_of: Callable[[dict[str, Any]], AnyBody]) -> PairCase[AnyBody]:
    """The case of a document."""
    p, r = (body_of(document[key]) for key in ("p", "r"))
    pose_p, pose_r = (np.array(document[key], dtype=np.float64).reshape(4, 4) for key in ("pose_p", "pose_r"))
    return PairCase(str(document["name"]), p, r, pose_p, pose_r)


class Truth(NamedTuple):
    """The oracle's verdicts (k,), and what else it says of each pair, or nothing."""

    shared: list[bool]
    notes: list[str]


Asked = dict[str, Callable[[], list[Outcome]]]


@dataclass(frozen=True)
class PairCampaign(Generic[AnyBody]):
    """A campaign of pairs.

    Attributes:
        name: See `campaign.Campaign`.
        draw: The draw of a number.
        truth: The oracle on a draw, the `number`-th; AssertionError where it contradicts itself.
        questions: What each contestant is asked of a draw, the `number`-th, whose truth is known: outcomes (k,).
        body_of: The body of a document.
        families: Families in the order of the table.
        offsets: Offsets in the order of the table.
        peers: Other libraries to be counted, too.
        ask_all: Numbers of draws of which each contestant is asked.
        besides: What else is judged with the `number`-th draw.
        more_lines: Further tables.
    """

    name: str
    draw: Callable[[int], PosedPairs[AnyBody]]
    truth: Callable[[PosedPairs[AnyBody], int], Truth]
    questions: Callable[[PosedPairs[AnyBody], list[bool], int], Asked]
    body_of: Callable[[dict[str, Any]], AnyBody]
    families: tuple[str, ...]
    offsets: tuple[str, ...]
    peers: tuple[Callable[[], Peer[PosedPairs[AnyBody]]], ...] = ()
    ask_all: tuple[int, ...] = (0,)
    besides: Callable[[int, Tally[PairCase[AnyBody]]], None] | None = None
    more_lines: Callable[[Tally[Any], list[str]], list[str]] | None = None
    unit: str = "pairs"
    is_of_one_use: bool = True

    def __post_init__(self) -> None:
        """Raises PlannercheckError if a peer is not installed."""
        for peer in self.peers:
            loaded(peer)

    def judge(self, number: int, tally: Tally[PairCase[AnyBody]]) -> None:
        """Makes the `number`-th draw, and counts all outcomes on it."""
        began = time.perf_counter()
        drawn = self.draw(number)
        began = _spent(tally, "draws", began)
        truth = self.truth(drawn, number)
        began = _spent(tally, TRUTH, began)
        keys = [(drawn.family, *key) for key in zip(drawn.offsets, truth.shared, strict=True)]
        tally.judged += len(keys)
        tally.counts.update(Entry(TRUTH, note or ASKED, *key) for key, note in zip(keys, truth.notes, strict=True))
        for who, ask in self.questions(drawn, truth.shared, number).items():
            outcomes = limited(ask, len(keys))
            for k, entry in _counted(tally, who, keys, outcomes):
                tally.faults[entry] += 1
                if len(tally.cases) < KEPT:
                    name = f"draw {number}, {who}, offset {drawn.offsets[k]}, {drawn.label}"
                    tally.cases.append(PairCase(name, drawn.p, drawn.r, drawn.poses_p[k], drawn.poses_r[k]))
            began = _spent(tally, who, began)
        for peer in map(loaded, self.peers):
            _counted(tally, peer.name, keys, Supervised(peer).outcomes(drawn))
            began = _spent(tally, peer.name, began)
        if self.besides is not None:
            self.besides(number, tally)

    def lines(self, tally: Tally[PairCase[AnyBody]]) -> list[str]:
        """The tables."""
        peers = [loaded(peer).name for peer in self.peers]
        more = [] if self.more_lines is None else self.more_lines(tally, peers)
        return _pair_lines(tally, self.families, self.offsets, peers, more)

    def case_of(self, document: dict[str, Any]) -> PairCase[AnyBody]:
        """The case of a document."""
        return pair_case(document, self.body_of)

    def faults(self, case: PairCase[AnyBody]) -> dict[str, str]:
        """Contestants that fail on a case, and how; a body that can't be prepared does not count."""
        drawn = case.drawn
        try:
            _ = case.p.polytope, case.r.polytope
            shared = self.truth(drawn, 0).shared
        except (PlannercheckError, ValueError):
            return {}
        faults = dict[str, str]()
        for number in self.ask_all:
            for who, ask in self.questions(drawn, shared, number).items():
                (outcome,) = limited(ask, 1)
                if outcome not in (UNFIT, shared[0]):
                    faults[who] = _named(outcome)
        return faults

    def shrunk(self, case: PairCase[AnyBody]) -> PairCase[AnyBody]:
        """The case without the parts of both bodies that it can do without; the same if it does not fail."""
        return smaller(case, lambda tried: bool(self.faults(tried)))


def smaller(case: PairCase[AnyBody], fails: Callable[[PairCase[AnyBody]], bool]) -> PairCase[AnyBody]:
    """As few parts of both bodies as still fail."""
    if not fails(case):
        return case
    p = case.p
    case = replace(case, p=p.some(shrink(range(p.parts), lambda rows: fails(replace(case, p=p.some(rows))))))
    r = case.r
    return replace(case, r=r.some(shrink(range(r.parts), lambda rows: fails(replace(case, r=r.some(rows))))))


def _counted(
    tally: Tally[Any], who: str, keys: list[tuple[str, str, bool]], outcomes: list[Outcome]
) -> list[tuple[int, Entry]]:
    """Counts a contestant's outcomes; places and entries of those that are failures."""
    failed = []
    for k, (key, outcome) in enumerate(zip(keys, outcomes, strict=True)):
        entry = Entry(who, _RIGHT if outcome is key[2] else _named(outcome), *key)
        tally.counts[entry] += 1
        if entry.outcome not in (_RIGHT, UNFIT):
            failed.append((k, entry))
    return failed


def _named(outcome: Outcome) -> str:
    return outcome if isinstance(outcome, str) else WRONG


def _spent(tally: Tally[Any], what: str, began: float) -> float:
    """Notes the time since then, and begins again."""
    now = time.perf_counter()
    tally.seconds[what] += now - began
    return now


def _pair_lines(
    tally: Tally[Any], families: Sequence[str], offsets: Sequence[str], peers: Sequence[str], more: Sequence[str]
) -> list[str]:
    """All tables of a run's counts as lines of text: of these families, offsets and peers, and then `more` lines."""
    asked = [entry for entry in tally.counts if entry.who == TRUTH]
    pairs, sharing = (sum(tally.counts[e] for e in asked if e.shared or not only) for only in (False, True))
    each = Counter[str]()
    for entry, count in tally.counts.items():
        each[entry.who] += count * (entry.outcome != UNFIT)
    ours = [f"{who} {each[who]}" for who in tally.seconds if each[who] and who not in (TRUTH, *peers)]
    columns = _columns(tally, peers)
    out = [f"{pairs} pairs of {tally.draws} draws, {sharing} of them share a point; ours: {', '.join(ours)}", ""]
    out += table("family", lambda entry: entry.family, families, columns)
    out += ["", *table("offset", lambda entry: entry.offset, offsets, columns), *more]
    out += ["", "time: " + ", ".join(f"{what} {spent:.0f} s" for what, spent in tally.seconds.items())]
    return out + [f"broken: {message}" for message in tally.broken]


def _columns(tally: Tally[Any], peers: Sequence[str]) -> list[Column]:
    """Pairs, our failures, and wrong verdicts of the peers with how many they were asked."""
    counts = tally.counts
    found = [
        Column("pairs", counts, lambda entry: entry.who == TRUTH),
        Column("sharing", counts, lambda entry: entry.who == TRUTH and entry.shared),
    ]
    if any(entry.outcome == INSIDE for entry in counts):
        found.append(Column("inside", counts, lambda entry: entry.outcome == INSIDE))
    for head, kind in zip(("wrong", "except.", "timeouts"), FAILURES, strict=True):
        found.append(Column(head, tally.faults, lambda entry, kind=kind: entry.outcome == kind))  # type: ignore[misc]
    for peer in peers:
        found += _of_peer(tally, peer)
    return found


def _of_peer(tally: Tally[Any], peer: str) -> list[Column]:
    def is_wrong(entry: Entry) -> bool:
        return entry.who == peer and entry.outcome == WRONG

    return [
        Column(f"{peer} missed", tally.counts, lambda entry: is_wrong(entry) and entry.shared),
        Column(f"{peer} false", tally.counts, lambda entry: is_wrong(entry) and not entry.shared),
        Column(f"{peer} exc.", tally.counts, lambda e: e.who == peer and e.outcome in (EXCEPTION, TIMEOUT)),
        Column("asked", tally.counts, lambda entry: entry.who == peer and entry.outcome != UNFIT),
    ]
