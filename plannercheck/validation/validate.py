"""Validation of a set of configurations: verdicts, and their summary.

In: a checker and configurations. Out: the first colliding pair of each, and a `ValidityReport`.
"""

from __future__ import annotations

import time
import warnings
from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.checking.input_hints import always_hint, limits_hint
from plannercheck.checking.protocols import AnyChecker
from plannercheck.checking.verdicts import PairCount, ValidityReport, pair_counts
from plannercheck.common.array_types import Bools, Ints
from plannercheck.common.arrays import OwnsArrays

# Configurations whose verdicts on all pairs are held at once: (rows, pairs) of a byte each, and poses.
_ALL_PAIRS_ROWS = 4096


@dataclass(frozen=True, eq=False)
class Validation(OwnsArrays):
    """Verdicts on a set.

    Attributes:
        first_pair: (n,) row of the checker's pair that was first found to collide, -1 if valid.
        beyond_limits: (n,) whether some joint is beyond a limit.
        report: The summary.
    """

    first_pair: Ints
    beyond_limits: Bools
    report: ValidityReport

    @property
    def valid(self) -> Bools:
        """(n,), True means valid."""
        return np.asarray(self.first_pair < 0)


def validate(checker: AnyChecker, q: ArrayLike, threads: int = 1, all_pairs: bool = False) -> Validation:
    """Verdicts and summary of configurations (n, nq), rad and m.

    With `all_pairs`, all colliding pairs of a configuration are counted (slower); else the first found.
    """
    began = time.perf_counter()
    rows = checker.robot.check_configurations(q)
    first = checker.first_colliding_pair(rows, threads)
    counts = _all_counts(checker, rows[first >= 0]) if all_pairs else None
    duration = time.perf_counter() - began
    beyond = beyond_limits(checker, rows)
    _warn_of_doubts(checker, rows, first, beyond)
    report = ValidityReport(
        states=len(rows),
        valid=int((first < 0).sum()),
        beyond_limits=int(beyond.sum()),
        pairs=_first_counts(checker, first) if counts is None else counts,
        all_pairs=all_pairs,
        duration=duration,
    )
    return Validation(first, beyond, report)


def _warn_of_doubts(checker: AnyChecker, rows: NDArray[np.float64], first: Ints, beyond: Bools) -> None:
    """Warns of sets that are probably mistakes, e.g. in degrees."""
    if len(rows) and (first >= 0).all() and (hint := always_hint(checker, rows)):
        warnings.warn(hint, RuntimeWarning, stacklevel=3)
    if beyond.sum() > len(rows) / 2:
        warnings.warn(limits_hint(checker.robot, rows), RuntimeWarning, stacklevel=3)


def beyond_limits(checker: AnyChecker, q: NDArray[np.float64]) -> Bools:
    """Which configurations (n, nq) are beyond a joint limit."""
    lower, upper = checker.robot.lower, checker.robot.upper
    # Mostly none is, and extremes tell so in a tenth of the time.
    if not len(q) or ((q.min(axis=0) >= lower) & (q.max(axis=0) <= upper)).all():
        return np.zeros(len(q), dtype=bool)
    return np.asarray(((q < lower) | (q > upper)).any(axis=1))


def _first_counts(checker: AnyChecker, first: Ints) -> tuple[PairCount, ...]:
    counts: Counter[tuple[str, str]] = Counter()
    found = np.bincount(first + 1)[1:]  # valid ones are -1
    for pair in np.flatnonzero(found).tolist():
        counts[checker.pair_names(pair)] += int(found[pair])
    return pair_counts(counts)


def _all_counts(checker: AnyChecker, q: NDArray[np.float64]) -> tuple[PairCount, ...]:
    """Bodies of the same link or object count once a configuration."""
    members: dict[tuple[str, str], list[int]] = {}
    for pair in range(len(checker.pairs)):
        members.setdefault(checker.pair_names(pair), []).append(pair)
    counts: Counter[tuple[str, str]] = Counter()
    for start in range(0, len(q), _ALL_PAIRS_ROWS):
        colliding = checker.colliding_pairs(q[start : start + _ALL_PAIRS_ROWS])
        for names in members:
            counts[names] += int(colliding[:, members[names]].any(axis=1).sum())
    return pair_counts(counts)
