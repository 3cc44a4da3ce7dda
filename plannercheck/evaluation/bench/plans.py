"""Plans for the problems of MotionBenchMaker sets: how long searches take, and whether their plans hold.

In: the tasks of a set. Out: a row for each planner of planners.py. Planners take turns, with several seeds; each search
is repeated, and the least time of each counts. Plans are taken as found, without shortening.

Every plan is then judged by `Checker.check_motions`. A plan collides if a state on one of its motions collides by the
exact verdict. Its depth is the depth of the deepest of `STATES` states a motion (by the bounds of
`Checker.clearances`): the least move that separates the state's deepest pair of bodies (`pc.depth`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from plannercheck.bodies.penetration_depth import depth
from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench.planners import PLANNERS, Found, Planner, Settings
from plannercheck.evaluation.bench.problems import Task
from plannercheck.evaluation.bench.solid_checkers import posed_pair
from plannercheck.evaluation.bench.timing import in_turns
from plannercheck.motions.checker import Checker

STATES = 200


@dataclass(frozen=True)
class PlanRow:
    """What one planner did on a set.

    Attributes:
        set: Its name.
        planner: Its name.
        tried: Searches: problems times seeds.
        solved: Number of searches that found a path.
        median_ms: Median of these searches, ms of processor time.
        mean_ms: Their mean.
        p95_ms: Their 95 % quantile.
        call_median_ms: The median of the whole call; None where there is no other call than the search.
        refused: Plans with a motion that is not proved free.
        colliding: Plans with a state that collides.
        deepest_median_mm: Over these, the median of their deepest pair's depth.
        deepest_mm: The greatest of these.
    """

    set: str
    planner: str
    tried: int
    solved: int
    median_ms: float | None
    mean_ms: float | None
    p95_ms: float | None
    call_median_ms: float | None
    refused: int
    colliding: int
    deepest_median_mm: float | None
    deepest_mm: float | None


@dataclass
class Tally:
    """What one planner did so far.

    Attributes:
        searches: Seconds of each search that found a path.
        calls: Seconds of the whole calls.
        tried: Searches.
        refused: Plans with a motion that is not proved free.
        depths: m, of the plans that collide.
    """

    searches: list[float] = field(default_factory=list)
    calls: list[float] = field(default_factory=list)
    tried: int = 0
    refused: int = 0
    depths: list[float] = field(default_factory=list)

    def add(self, checker: Checker, found: Found) -> None:
        """Counts a search, and judges its plan."""
        self.tried += 1
        if found.path is None:
            return
        self.searches.append(found.search)
        if found.call is not None:
            self.calls.append(found.call)
        refused = np.flatnonzero(~checker.check_motions(found.path[:-1], found.path[1:]))
        self.refused += len(refused) > 0
        deepest = _deepest_state(checker, found.path, refused.tolist())
        if deepest is not None:
            self.depths.append(_deepest_pair(checker, deepest))

    def merge(self, other: Tally) -> None:
        """Adds another tally."""
        self.searches += other.searches
        self.calls += other.calls
        self.depths += other.depths
        self.tried += other.tried
        self.refused += other.refused

    def row(self, name: str, planner: str) -> PlanRow:
        """As a row for a set of this name."""
        ms, calls, mm = (1e3 * np.array(values) for values in (self.searches, self.calls, self.depths))
        return PlanRow(
            name,
            planner,
            self.tried,
            len(ms),
            float(np.median(ms)) if len(ms) else None,
            float(ms.mean()) if len(ms) else None,
            float(np.quantile(ms, 0.95)) if len(ms) else None,
            float(np.median(calls)) if len(calls) else None,
            self.refused,
            len(mm),
            float(np.median(mm)) if len(mm) else None,
            float(mm.max()) if len(mm) else None,
        )


def measure(
    tasks: Iterable[Task],
    seeds: Sequence[int],
    settings: Settings,
    rounds: int,
    skipped: Callable[[str], None] = lambda reason: None,
) -> dict[str, Tally]:
    """Plans all tasks of a set with each seed: a tally a planner. The least time of a search's `rounds` counts."""
    tallies = {name: Tally() for name, _ in PLANNERS}
    missing: set[str] = set()
    for task in tasks:
        _ = task.checker.motion_certifier  # built once a scene, as the peers' geometry is
        planners: dict[str, Planner] = {}
        for name, make in PLANNERS:
            try:
                planners[name] = make(task, settings)
            except (PlannercheckError, ImportError) as error:
                if name not in missing:
                    skipped(f"{name} is left out: {error}")
                    missing.add(name)
        for seed in seeds:
            for name, found in _by_turns(planners, seed, rounds).items():
                tallies[name].add(task.checker, found)
    return {name: tally for name, tally in tallies.items() if tally.tried}


def _by_turns(planners: dict[str, Planner], seed: int, rounds: int) -> dict[str, Found]:
    """What each planner found, with its least times."""
    best: dict[str, Found] = {}
    for name in in_turns(planners, rounds):
        found = planners[name](seed)
        before = best.get(name, found)
        calls = [call for call in (before.call, found.call) if call is not None]
        best[name] = found._replace(search=min(before.search, found.search), call=min(calls, default=None))
    return {name: best[name] for name in planners}


def _deepest_state(checker: Checker, path: Floats, refused: Sequence[int]) -> Floats | None:
    """The state (nq,) that collides deepest on some motions of a path; None if no state on them collides."""
    part = np.linspace(0, 1, STATES)[:, None]
    deepest: tuple[float, Floats] | None = None
    for k in refused:
        verdict = checker.explain_motion(path[k], path[k + 1])
        states = (1 - part) * path[k] + part * path[k + 1]
        if verdict.collides_at is not None:
            near = (1 - verdict.collides_at) * path[k] + verdict.collides_at * path[k + 1]
            states = np.vstack([states, near])
        colliding = states[~checker.check_states(states)]
        if len(colliding):
            bounds = -checker.clearances(colliding)
            if deepest is None or bounds.max() > deepest[0]:
                deepest = float(bounds.max()), colliding[bounds.argmax()]
    return None if deepest is None else deepest[1]


def _deepest_pair(checker: Checker, q: Floats) -> float:
    """The greatest depth of a pair at a configuration, m."""
    (poses,), (colliding,) = checker.body_poses(q[None]), checker.colliding_pairs(q[None])
    return max(depth(*posed_pair(checker, k, poses)).depth for k in np.flatnonzero(colliding).tolist())
