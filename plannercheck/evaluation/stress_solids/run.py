"""The stress of solids: random draws, every verdict compared with the oracle's, in any number of processes.

In: how many pairs, a seed, peers. Out: a `SolidTally`: wrong verdicts, exceptions and timeouts of every contestant by
family and offset; and a shrunk case for each of the first failures of ours. Every draw has random numbers of its own,
so the results do not depend on the number of processes.
"""

from __future__ import annotations

import itertools
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from plannercheck.common.cache import uncached
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.stress.failure_tables import WRONG, Key
from plannercheck.evaluation.stress.other_libraries import Peer
from plannercheck.evaluation.stress.posed_pairs import ANY_OFFSET, UNFIT, Outcome
from plannercheck.evaluation.stress.shared_runs import KEPT, Tally, gathered
from plannercheck.evaluation.stress.supervised_process import Supervised
from plannercheck.evaluation.stress_solids.bodies import decided
from plannercheck.evaluation.stress_solids.cases import SolidCase, shrunk
from plannercheck.evaluation.stress_solids.draws import Draw, numbered_draw
from plannercheck.evaluation.stress_solids.judges import OURS, verdicts
from plannercheck.evaluation.stress_solids.robot_links import link_draw
from plannercheck.evaluation.worker_processes import workers

# Every so many draws of few pairs of triangles, some of the oracle's verdicts are held against whole numbers alone, all
# pairs of triangles and every vertex.
THOROUGH_DRAWS, _THOROUGH_PAIRS, _THOROUGH_STEP = 16, 2000, 7
# Draws that a process judges at a time.
_CHUNK = 20
# The reasons of the oracle that say so (cpp/oracle/mesh_pairs.hpp).
_INSIDE = (3, 4)


@dataclass
class SolidTally(Tally[SolidCase]):
    """The results of a run.

    Attributes:
        inside: Of the pairs, those that share a point since a part of one body is inside the other.
    """

    inside: Counter[Key] = field(default_factory=Counter)

    def merge(self, other: SolidTally) -> None:
        """Adds what was found after this."""
        super().merge(other)
        self.inside.update(other.inside)

    @property
    def passed(self) -> bool:
        """Whether nothing of ours failed."""
        return not self.broken and not any(count for (who, _, _), count in self.failures.items() if who in OURS)


class Task(NamedTuple):
    """Draws with numbers from `first` to before `past`."""

    seed: int
    first: int
    past: int
    peers: tuple[Peer[Draw], ...]
    of_links: bool = False


def run(
    pairs: int,
    seed: int,
    peers: Sequence[Peer[Draw]] = (),
    progress: Callable[[SolidTally], object] | None = None,
    processes: int = 1,
    of_links: bool = False,
) -> SolidTally:
    """Runs the suite.

    Args:
        pairs: Least number of pairs to decide.
        seed: Seed of the random numbers; a run with more pairs starts with those of a shorter one.
        peers: Other libraries to be counted, too.
        progress: Called after some of the draws.
        processes: Number of processes to use.
        of_links: Whether bodies are links of the shipped robots, not of families.

    Returns:
        The tally.
    """
    with uncached(), workers(processes) as some:  # no one will meet these bodies again
        return gathered(SolidTally(), some.results(judge_draws, _tasks(seed, tuple(peers), of_links)), pairs, progress)


def _tasks(seed: int, peers: tuple[Peer[Draw], ...], of_links: bool) -> Iterator[Task]:
    return (Task(seed, first, first + _CHUNK, peers, of_links) for first in itertools.count(0, _CHUNK))


def judge_draws(task: Task) -> SolidTally:
    """What is found on some draws."""
    tally = SolidTally()
    for number in range(task.first, task.past):
        began = time.process_time()
        try:
            drawn = (link_draw if task.of_links else numbered_draw)(task.seed, number)
            tally.seconds["draws"] += time.process_time() - began
            judge(drawn, tally, task.peers, number)
        except (PlannercheckError, ValueError, AssertionError) as error:
            tally.broken[f"draw {number}: {error}"] += 1
    return tally


def judge(drawn: Draw, tally: SolidTally, peers: Sequence[Peer[Draw]], number: int) -> None:
    """Counts all outcomes on one draw, the `number`-th."""
    began = time.process_time()
    reasons = truth_of(drawn, number).tolist()
    truth = [reason != 0 for reason in reasons]
    tally.draws += 1
    keys = [(drawn.family, name, shared) for name, shared in zip(drawn.offsets, truth, strict=True)]
    tally.pairs.update(keys)
    tally.inside.update(key for key, reason in zip(keys, reasons, strict=True) if reason in _INSIDE)
    tally.seconds["oracle"] += time.process_time() - began
    began = time.process_time()
    for who, outcomes in verdicts(drawn, truth, number).items():
        failed = [k for k, outcome in enumerate(outcomes) if _count(tally, who, keys[k], outcome)]
        if failed and len(tally.cases) < KEPT:
            tally.cases.append(_kept(drawn, failed[0], who, number))
    tally.seconds["ours"] += time.process_time() - began
    for peer in peers:
        began = time.perf_counter()
        for key, outcome in zip(keys, Supervised(peer).outcomes(drawn), strict=True):
            _count(tally, peer.name, key, outcome)
        tally.seconds[peer.name] += time.perf_counter() - began


def truth_of(drawn: Draw, number: int = 1) -> Any:
    """The oracle's reasons (k,); AssertionError where it contradicts itself."""
    found = decided(drawn.p, drawn.poses_p, drawn.r, drawn.poses_r)
    few = len(drawn.p.surface.triangles) * len(drawn.r.surface.triangles) <= _THOROUGH_PAIRS
    if number % THOROUGH_DRAWS == 0 and few:
        some = slice(number // THOROUGH_DRAWS % _THOROUGH_STEP, None, _THOROUGH_STEP)
        again = decided(drawn.p, drawn.poses_p[some], drawn.r, drawn.poses_r[some], every=True)
        if ((again != 0) != (found[some] != 0)).any():
            raise AssertionError(f"the oracle contradicts itself: {drawn.label}")
    return found


def _count(tally: SolidTally, who: str, key: Key, outcome: Outcome) -> bool:
    """Counts an outcome; whether it is a failure."""
    if outcome == UNFIT:
        return False
    tally.asked[who, key] += 1
    failed = outcome is not key[2]
    tally.failures[who, outcome if isinstance(outcome, str) else WRONG, key] += failed
    return failed


def _kept(drawn: Draw, k: int, who: str, number: int) -> SolidCase:
    """The case of a failure, smaller if it fails without the others, too."""
    case = SolidCase(
        f"draw {number}, {who}, offset {drawn.offsets[k]}, {drawn.label}",
        drawn.p,
        drawn.r,
        drawn.poses_p[k],
        drawn.poses_r[k],
    )
    return shrunk(case, lambda smaller: bool(faults_of(smaller))) if faults_of(case) else case


def faults_of(case: SolidCase) -> dict[str, Outcome]:
    """Contestants that fail on a case, and how; a body that can't be prepared does not count."""
    drawn = Draw("case", case.name, case.p, case.r, case.pose_p[None], case.pose_r[None], (ANY_OFFSET,))
    try:
        truth = [bool(reason) for reason in decided(case.p, drawn.poses_p, case.r, drawn.poses_r)]
        _ = case.p.polytope, case.r.polytope
    except (PlannercheckError, ValueError):
        return {}
    found = verdicts(drawn, truth, 0)
    return {who: outcomes[0] for who, outcomes in found.items() if outcomes[0] is not truth[0] and outcomes[0] != UNFIT}
