"""A checker's pairs, compiled twice: those that can meet within the joint limits, and all of them.

In: pairs, and which of them can't meet within the limits. Out: `CompiledTables`, which judges configurations within the
limits by the smaller table and all others by the larger one. The table of all pairs is compiled when a configuration
beyond the limits, or a given pose, first needs it.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from plannercheck.checking.apart_cells import PairsInCells
from plannercheck.checking.compiled_pairs import CompiledPairs, PairSource, body_placements
from plannercheck.common.array_types import Bools, Floats, Ints
from plannercheck.common.arrays import Configuration
from plannercheck.common.core import core
from plannercheck.common.counters import sum_counters
from plannercheck.robots.unit_lengths import UNIT_TOLERANCE

JudgeOfRow: TypeAlias = Callable[[Configuration], bool | None]
JudgeOfSet: TypeAlias = Callable[[Any, int], NDArray[np.uint8] | None]


class CompiledTables:
    """Both tables of a checker. Immutable except for the table that is compiled later; threads may share it.

    Attributes:
        limits: Least and largest configuration, (nq,) each: between them only pairs of `within_limits` can collide.
            None if the limits rule out no pair and no pair is in cells.
        within_limits: The pairs that can meet within the limits.
        in_cells: Cells of joint values in which some of these pairs are apart, by their index among them.
    """

    def __init__(
        self, source: PairSource, pairs: Ints, unreachable: Bools, in_cells: Sequence[PairsInCells] = ()
    ) -> None:
        """Compiles the pairs that can meet within the limits.

        Args:
            source: The inputs of both tables.
            pairs: (k, 2) indices of bodies.
            unreachable: (k,) which of them can't meet at any configuration within the robot's limits.
            in_cells: Cells of joint values in which some of the other pairs are apart, by their index among the others.
        """
        self._source, self._pairs, self.in_cells = source, pairs, tuple(in_cells)
        is_within_limits = unreachable.any() or len(in_cells) > 0
        self.limits = (source.robot.lower, source.robot.upper) if is_within_limits else None
        self.within_limits = CompiledPairs(source, pairs, np.flatnonzero(~unreachable), self.limits, in_cells)
        self._all_pairs: CompiledPairs | None = self.within_limits if self.limits is None else None
        self._lock = threading.RLock()  # re-entrant: a finaliser may run, and ask, while this thread compiles

    @property
    def all(self) -> CompiledPairs:
        """All pairs, for configurations beyond the limits and for given poses; compiled when first needed."""
        if self._all_pairs is None:
            with self._lock:
                if self._all_pairs is None:
                    self._all_pairs = CompiledPairs(self._source, self._pairs)
        return self._all_pairs

    def mounts(self, kernel: core.Kinematics) -> tuple[Ints, Floats]:
        """The links that all bodies hang on, and their poses there, if the kernel poses the links."""
        source = self._source
        return source.mounts if source.kernel is kernel else body_placements(source.robot, source.bodies, kernel)

    def judged(self, judge: Callable[..., NDArray[Any]], *rows: NDArray[Any]) -> NDArray[Any]:
        """Judges each row by the table that counts for it.

        Args:
            judge: A function that takes compiled pairs and some of the rows, and returns an array (n,).
            rows: Arrays (n, …); a row counts as within the limits if all its configurations are.

        Returns:
            (n,).
        """
        beyond = self._beyond_limits(*rows)
        if not beyond.any():
            return np.asarray(judge(self.within_limits, *rows))
        if beyond.all():
            return np.asarray(judge(self.all, *rows))
        within = judge(self.within_limits, *(array[~beyond] for array in rows))
        out = np.empty(len(beyond), dtype=within.dtype)
        out[~beyond], out[beyond] = within, judge(self.all, *(array[beyond] for array in rows))
        return out

    def _beyond_limits(self, *rows: NDArray[Any]) -> Bools:
        """(n,) whether some configuration of each row is; False where all pairs are tested anyway."""
        beyond = np.zeros(len(rows[0]), dtype=bool)
        for q in rows:
            if self.limits is not None and q.ndim == 2:
                outside = (q < self.limits[0]) | (q > self.limits[1])
                if outside.any():
                    beyond |= outside.any(axis=1)
        return beyond

    def judges(self, kernel: core.Kinematics | None) -> tuple[JudgeOfRow, JudgeOfSet]:
        """Compiled judges of a row (nq,), and of sets (n, nq) on some threads, 1 for free.

        They return None where Python has to judge. `kernel` poses the links.
        """
        if kernel is None:
            return never_known, never_known
        pairs, lengths = self.within_limits.core, self._source.robot.configuration_map.lengths
        units = np.array(lengths.columns, dtype=np.int32).reshape(-1, 2), min(UNIT_TOLERANCE, lengths.harmless)
        of_row, of_set = core.row_validity(pairs, kernel, *units), core.set_validity(pairs, kernel, *units)
        return cast(JudgeOfRow, of_row), cast(JudgeOfSet, of_set)

    def check_states(self, kernel: core.Kinematics, rows: Floats, threads: int) -> Bools:
        """(n,) whether each configuration (n, nq) is free of collision; `kernel` poses the links."""
        return self.judged(lambda table, part: table.core.check_states(kernel, part, threads).view(bool), rows)

    def state_validity(
        self, kernel: core.Kinematics | None, states: Any = None, failure: Any = None
    ) -> Callable[[Any], bool] | None:
        """A compiled judge of OMPL's states, None if there is none; arguments as for `StateChecker.state_validity`.

        It refers to these tables but not to a checker, so that a checker may keep what refers to the judge.
        """
        robot = self._source.robot
        if kernel is None or robot.configuration_map.units:
            return None

        def beyond_limits(row: list[float]) -> bool:
            return bool(self.check_states(kernel, robot.check_configurations(row), 1)[0])

        judge = core.state_validity(self.within_limits.core, kernel, beyond_limits, states, failure)
        return cast(Callable[[Any], bool], judge)

    def statistics(self) -> dict[str, Any]:
        """Counters of all calls so far; every pair of every state counts once, pairs that were left out included."""
        counted = dict(self.within_limits.core.statistics())
        unreachable = (len(self._pairs) - len(self.within_limits.rows)) * counted["states"]
        counted["pairs"] += unreachable
        if self.limits is not None and self._all_pairs is not None:
            counted = sum_counters([counted, self._all_pairs.core.statistics()])
        return {"states": counted.pop("states"), "pairs": counted.pop("pairs"), "unreachable": unreachable, **counted}


def never_known(q: Configuration, threads: int = 1) -> None:
    """A judge without verdicts, for robots that the kernel does not pose, and for scenes that move."""
