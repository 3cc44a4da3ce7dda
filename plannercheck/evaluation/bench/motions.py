"""Proved motions beside motions that other libraries sample.

In: a set of motions. Out: a row for each method of motion_methods.py. A motion that the checker proves free is free. A
refused motion counts as colliding: a peer that calls it free is wrong, unless the motion only comes within the proof's
tolerance of a collision.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from plannercheck.common.array_types import Bools
from plannercheck.evaluation.bench.motion_methods import METHODS, MotionMethod, Ready
from plannercheck.evaluation.bench.motion_sets import MotionSet
from plannercheck.evaluation.bench.timing import Contender, TimedRow, Times, available, measured


@dataclass(frozen=True)
class MotionRow(TimedRow):
    """What one method did on motions of one kind.

    Attributes:
        robot: Its name.
        where: The scene, or the problem set.
        kind: Kind of the motions.
        motions: Judged in a round.
        free: Part of them that is proved free.
        false_free: Part of the motions that it calls free though they are refused.
        false_collision: Part of the motions that it calls colliding though they are proved free.
        note: What was timed.
    """

    robot: str
    where: str
    kind: str
    motions: int
    free: float
    false_free: float
    false_collision: float
    note: str


def measure(
    motions: MotionSet,
    rounds: int,
    skipped: Callable[[str], None] = lambda reason: None,
    methods: Sequence[MotionMethod] = METHODS,
) -> list[MotionRow]:
    """Times all methods by turns; ratios are to the first one. A row for each that could be built."""
    ready: dict[str, Ready] = {}
    counts: dict[str, list[int]] = {}
    for method in methods:
        cases = motions.cases if method.most is None else motions.first(method.most)
        if (made := available(method.name, partial(method.ready, cases), skipped)) is not None:
            ready[method.name], counts[method.name] = made, [len(case.starts) for case in cases]
    contenders = {name: Contender(found.works, sum(counts[name]), found.overheads) for name, found in ready.items()}
    times = measured(contenders, rounds)
    truth = [case.checker.check_motions(case.starts, case.ends) for case in motions.cases]
    return [_row(motions, name, found, truth, counts[name], times) for name, found in ready.items()]


def _row(
    motions: MotionSet, name: str, found: Ready, truth: Sequence[Bools], counts: Sequence[int], times: Times
) -> MotionRow:
    right = np.concatenate([verdicts[:n] for verdicts, n in zip(truth, counts, strict=True)])
    said = np.concatenate([work() for work in found.works])
    return MotionRow(
        *times.row(name),
        motions.cases[0].checker.robot.name,
        motions.where,
        motions.kind,
        len(right),
        float(right.mean()),
        float((said & ~right).mean()),
        float((~said & right).mean()),
        found.note,
    )
