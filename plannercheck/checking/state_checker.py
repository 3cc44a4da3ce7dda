"""Validity of configurations of a robot in a scene.

In: a `Robot`, a `Scene`. Out: an immutable `StateChecker` whose verdicts are exact for the hulls at the poses that
forward kinematics computes in doubles. Base classes build and change it (built_checker.py), and add certificates
(checker_base.py), distances (clearance.py), points (point_queries.py), and carried objects (carrying_checker.py).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.intersection import certify_posed
from plannercheck.bodies.kinds import have_parts
from plannercheck.bodies.part_certificates import parts_met
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.shapes import GeometryObject
from plannercheck.checking.built_checker import BuiltChecker
from plannercheck.checking.carrying_checker import CarryingChecker
from plannercheck.checking.checker_base import ExplainingChecker
from plannercheck.checking.clearance import MeasuringChecker
from plannercheck.checking.named_configurations import given_configurations
from plannercheck.checking.point_queries import PointChecker
from plannercheck.checking.verdicts import PairCertificate, Verdict
from plannercheck.common.array_types import Bools, Floats, Ints
from plannercheck.common.arrays import Configuration
from plannercheck.common.compiled_first import compiled_first
from plannercheck.common.threads import MOST_THREADS, checked_threads
from plannercheck.robots.kinematic_error import largest_distance
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene


class StateChecker(BuiltChecker, ExplainingChecker, MeasuringChecker, CarryingChecker, PointChecker):
    """Exact verdicts of configurations of one robot in one scene; `Checker` adds motions."""

    robot: Robot
    scene: Scene
    bodies: tuple[GeometryObject, ...]

    __slots__ = ("_judge_row",)  # the twin of `is_valid`

    def _link_pose(self, link: str, q: ArrayLike) -> Floats:
        """(4, 4) of a link at one configuration (nq,), m."""
        index = self.robot.link_index(link)
        return np.asarray(self._link_poses(self.robot.check_configurations(self._single(q)))[0, index])

    @compiled_first("_judge_row", 1)
    def is_valid(self, q: Configuration, time: float | None = None) -> bool:
        """Whether one configuration is free of collision.

        Args:
            q: (nq,) rad and m, or each joint's value by its name. Limits are not looked at.
            time: As `times` of `check_states`.

        Returns:
            True if no pair of bodies shares a point.
        """
        row = self._single(q)  # no array of doubles or list of numbers: the compiled judge takes these
        if time is not None:
            return bool(self.check_states(row, times=time)[0])
        known = self._judge_row(np.ascontiguousarray(row[0]))
        return bool(self.check_states(row)[0]) if known is None else known

    def state_validity(self, states: Any = None, failure: Any = None) -> Callable[[Any], bool] | None:
        """A compiled function that judges states of an OMPL space of nq numbers; None if there is none.

        Its verdicts are those of `is_valid`. There is none where Pinocchio itself poses the robot, nor for
        configurations with quaternions, or cosines and sines, whose length has to be checked.

        Args:
            states: The core's PlannerStates, which reads states of the space; without it, `state[k]` is the k-th
                number, as in a RealVectorStateSpace.
            failure: The core's PlannerFailure, which keeps exceptions while a planner runs; without it, they pass
                through the planner.
        """
        return self._tables.state_validity(self._kernel, states, failure)

    def check_states(self, q: ArrayLike, threads: int = 1, *, times: ArrayLike | None = None) -> Bools:
        """Whether each configuration of a set is free of collision.

        Args:
            q: (n, nq) rad and m.
            threads: Number of threads to use.
            times: (n,) or one, s of the scene's clock: needed where something in the scene moves, else without effect.
                One configuration may have several times.

        Returns:
            (n,), True means valid.

        Raises:
            PlannercheckError: If something moves and there are no times, or a time at which the scene does not say
                where it is.
        """
        if type(threads) is int and threads >= 1:
            known = self._set_validity(q, min(threads, MOST_THREADS))
            if known is not None:
                return known.view(bool)
        rows = given_configurations(self.robot, q)
        if self._moving is not None:
            checker, rows = self.in_time(rows, times)
            return checker.check_states(rows, threads)
        threads = checked_threads(threads, len(rows))
        if self._kernel is None:
            return np.asarray(self._tables.all.core.first_of_poses(self._link_poses(rows), threads) < 0)
        return self._tables.check_states(self._kernel, rows, threads)

    def first_colliding_pair(self, q: ArrayLike, threads: int = 1, *, times: ArrayLike | None = None) -> Ints:
        """The first colliding pair of each configuration, in the order of `pairs`.

        Args:
            q: (n, nq) rad and m.
            threads: Number of threads to use.
            times: As of `check_states`.

        Returns:
            (n,) rows of `pairs`, -1 where the configuration is valid.
        """
        rows = given_configurations(self.robot, q)
        if self._moving is not None:
            checker, rows = self.in_time(rows, times)
            return checker.first_colliding_pair(rows, threads)
        threads = checked_threads(threads, len(rows))
        if self._kernel is None:
            return self._tables.all.to_table_rows(self._tables.all.core.first_of_poses(self._link_poses(rows), threads))
        return self._tables.judged(
            lambda table, part: table.to_table_rows(table.core.first_of_states(self._kernel, part, threads)), rows
        )

    def colliding_pairs(self, q: ArrayLike, *, times: ArrayLike | None = None) -> Bools:
        """Which pairs collide, without stopping at the first.

        Args:
            q: (n, nq) rad and m.
            times: As of `check_states`.

        Returns:
            (n, k) for the k rows of `pairs`.
        """
        checker, rows = self.in_time(given_configurations(self.robot, q), times)
        return checker._tables.all.colliding(checker._link_poses(rows))

    def body_poses(self, q: ArrayLike, *, times: ArrayLike | None = None) -> Floats:
        """World poses of all bodies: the very doubles that verdicts use.

        Args:
            q: (n, nq) or (nq,) rad and m.
            times: As of `check_states`.

        Returns:
            (n, bodies, 4, 4), m; NaN for bodies that no pair needs.
        """
        checker, rows = self.in_time(given_configurations(self.robot, q), times)
        return checker._tables.all.body_poses(checker._link_poses(rows))

    def explain(self, q: Configuration, separations: bool = False, *, time: float | None = None) -> Verdict:
        """The verdict of one configuration with the names and certificates behind it.

        Args:
            q: (nq,) rad and m, or each joint's value by its name.
            separations: Whether to give the planes that separate all other pairs, too.
            time: As `times` of `check_states`.

        Returns:
            The verdict; certificates are in world coordinates.
        """
        if self._moving is None:
            return super().explain(q, separations)
        checker, row = self.in_time(self._single(q), time)
        return checker.explain(row, separations)

    def _names_of_met(self, a: int, b: int, poses: Floats) -> tuple[str, str]:
        names, shapes = [self.bodies[k].name for k in (a, b)], [self.bodies[k].shape for k in (a, b)]
        p, r = self._preparation.polytope(a), self._preparation.polytope(b)
        met = parts_met(p, r, poses[a], poses[b]) if have_parts(p, r) else None
        for k, place in enumerate(met or ()):
            if place >= 0:
                shape = shapes[k]
                assert isinstance(shape, PartSet)
                names[k] += f"[{shape.part_name((p, r)[k].core.shape.part(place)[2])}]"
        return names[0], names[1]

    def _certificate(self, a: int, b: int, poses: Floats) -> PairCertificate:
        return certify_posed(self._preparation.polytope(a), self._preparation.polytope(b), poses[a], poses[b])

    def _kinematic_error(self, q: Floats, poses: Floats) -> float:
        """The proven bound for the poses (bodies, 4, 4) of one configuration (nq,), m.

        The error of Pinocchio's poses is at most that of the kernel's plus the difference of the two.
        """
        error = self.robot.kinematic_error_at(q)
        if self._kernel is None and self.robot.kinematics is not None:
            by_kernel = self._tables.all.body_poses(self.robot.link_poses(q[None]))[0]
            error += largest_distance(self.bodies, poses, by_kernel)
        return error

    def statistics(self) -> dict[str, Any]:
        """Counters of all calls so far: states, pairs, what settled them, and the pair test's queries.

        Every pair of every state is counted once: as unreachable; by the stage that settled it; or as skipped, where
        another colliding pair had decided the state.
        """
        return self.with_all_columns._tables.statistics()

    def __repr__(self) -> str:
        return f"Checker({self.robot.name!r} in {self.scene.name!r}, {len(self.pairs)} pairs)"
