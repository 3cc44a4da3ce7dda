"""Interleaved timing: contenders take turns, A B C C B A ..., and the least time of each counts.

In: contenders by name. Out: seconds by name, and the ratio of two runs of the same code (null control): smaller gains
mean nothing. Absolute times drift by tens of per cent on a shared machine; ratios of minima, taken alternately in one
process, do not. Short work sometimes runs wholly while the machine is fast, long work never does; so parts of similar
length are compared. The clock measures the processor time of the calling thread, the only one that contenders use, so
time of other processes does not count.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any, NamedTuple, TypeVar

import numpy as np

from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.errors import PlannercheckError

Made = TypeVar("Made")
Work = Callable[[], object]
Contenders = Mapping[str, Work | Sequence[Work]]

# Seconds: shorter work is repeated, as that clock may stand still for some microseconds on a virtual machine.
_SHORTEST = 1e-3
# Seconds that a round takes at least, on average: a shared machine's clock changes every few tenths of a second, and
# every contender should have met its fast state.
_LEAST_ROUND = 0.1


class Contender(NamedTuple):
    """Code to be timed.

    Attributes:
        works: Its work, or several parts of it.
        pieces: How many states, motions or pairs all parts have together.
        overheads: What is taken off, part by part.
    """

    works: Sequence[Work]
    pieces: int = 1
    overheads: Sequence[Work] = ()


class Times(NamedTuple):
    """What was measured.

    Attributes:
        seconds: A piece of each contender, overheads taken off.
        differ: How many times longer each took in its turns forwards than backwards, or the other way round.
    """

    seconds: dict[str, float]
    differ: dict[str, float]

    def noise(self, *names: str) -> float:
        """The least ratio of these contenders' times that says anything: by their turns, and most contenders'."""
        return max(median(self.differ.values()), *(self.differ[name] for name in names))

    def row(self, name: str) -> tuple[str, float, float, float]:
        """The fields of a contender's `TimedRow`."""
        first = next(iter(self.seconds))
        spent = self.seconds[name]
        return name, 1e6 * spent, spent / self.seconds[first], self.noise(first, name)


@dataclass(frozen=True)
class TimedRow:
    """The time of one contender; rows of measurements add what else they found.

    Attributes:
        method: Its name.
        microseconds: The least time a piece: a state, a motion, a pair, a trajectory.
        ratio: That time over that of the first contender.
        noise: How many times longer the same code took when it ran twice: a smaller ratio says nothing.
    """

    method: str
    microseconds: float
    ratio: float
    noise: float


def measured(contenders: Mapping[str, Contender], rounds: int) -> Times:
    """Times contenders by turns, two turns at least; `rounds` as for `least_seconds`."""
    off = {f"{name}, taken off": each.overheads for name, each in contenders.items() if each.overheads}
    halves = _least_of_halves({**{name: each.works for name, each in contenders.items()}, **off}, max(2, rounds))
    spent = {name: _least(each) for name, each in halves.items()}
    seconds = {
        name: (spent[name] - spent.get(f"{name}, taken off", 0.0)) / max(each.pieces, 1)
        for name, each in contenders.items()
    }
    twice = {name: sorted(halves[name].sum(axis=1).tolist()) for name in contenders}
    return Times(seconds, {name: high / low for name, (low, high) in twice.items()})


def available(name: str, make: Callable[[], Made], skipped: Callable[[str], None], at: str = "") -> Made | None:
    """What `make` makes of a contender; None where its library is missing or refuses: `skipped` is told so."""
    try:
        return make()
    except (PlannercheckError, ImportError) as error:
        skipped(f"{name} is left out{at}: {error}")
        return None


def in_turns(names: Iterable[str], rounds: int) -> Iterator[str]:
    """All names in each round, every other round backwards."""
    listed = list(names)
    for turn in range(rounds):
        yield from listed if turn % 2 == 0 else reversed(listed)


def least_seconds(contenders: Contenders, rounds: int) -> dict[str, float]:
    """Runs all contenders in each round, every other round backwards.

    Args:
        contenders: What to time, by name; parts of one contender take turns with those of the others, and one with
            fewer parts begins again, so that all run equally often.
        rounds: How often, at least 1, and more often if that is over soon; the first warms caches up and counts as any
            other, as only minima matter.

    Returns:
        The least seconds of each: of its parts, added up.
    """
    return {name: _least(halves) for name, halves in _least_of_halves(contenders, rounds).items()}


def _least(halves: Floats) -> float:
    return float(halves.min(axis=0).sum())


def _least_of_halves(contenders: Contenders, rounds: int) -> dict[str, Floats]:
    """Of each the least seconds (2, parts) of the turns forwards and of those backwards: the same code twice."""
    parts = {name: [work] if callable(work) else list(work) for name, work in contenders.items()}
    best = {name: np.full((2, len(works)), np.inf) for name, works in parts.items()}
    end = time.thread_time() + rounds * _LEAST_ROUND
    turn = 0
    while turn < rounds or time.thread_time() < end:
        half = turn % 2
        for step in range(max(map(len, parts.values()), default=0)):
            for name in list(parts) if half == 0 else reversed(list(parts)):
                k = step % len(parts[name])
                best[name][half, k] = min(best[name][half, k], seconds_of(parts[name][k]))
        turn += 1
    return best


def one_by_one(judge: Callable[..., bool], *arguments: Iterable[Any]) -> Bools:
    """Verdicts of calls from Python, with nothing else of Python's between two of them.

    A comprehension and NumPy's array of its list would add a tenth to a single state's time.
    """
    return np.frombuffer(bytes(map(judge, *arguments)), dtype=bool)


def seconds_of(work: Callable[[], object]) -> float:
    """Seconds of the processor that one run takes in this thread; the mean of several, where it is short.

    Short work runs once before: it would else be timed with what other contenders have left in the caches, while long
    work is timed with its own.
    """
    start = time.thread_time()
    work()
    spent = time.thread_time() - start
    if spent >= _SHORTEST:
        return spent
    start, runs, spent = time.thread_time(), 0, 0.0
    while spent < _SHORTEST:
        work()
        runs += 1
        spent = time.thread_time() - start
    return spent / runs
