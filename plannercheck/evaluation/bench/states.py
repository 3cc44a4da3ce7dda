"""Run time against error on the states of a robot in a scene, for all methods of methods.py.

In: a checker, configurations. Out: a row for each method. The exact verdicts are the truth. A method is wrong in a
state that it calls free although it collides ("false free"), or the other way round. With solids, states whose only
collisions are bodies inside others are counted separately, since other libraries take meshes as surfaces.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench.build_cost import built
from plannercheck.evaluation.bench.methods import Method
from plannercheck.evaluation.bench.solid_checkers import has_solids, nested_pairs
from plannercheck.evaluation.bench.timing import Contender, TimedRow, Times, measured, seconds_of
from plannercheck.motions.checker import Checker

Report = Callable[[str], None]

# Seconds that a method works at a time, and the most parts into which its states are split for that.
_PART = 2e-3
_MOST_PARTS = 32


@dataclass(frozen=True)
class StateRow(TimedRow):
    """What one method did on one robot in one scene.

    Attributes:
        robot: Its name.
        scene: Its name.
        pairs: Pairs of bodies a state.
        which: "random" states, or states "along motions".
        kind: The kind of method (methods.py).
        states: States judged in a round.
        valid: Part of them that is valid, exactly.
        false_free: Part of the states that it calls free though they collide.
        false_collision: Part of the states that it calls colliding though they are free.
        false_free_inside: Those of the false free ones in which bodies collide only by one being inside the other, so
            that no surfaces meet; None where there are no solids.
        error: How far its bodies are off at most, m: computed for stand-ins, stated for coal; None where unknown.
        resident: Bytes that building it took; None where the system does not tell.
        preparation: Seconds that building it took, without the disk cache.
        note: Says what was timed, and how.
    """

    robot: str
    scene: str
    pairs: int
    which: str
    kind: str
    states: int
    valid: float
    false_free: float
    false_collision: float
    false_free_inside: float | None
    error: float | None
    resident: int | None
    preparation: float
    note: str


@dataclass(frozen=True)
class _Ready:
    """A method that is built and warm.

    Attributes:
        method: The method.
        works: Judge its states, in parts.
        overheads: What is taken off, part by part; none for most.
        states: Number of states.
        verdicts: Verdicts of these states.
        error: See `StateRow`, as the following.
        resident: Resident memory, bytes.
        preparation: Time of the preparation, s.
        note: What was timed.
    """

    method: Method
    works: Sequence[Callable[[], Bools]]
    overheads: Sequence[Callable[[], object]]
    states: int
    verdicts: Bools
    error: float | None
    resident: int | None
    preparation: float
    note: str


def measure(
    checker: Checker,
    methods: Sequence[Method],
    q: Floats,
    rounds: int,
    skipped: Report = lambda reason: None,
    which: str = "random",
) -> list[StateRow]:
    """Times all methods by turns on configurations (n, nq): a row for each that could be built, ratios to the first.

    Slow methods judge the first of the configurations. `which` names these in the rows.
    """
    ready = [found for method in methods if (found := _ready(method, q, skipped)) is not None]
    times = measured({item.method.name: Contender(item.works, item.states, item.overheads) for item in ready}, rounds)
    truth = checker.check_states(q)

    @cache
    def is_nested(state: int) -> bool:
        return bool(nested_pairs(checker, q[state])[1].all())

    inside = is_nested if has_solids(checker) else None
    return [_row(checker, which, item, truth, inside, times) for item in ready]


def _ready(method: Method, q: Floats, skipped: Report) -> _Ready | None:
    try:
        made = built(method.build)
        rows = np.ascontiguousarray(q[: method.states])
        prepared = method.prepare(made.value, rows)
        verdicts = method.judge(made.value, prepared)
        spent = seconds_of(lambda: method.judge(made.value, prepared))
    except (PlannercheckError, ImportError) as error:
        skipped(f"{method.name} is left out: {error}")
        return None

    parts = [method.prepare(made.value, part) for part in _parts(rows, spent)]
    works = [partial(method.judge, made.value, part) for part in parts]
    overheads = [partial(method.overhead, made.value, part) for part in parts] if method.overhead else []
    note = method.note if method.described is None else method.described(made.value)
    off = method.error(made.value)
    return _Ready(method, works, overheads, len(rows), verdicts, off, made.resident, made.seconds, note)


def _parts(rows: Floats, seconds: float) -> list[Floats]:
    """Of rows that take some seconds, so that each takes about as long as those of other methods."""
    return np.array_split(rows, int(np.clip(round(seconds / _PART), 1, min(_MOST_PARTS, len(rows)))))


def _row(
    checker: Checker,
    which: str,
    item: _Ready,
    truth: Bools,
    is_nested: Callable[[int], bool] | None,
    times: Times,
) -> StateRow:
    right = truth[: item.states]
    missed = item.verdicts & ~right
    return StateRow(
        *times.row(item.method.name),
        checker.robot.name,
        checker.scene.name,
        len(checker.pairs),
        which,
        item.method.kind,
        item.states,
        float(right.mean()),
        float(missed.mean()),
        float((~item.verdicts & right).mean()),
        None if is_nested is None else sum(map(is_nested, np.flatnonzero(missed).tolist())) / len(missed),
        item.error,
        item.resident,
        item.preparation,
        item.note,
    )
