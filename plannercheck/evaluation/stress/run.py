"""The stress run: compares every verdict on random draws with proofs in exact arithmetic, independent of the core.

In: how many pairs, a seed, peers, processes. Out: a `StressTally`: wrong verdicts, exceptions and timeouts of every
contestant by family and gap; and a shrunk case for each of the first failures of ours. The results depend only on the
seed and the number of pairs.
"""

from __future__ import annotations

import threading
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from plannercheck.bodies import exact_reference as exact
from plannercheck.bodies.certificates import SharedPoint
from plannercheck.bodies.intersection import certify
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.tuning import METHODS, Method, pair_options
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.stress.failing_cases import Case, shrunk
from plannercheck.evaluation.stress.failure_tables import EXCEPTION, TIMEOUT, WRONG, Belongs, Key, total
from plannercheck.evaluation.stress.oracle import Oracle
from plannercheck.evaluation.stress.other_libraries import Peer
from plannercheck.evaluation.stress.posed_pairs import UNFIT, Outcome
from plannercheck.evaluation.stress.random_cases import GAPS, Draw, numbered_draw
from plannercheck.evaluation.stress.sample_bodies import Specimen
from plannercheck.evaluation.stress.supervised_process import Supervised
from plannercheck.evaluation.worker_processes import Workers, workers

# Longest time for one query, s: a thousand times what any should take.
QUERY_LIMIT = 1.0
# Every so many draws the oracle's proofs are held against all vertices, and against another oracle.
THOROUGH_DRAWS = 8
# Every so many draws the core's certificates are asked for and proved by the oracle; and, of one pair of these draws,
# by the package's own `verify`.
CERTIFIED_DRAWS = 4
# Draws that a process judges at a time.
CHUNK = 40
CERTIFICATE = "certificate"
OURS = (*METHODS, CERTIFICATE)
ORACLE = "oracle of the run"  # in the list of times; a method is called oracle, too
# Failures that are shrunk and kept; more of the same say nothing new.
KEPT = 20


@dataclass
class StressTally:
    """The results of a run.

    Attributes:
        pairs: Pairs by family, gap and truth.
        failures: Failures by contestant, kind of failure, family, gap and truth.
        unfit: Pairs that a peer has no shape for, by contestant and family, gap and truth.
        refused: Bodies that could not be prepared, by message.
        by_integers: Pairs that the compiled oracle found no proof for, so that Python's integers decided.
        cases: Failures of ours, shrunk.
        seconds: Spent by each contestant.
    """

    pairs: Counter[Key] = field(default_factory=Counter)
    failures: Counter[tuple[str, str, Key]] = field(default_factory=Counter)
    unfit: Counter[tuple[str, Key]] = field(default_factory=Counter)
    refused: Counter[str] = field(default_factory=Counter)
    by_integers: int = 0
    cases: list[Case] = field(default_factory=list)
    seconds: defaultdict[str, float] = field(default_factory=lambda: defaultdict(float))

    def merge(self, other: StressTally) -> None:
        """Adds what was found after this."""
        self.pairs.update(other.pairs)
        self.failures.update(other.failures)
        self.unfit.update(other.unfit)
        self.refused.update(other.refused)
        self.by_integers += other.by_integers
        self.cases += other.cases[: max(0, KEPT - len(self.cases))]
        for who, spent in other.seconds.items():
            self.seconds[who] += spent

    @property
    def passed(self) -> bool:
        """Whether nothing of ours failed."""
        ours = any(count for (who, _, _), count in self.failures.items() if who in OURS)
        return not ours and not self.refused

    def add(self, who: str, key: Key, outcome: Outcome) -> bool:
        """Counts an outcome of a contestant; whether it is a failure."""
        if outcome == UNFIT:
            self.unfit[who, key] += 1
            return False
        kind = outcome if isinstance(outcome, str) else WRONG
        failed = outcome is not key[2]
        self.failures[who, kind, key] += failed
        return failed

    def times_asked(self, peer: str, belongs: Belongs) -> int:
        """How many pairs a peer was asked: those for which it has both shapes."""
        unfit = sum(count for (who, key), count in self.unfit.items() if who == peer and belongs(key))
        return total(self.pairs, belongs) - unfit


class Task(NamedTuple):
    """Draws of a seed with numbers from `first` to before `past`."""

    seed: int
    first: int
    past: int
    peers: tuple[Peer[Draw], ...]


def run(
    pairs: int,
    seed: int,
    peers: Sequence[Peer[Draw]] = (),
    progress: Callable[[StressTally], object] | None = None,
    processes: int = 1,
) -> StressTally:
    """Runs the suite.

    Args:
        pairs: Least number of pairs to decide.
        seed: Seed of the random numbers; a run with more pairs starts with those of a shorter one.
        peers: Other libraries to be counted, too.
        progress: Called after each draw, or some of them.
        processes: Number of processes to use.

    Returns:
        The tally.
    """
    tally = StressTally()
    with workers(processes) as some:
        first = 0
        while (left := pairs - tally.pairs.total()) > 0:  # more than once where bodies are refused
            past = first + -(-left // len(GAPS))
            for found in _judged(some, 1 if processes == 1 else CHUNK, Task(seed, first, past, tuple(peers))):
                tally.merge(found)
                if progress is not None:
                    progress(tally)
            first = past
    return tally


def _judged(some: Workers, size: int, whole: Task) -> Iterator[StressTally]:
    """The tallies of draws, in their order, `size` at a time."""
    starts = range(whole.first, whole.past, size)
    return some.results(judge_draws, (whole._replace(first=k, past=min(k + size, whole.past)) for k in starts))


def judge_draws(task: Task) -> StressTally:
    """What is found on some draws."""
    tally = StressTally()
    for number in range(task.first, task.past):
        try:
            drawn = numbered_draw(task.seed, number)
        except PlannercheckError as error:
            tally.refused.update([_reason(error)])
            continue
        judge(drawn, tally, task.peers, number)
    return tally


def judge(drawn: Draw, tally: StressTally, peers: Sequence[Peer[Draw]], number: int) -> None:
    """Counts all outcomes on one draw, the `number`-th."""
    started = time.perf_counter()
    oracle = Oracle(drawn)
    truth, by_integers = oracle.truth(thorough=number % THOROUGH_DRAWS == 0)
    tally.seconds[ORACLE] += time.perf_counter() - started
    tally.by_integers += by_integers
    keys = [(drawn.family, gap, shared) for gap, shared in zip(GAPS, truth, strict=True)]
    tally.pairs.update(keys)
    for method in METHODS:
        started = time.perf_counter()
        outcomes = _outcomes(drawn, method)
        tally.seconds[method] += time.perf_counter() - started
        for k, outcome in enumerate(outcomes):
            if tally.add(method, keys[k], outcome) and len(tally.cases) < KEPT:
                tally.cases.append(_kept(drawn, k, method))
    others: dict[str, Callable[[Draw], Iterable[Outcome]]] = {peer.name: Supervised(peer).outcomes for peer in peers}
    if number % CERTIFIED_DRAWS == 0:
        others[CERTIFICATE] = lambda drawn: _certified(drawn, oracle, number)
    for name, ask in others.items():
        started = time.perf_counter()
        outcomes = list(ask(drawn))
        tally.seconds[name] += time.perf_counter() - started
        for key, outcome in zip(keys, outcomes, strict=True):
            tally.add(name, key, outcome)


def _reason(error: PlannercheckError) -> str:
    """An error's words without what it says of the body in question."""
    return str(error).partition(": ")[2] or str(error)


def _certified(drawn: Draw, oracle: Oracle, number: int) -> list[Outcome]:
    """What the core's certificates prove."""
    outcomes = [_proved(oracle, k) for k in range(len(GAPS))]
    k = number // CERTIFIED_DRAWS % len(GAPS)
    if outcomes[k] != _verified(drawn, k):
        outcomes[k] = EXCEPTION
    return outcomes


def _proved(oracle: Oracle, k: int) -> Outcome:
    try:
        shared = oracle.certified(k)
    except Exception:
        return EXCEPTION
    return EXCEPTION if shared is None else shared


def _verified(drawn: Draw, k: int) -> Outcome:
    try:
        certificate = certify(drawn.p.polytope, drawn.r.polytope, drawn.poses_p[k], drawn.poses_r[k])
        return isinstance(certificate, SharedPoint) if certificate.verify() else EXCEPTION
    except Exception:
        return EXCEPTION


def _outcomes(drawn: Draw, method: Method) -> list[Outcome]:
    """Our outcomes; one by one if all together take too long or throw."""
    together = _ask(drawn, method, slice(None), QUERY_LIMIT * len(GAPS))
    if together.seconds < QUERY_LIMIT and not together.failure:
        return list(together.verdicts)
    single = (_ask(drawn, method, slice(k, k + 1), QUERY_LIMIT) for k in range(len(GAPS)))
    return [answer.failure or answer.verdicts[0] for answer in single]


@dataclass
class _Answer:
    verdicts: list[bool] = field(default_factory=list)
    failure: str = ""
    seconds: float = 0.0


def _ask(drawn: Draw, method: Method, some: slice, limit: float) -> _Answer:
    """Verdicts on some poses, from a thread that is left behind when it takes too long."""
    answer = _Answer(failure=TIMEOUT)

    def work() -> None:
        started = time.perf_counter()
        try:
            p, r = drawn.p.polytope.core, drawn.r.polytope.core
            found = core.intersect_batch(p, drawn.poses_p[some], r, drawn.poses_r[some], pair_options(method))
            answer.verdicts, answer.failure = found[0].astype(bool).tolist(), ""
        except Exception:
            answer.failure = EXCEPTION
        answer.seconds = time.perf_counter() - started

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    thread.join(limit)
    return _Answer(list(answer.verdicts), answer.failure, answer.seconds)


def _kept(drawn: Draw, k: int, method: Method) -> Case:
    p, r = drawn.p, drawn.r
    name = f"{method}, gap {list(GAPS)[k]}, {drawn.label}"
    case = Case(
        name, (p.vertices, r.vertices, drawn.poses_p[k], drawn.poses_r[k]), (p.inflation_radius, r.inflation_radius)
    )
    return shrunk(case, lambda smaller: fails(smaller, method))


def fails(case: Case, method: Method) -> bool:
    """Whether a method errs on a case; one that can't be prepared does not count.

    Args:
        case: Two posed bodies.
        method: See `plannercheck.bodies.intersection.pair_options`.

    Returns:
        True if the verdict is wrong, or there is none in time.
    """
    p, r, pose_p, pose_r = case.bodies
    try:
        bodies = [Polytope(v, inflation_radius=s) for v, s in zip((p, r), case.inflation_radii, strict=True)]
    except PlannercheckError:
        return False
    first, second = (Specimen("case", body, 1.0) for body in bodies)
    answer = _ask(Draw("", "", first, second, pose_p[None], pose_r[None]), method, slice(None), QUERY_LIMIT)
    return bool(answer.failure) or answer.verdicts[0] != exact.intersects(*case.bodies, *case.inflation_radii)
