"""The stress of sets of parts: random draws, every verdict compared with the oracle's, in any number of processes.

In: how many pairs, a seed. Out: a `PartTally`: wrong verdicts, exceptions and timeouts of every contestant by family
and offset; and a case for each of the first failures. Every draw has random numbers of its own, so the results do not
depend on the number of processes.
"""

from __future__ import annotations

import itertools
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from plannercheck.common.cache import uncached
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.stress.failure_tables import WRONG, Key
from plannercheck.evaluation.stress.posed_pairs import ANY_OFFSET, UNFIT, Outcome
from plannercheck.evaluation.stress.shared_runs import KEPT, Tally, gathered
from plannercheck.evaluation.stress_parts.bodies import Body
from plannercheck.evaluation.stress_parts.cases import PartCase, shrunk
from plannercheck.evaluation.stress_parts.draws import Draw, numbered_draw
from plannercheck.evaluation.stress_parts.judges import ASK_ALL, verdicts
from plannercheck.evaluation.stress_parts.motions import MISSED, judge_motions
from plannercheck.evaluation.stress_parts.truth import decide
from plannercheck.evaluation.worker_processes import workers

# Every so many draws of few pairs of parts, some of the oracle's verdicts are held against whole numbers alone, all
# pairs of parts.
THOROUGH_DRAWS, _THOROUGH_PAIRS, _THOROUGH_STEP = 16, 100, 7
# Every so many draws, motions are judged, too.
MOTION_DRAWS = 20
# Draws that a process judges at a time.
_CHUNK = 20


@dataclass
class PartTally(Tally[PartCase]):
    """The results of a run.

    Attributes:
        motions: Motions of a robot before sets, by family and outcome.
    """

    motions: Counter[tuple[str, str]] = field(default_factory=Counter)

    def merge(self, other: PartTally) -> None:
        """Adds what was found after this."""
        super().merge(other)
        self.motions.update(other.motions)

    @property
    def passed(self) -> bool:
        """Whether nothing failed."""
        return not self.broken and not self.failures.total() and not self.missed

    @property
    def missed(self) -> int:
        """Motions that were proved free and have a state that collides."""
        return sum(count for (_, outcome), count in self.motions.items() if outcome == MISSED)


class Task(NamedTuple):
    """Draws with numbers from `first` to before `past`."""

    seed: int
    first: int
    past: int


def run(
    pairs: int,
    seed: int,
    progress: Callable[[PartTally], object] | None = None,
    processes: int = 1,
) -> PartTally:
    """Runs the suite.

    Args:
        pairs: Least number of pairs to decide.
        seed: Seed of the random numbers; a run with more pairs starts with those of a shorter one.
        progress: Called after some of the draws.
        processes: Number of processes to use.

    Returns:
        The tally.
    """
    with uncached(), workers(processes) as some:  # no one will meet these bodies again
        return gathered(PartTally(), some.results(judge_draws, _tasks(seed)), pairs, progress)


def _tasks(seed: int) -> Iterator[Task]:
    return (Task(seed, first, first + _CHUNK) for first in itertools.count(0, _CHUNK))


def judge_draws(task: Task) -> PartTally:
    """What is found on some draws."""
    tally = PartTally()
    for number in range(task.first, task.past):
        began = time.process_time()
        try:
            drawn = numbered_draw(task.seed, number)
            tally.seconds["draws"] += time.process_time() - began
            judge(drawn, tally, number)
            began = time.process_time()
            if number % MOTION_DRAWS == 0:
                tally.motions.update(judge_motions(task.seed, number))
            tally.seconds["motions"] += time.process_time() - began
        except (PlannercheckError, ValueError, AssertionError) as error:
            tally.broken[f"draw {number}: {error}"] += 1
    return tally


def judge(drawn: Draw, tally: PartTally, number: int) -> None:
    """Counts all outcomes on one draw, the `number`-th."""
    began = time.process_time()
    truth = truth_of(drawn, number)
    tally.draws += 1
    keys = [(drawn.family, name, shared) for name, shared in zip(drawn.offsets, truth, strict=True)]
    tally.pairs.update(keys)
    tally.seconds["oracle"] += time.process_time() - began
    began = time.process_time()
    for who, outcomes in verdicts(drawn, truth, number).items():
        for k, outcome in enumerate(outcomes):
            if _count(tally, who, keys[k], outcome) and len(tally.cases) < KEPT:
                tally.cases.append(_kept(drawn, k, f"draw {number}, pose {k}, {who}"))
    tally.seconds["ours"] += time.process_time() - began


def truth_of(drawn: Draw, number: int = 1) -> list[bool]:
    """The oracle's verdicts (k,); AssertionError where it contradicts itself."""
    found = decide(drawn.p, drawn.poses_p, drawn.r, drawn.poses_r)
    of_second = 1 if drawn.r.half_space is not None else len(drawn.r.pieces)
    few = 0 < len(drawn.p.pieces) * of_second <= _THOROUGH_PAIRS
    if number % THOROUGH_DRAWS == 0 and few:
        some = slice(number // THOROUGH_DRAWS % _THOROUGH_STEP, None, _THOROUGH_STEP)
        again = decide(drawn.p, drawn.poses_p[some], drawn.r, drawn.poses_r[some], every=True)
        if not np.array_equal(again, found[some]):
            raise AssertionError(f"the oracle contradicts itself: {drawn.label}")
    return list(found.tolist())


def _count(tally: PartTally, who: str, key: Key, outcome: Outcome) -> bool:
    """Counts an outcome; whether it is a failure."""
    if outcome == UNFIT:
        return False
    tally.asked[who, key] += 1
    if outcome is key[2]:
        return False
    tally.failures[who, outcome if isinstance(outcome, str) else WRONG, key] += 1
    return True


def _kept(drawn: Draw, k: int, what: str) -> PartCase:
    """The case of a failure, smaller if it fails without the others, too."""
    name = f"{what}, offset {drawn.offsets[k]}, {drawn.label}"
    case = PartCase(name, drawn.p.given, drawn.r.given, drawn.poses_p[k], drawn.poses_r[k])
    return shrunk(case, lambda smaller: bool(faults_of(smaller))) if faults_of(case) else case


def faults_of(case: PartCase) -> dict[str, Outcome]:
    """Contestants that fail on a case, and how; a body that can't be prepared does not count."""
    p, r = Body("case", case.p), Body("case", case.r)
    drawn = Draw("case", case.name, p, r, case.pose_p[None], case.pose_r[None], (ANY_OFFSET,))
    try:
        truth = truth_of(drawn)
        _ = p.polytope, r.polytope
    except (PlannercheckError, ValueError):
        return {}
    faults = dict[str, Outcome]()
    for number in ASK_ALL:
        told = verdicts(drawn, truth, number)
        faults |= {who: said[0] for who, said in told.items() if said[0] not in (truth[0], UNFIT)}
    return faults
