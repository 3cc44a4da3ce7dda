"""The checker behind the motion stress, with the same queries in space and in the plane.

In: a recipe. Out: a `Subject`: verdicts on motions alone, together and explained, states on them, clearances. The
clearances share no code with the proofs of motions.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.checking.verdicts import MotionVerdict
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.motion_paths import MotionPath
from plannercheck.evaluation.stress_motions.curve_numbers import numbers_of
from plannercheck.evaluation.stress_motions.recipes import (
    PlaneRecipe,
    SpaceRecipe,
    planar_checker,
    space_checker,
)
from plannercheck.evaluation.stress_motions.tube_reach import TubeReach
from plannercheck.motions.certifier_answers import MotionResult
from plannercheck.motions.motion_ends import Curves
from plannercheck.motions.trajectory_verdict import TrajectoryVerdict
from plannercheck.planar.robot import Robot as PlanarRobot
from plannercheck.proofs import Proof
from plannercheck.robots.robot import Robot
from plannercheck.trajectories.trajectory import Trajectory

# Pairs of edges taken at once, to bound memory.
_BLOCK = 256


class Subject(ABC):
    """A checker, asked about motions between configurations (n, nq)."""

    padding = 0.0

    def __init__(self, checker: Any, how: Mapping[str, Any]) -> None:
        """Takes a new checker, and how its robot moves, as the checker's methods take it."""
        self.checker, self.robot, self._how = checker, checker.robot, how

    def check(self, q0: Floats, q1: Floats, tolerance: float, threads: int = 1) -> Bools:
        """(n,) whether motions are free, asked all together."""
        return np.asarray(self.checker.check_motions(q0, q1, None, tolerance, threads, **self._how))

    def check_one(self, q0: Floats, q1: Floats, tolerance: float) -> bool:
        """Whether one motion (nq,) to (nq,) is free."""
        return bool(self.checker.check_motion(q0, q1, None, tolerance, **self._how))

    def explain(self, q0: Floats, q1: Floats, tolerance: float) -> MotionVerdict | TrajectoryVerdict:
        """The verdict of one motion."""
        found: MotionVerdict = self.checker.explain_motion(q0, q1, tolerance, **self._how)
        return found

    def certify(self, q0: Floats, q1: Floats, tolerance: float) -> tuple[Sequence[Proof] | None, ...]:
        """The proofs of all parts, or None, for each motion."""
        found: tuple[Proof | None, ...] = self.checker.certify_motions(q0, q1, tolerance, **self._how)
        return tuple(None if proof is None else (proof,) for proof in found)

    def motion_result(self, q0: Floats, q1: Floats, tolerance: float, proofs: bool = False) -> MotionResult:
        """What `explain_motion` is made of, without the search for the first collision."""
        start, end, *pieces = self._motion(q0, q1)
        found: MotionResult = self._certifier.motion_result(start, end, tolerance, proofs, *pieces, q1)
        return found

    def check_states(self, q: Floats) -> Bools:
        """(n,) which states (n, nq) are valid."""
        return np.asarray(self.checker.check_states(q))

    def ends(self, q0: Floats, q1: Floats) -> tuple[Floats, Floats]:
        """(n, nq) first and last states of motions."""
        return q0, q1

    def nearest(self, states: Floats, others: Floats, q1: Floats) -> Floats:
        """The states (n, nq) nearest to others (n, nq) that motions prove beside their own (n, nq): by their tubes."""
        return states

    def states(self, q0: Floats, q1: Floats, parameters: Floats) -> Floats:
        """(k, nq) of one motion at parameters (k,)."""
        start, end, *pieces = self._motion(q0, q1)
        return np.asarray(self._certifier.states(start, end, parameters, *pieces))

    @property
    def _certifier(self) -> Any:
        """What judges motions as the robot moves here."""
        return self.checker.motion_certifier

    def placed(self, q: Floats) -> Floats:
        """(n, links, …) poses of the links at configurations (n, nq)."""
        return np.asarray(self.robot.link_poses(q))

    @abstractmethod
    def clearances(self, q: Floats) -> Floats:
        """(n,) least distances at configurations (n, nq), m; at most 0 where they collide."""

    def slack(self, q0: Floats, q1: Floats) -> float:
        """How far beyond the tolerance a motion may be refused, m: what pieces of curves may be off, or by its tube."""
        return 0.0

    def rounding(self, q0: Floats) -> float:
        """By how much bodies may be off where a verdict says that they are, m: a clock cuts and rounds curves."""
        return 0.0

    @abstractmethod
    def _motion(self, q0: Floats, q1: Floats) -> tuple[Floats, ...]:
        """A motion as its certifier takes it: start, end and, in the plane, pieces."""


class SpaceSubject(Subject):
    """A checker in space."""

    def __init__(self, recipe: SpaceRecipe, robot: Robot | None = None) -> None:
        """Builds a new checker; `robot` if it was built already."""
        path: MotionPath = recipe.get("path", "screw")  # cases from before there were paths name none
        super().__init__(space_checker(recipe, robot), {"path": path})
        self.padding = float(recipe["padding"])

    @property
    def _certifier(self) -> Any:
        return self.checker.certifier_of(self._how["path"])

    def clearances(self, q: Floats) -> Floats:
        """See `Subject`."""
        return np.asarray(self.checker.clearances(q))

    def _motion(self, q0: Floats, q1: Floats) -> tuple[Floats, ...]:
        (start,), (end,), _ = self.checker._motion_ends(q0[None], q1[None])
        return start, end


class PlaneSubject(Subject):
    """A checker in the plane, and how the root moves."""

    def __init__(self, recipe: PlaneRecipe, robot: PlanarRobot | None = None) -> None:
        """Builds a new checker; `robot` if it was built already."""
        how = {"curve": recipe["curve"], "turning_radius": recipe["radius"]}
        super().__init__(planar_checker(recipe, robot), how)

    def clearances(self, q: Floats) -> Floats:
        """See `Subject`."""
        checker = self.checker
        poses = checker.body_poses(q)
        least = np.full(len(q), np.inf)
        placed = [
            body.vertices @ poses[:, k, :2, :2].transpose(0, 2, 1) + poses[:, k, None, :2, 2]
            for k, body in enumerate(checker.bodies)
        ]
        for a, b in checker.pairs.tolist():
            least = np.minimum(least, _corner_distances(placed[a], placed[b]))
        return np.where(checker.check_states(q), least, np.minimum(least, 0.0))

    def slack(self, q0: Floats, q1: Floats) -> float:
        """See `Subject`."""
        _, _, pieces = self._motion(q0, q1)
        return 4 * float(pieces[:, -1].max(initial=0.0))

    def _motion(self, q0: Floats, q1: Floats) -> tuple[Floats, ...]:
        curve, radius = self._how["curve"], self._how["turning_radius"]
        (start,), (end,), _ = self.checker._motion_ends(q0[None], q1[None], curve)
        return start, end, self.checker._motions.pieces(start, end, curve, radius)


def _corner_distances(a: Floats, b: Floats) -> Floats:
    """(n,) least distances of corners of polygons (n, k, 2), (n, l, 2) to the other's edges, either way, m.

    This is the distance of two that do not overlap.
    """
    parts = [slice(first, first + _BLOCK) for first in range(0, len(a), _BLOCK)]
    found = [np.minimum(_to_edges(a[part], b[part]), _to_edges(b[part], a[part])) for part in parts]
    return np.concatenate([np.zeros(0), *found])


def _to_edges(points: Floats, polygon: Floats) -> Floats:
    edges = np.roll(polygon, -1, axis=1) - polygon
    offsets = points[:, :, None] - polygon[:, None]
    squares = (edges**2).sum(axis=2)[:, None]
    part = np.clip((offsets * edges[:, None]).sum(axis=3) / np.where(squares > 0, squares, 1), 0, 1)
    return np.asarray(np.linalg.norm(offsets - part[..., None] * edges[:, None], axis=3).min(axis=(1, 2)))


class CurveSubject(SpaceSubject):
    """A checker in space, asked about curves, see `curves`: each is a trajectory of one piece, that takes 1 s."""

    def check(self, q0: Floats, q1: Floats, tolerance: float, threads: int = 1) -> Bools:
        """See `Subject`; all have the same tube."""
        made = [self.trajectory(*row) for row in zip(q0, q1, strict=True)]
        tube = q1[0, self.robot.nq :]
        return np.asarray(self.checker.check_trajectories(made, tube, tolerance, threads))

    def check_one(self, q0: Floats, q1: Floats, tolerance: float) -> bool:
        """See `Subject`."""
        return bool(self.checker.check_trajectory(self.trajectory(q0, q1), q1[self.robot.nq :], tolerance))

    def explain(self, q0: Floats, q1: Floats, tolerance: float) -> TrajectoryVerdict:
        """See `Subject`."""
        made = self.trajectory(q0, q1)
        found: TrajectoryVerdict = self.checker.explain_trajectory(made, q1[self.robot.nq :], tolerance)
        return found

    def certify(self, q0: Floats, q1: Floats, tolerance: float) -> tuple[Sequence[Proof] | None, ...]:
        """See `Subject`."""
        return tuple(
            self.checker.certify_trajectory(self.trajectory(row, last), last[self.robot.nq :], tolerance)
            for row, last in zip(q0, q1, strict=True)
        )

    def motion_result(self, q0: Floats, q1: Floats, tolerance: float, proofs: bool = False) -> MotionResult:
        """See `Subject`."""
        points, tube = numbers_of(q0, q1)
        tubes = np.append(tube, 0.0)[None] if tube.any() else np.empty((0, 0))
        found: MotionResult = self._certifier.result(Curves(points[None], tubes), tolerance, proofs)
        return found

    def ends(self, q0: Floats, q1: Floats) -> tuple[Floats, Floats]:
        """See `Subject`."""
        nq = self.robot.nq
        return q0[:, :nq], q1[:, :nq]

    def nearest(self, states: Floats, others: Floats, q1: Floats) -> Floats:
        """See `Subject`."""
        tube = q1[..., self.robot.nq :]
        return np.clip(others, states - tube, states + tube)

    def states(self, q0: Floats, q1: Floats, parameters: Floats) -> Floats:
        """See `Subject`."""
        return self.trajectory(q0, q1).position(parameters)

    def slack(self, q0: Floats, q1: Floats) -> float:
        """See `Subject`: of all pairs, the largest sum of lever arms by the tube."""
        points, tube = numbers_of(q0, q1)
        return self._tube_reach.largest_shift(np.abs(points).max(axis=0), tube) if tube.any() else 0.0

    def trajectory(self, q0: Floats, q1: Floats) -> Trajectory:
        """The trajectory of a row."""
        return self.of_pieces([0.0, 1.0], [numbers_of(q0, q1).points])

    def of_pieces(self, breaks: ArrayLike, pieces: Sequence[Floats]) -> Trajectory:
        """A trajectory of curves in a row, each by its control points."""
        return Trajectory.bezier(breaks, pieces).of_robot(self.robot)

    @cached_property
    def _tube_reach(self) -> TubeReach:
        return TubeReach(self.checker)
