"""Validity of planar configurations and motions: every pair of polygons decided by the algorithm in the plane.

In: a `Robot`, a `Scene`. Out: an immutable `Checker` with the interface of the one in space. Its verdicts are exact for
the polygons at the poses that kinematics computes in doubles. Every query is one batch call of the core
(cpp/planar/checker_2d).
"""

from __future__ import annotations

from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.checking.checker_base import ExplainingChecker
from plannercheck.checking.verdicts import MotionVerdict
from plannercheck.common.array_types import Bools, Floats, Ints
from plannercheck.common.arrays import Configuration, read_only
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.public_names import set_module
from plannercheck.common.threads import checked_threads
from plannercheck.motions.certifier import DEFAULT_TOLERANCE
from plannercheck.motions.explanation import explained_motion
from plannercheck.motions.motion_ends import Motions, checked_ends, with_given_ends
from plannercheck.motions.sampling import samples_are_free
from plannercheck.planar.body_tables import core_model, pair_table
from plannercheck.planar.certificates import Certificate, certify
from plannercheck.planar.curve_motions import CurveMotions
from plannercheck.planar.curves import Curve, check_curve
from plannercheck.planar.links import GeometryObject
from plannercheck.planar.motion_certifier import MotionCertifier
from plannercheck.planar.motion_sampling import MotionSampler
from plannercheck.planar.polygons import METHODS, Method
from plannercheck.planar.proof_builder import PlanarBuilder
from plannercheck.planar.robot import Robot
from plannercheck.planar.scene import Scene
from plannercheck.proofs.proof import Proof

# L is the number of links, and A = 1 + the sum of all angles' sizes. An angle is a sum that errs by at most L A u; its
# sine and cosine err by 4u more; both errors are multiplied by the reach. The at most L + 1 sums of a position add 3u
# each of the coordinates' size. Together that is less than 16u L A times the reach, the distance to the root and the
# anchors.
_KINEMATIC_ROUNDING = 2.0**-49


@set_module("plannercheck.planar")
class Checker(ExplainingChecker):
    """Exact collision verdicts for one planar robot in one scene. Immutable, so threads may share it.

    Attributes:
        robot: The robot; its root is limited to the scene's bounds, if there are any.
        scene: The scene as it was when the checker was built.
        bodies: The robot's convex polygons, then the scene's.
        pairs: (k, 2) indices into `bodies`: the pairs that are tested at every configuration.
        motion_sampler: Computes how many states a motion needs, and interpolates them.
    """

    robot: Robot
    scene: Scene
    bodies: tuple[GeometryObject, ...]

    def __init__(
        self,
        robot: Robot,
        scene: Scene | None = None,
        self_collision: bool = True,
        *,
        method: Method = "filtered",
        bounds: bool = True,
    ) -> None:
        """Takes the polygons as they are, and makes circles and boxes around them.

        Args:
            robot: The robot.
            scene: The scene; None is empty.
            self_collision: Whether links that are not neighbours are tested against each other.
            method: As for `planar.intersects`. Verdicts do not depend on it.
            bounds: Whether circles and boxes settle pairs that are far apart.
        """
        if not isinstance(robot, Robot) or not isinstance(scene, Scene | None):
            raise PlannercheckError(
                "planar.Checker takes a planar.Robot and a planar.Scene, "
                f"not {type(robot).__name__} and {type(scene).__name__}"
            )
        if not isinstance(self_collision, bool | np.bool_):
            raise PlannercheckError(f"self_collision must be True or False, not {self_collision!r:.80}")
        if method not in METHODS:
            raise unknown_name("method", method, METHODS)
        self.scene = scene.copy() if scene is not None else Scene("empty")
        self._recipe = robot, self.scene, self_collision, method, bounds
        self.robot = robot if self.scene.bounds is None else robot.with_bounds(*self.scene.bounds)
        self.bodies = (*robot.bodies, *self.scene.bodies)
        self._labels = (*(robot.link_names[body.link] for body in robot.bodies), *self.scene.body_objects)
        self.pairs = read_only(pair_table(robot, len(self.bodies), self_collision))
        self.motion_sampler = MotionSampler(self.robot)
        self._model = core_model(robot, self.bodies, self.pairs)
        self._core = core.PlanarChecker(self._model, bounds, getattr(core.Precision, method))
        self._motions = CurveMotions(self.motion_sampler)

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt, self._recipe

    def is_valid(self, q: Configuration) -> bool:
        """Whether one configuration (nq,) is free of collision; limits are not looked at."""
        return bool(self.first_colliding_pair(self._single(q))[0] < 0)

    def check_states(self, q: ArrayLike, threads: int = 1) -> Bools:
        """Whether each configuration of a set is free of collision.

        Args:
            q: (n, nq) m and rad.
            threads: Number of threads to use.

        Returns:
            (n,), True means valid.
        """
        return np.asarray(self.first_colliding_pair(q, threads) < 0)

    def first_colliding_pair(self, q: ArrayLike, threads: int = 1) -> Ints:
        """The first colliding pair of each configuration (n, nq): (n,) rows of `pairs`, -1 where it is valid."""
        rows = self.robot.check_configurations(q)
        return np.asarray(self._core.first_of_states(rows, checked_threads(threads, len(rows))))

    def colliding_pairs(self, q: ArrayLike) -> Bools:
        """Which pairs collide: (n, k) for configurations (n, nq) and the k rows of `pairs`."""
        return np.asarray(self._core.all_of_states(self.robot.check_configurations(q))).astype(bool)

    def body_poses(self, q: ArrayLike) -> Floats:
        """World poses of all bodies (n, bodies, 3, 3) at configurations (n, nq): the very doubles that verdicts use."""
        rows = self.robot.check_configurations(q)
        links = self.robot.link_poses(rows)
        poses = np.empty((len(rows), len(self.bodies), 3, 3))
        for k, body in enumerate(self.bodies):
            poses[:, k] = body.pose if body.link < 0 else links[:, body.link]
        return poses

    def check_motion(
        self,
        q0: Configuration,
        q1: Configuration,
        resolution: float | None = None,
        tolerance: float = DEFAULT_TOLERANCE,
        *,
        curve: Curve = "straight",
        turning_radius: float | None = None,
    ) -> bool:
        """Whether a motion is free, both ends included: proved for every state on it, or sampled.

        Angles without limits (the heading, free hinges) take the short way, all other numbers move linearly. On curves
        the root moves as in OMPL's Dubins and Reeds-Shepp spaces.

        Args:
            q0: (nq,) start, m and rad.
            q1: (nq,) end.
            resolution: None for a proof. Else only sampled states are checked: no point of the robot moves further than
                this between two of them, in m, and nothing is proved about the motion between them.
            tolerance: A motion that keeps more than this distance from all collisions is proved free, in m; a motion
                that comes nearer may be refused. A motion that touches something is never called free, whatever the
                tolerance.
            curve: How the root moves: "straight", "dubins" (forwards) or "reeds_shepp" (either way).
            turning_radius: Turning radius of curves, m.

        Returns:
            True if the motion is free.
        """
        ends = self._single(q0), self._single(q1)
        free = self.check_motions(*ends, resolution, tolerance, curve=curve, turning_radius=turning_radius)
        return bool(free[0])

    def check_motions(
        self,
        q0: ArrayLike,
        q1: ArrayLike,
        resolution: float | None = None,
        tolerance: float = DEFAULT_TOLERANCE,
        threads: int = 1,
        *,
        curve: Curve = "straight",
        turning_radius: float | None = None,
    ) -> Bools:
        """Whether each of n motions is free.

        Args:
            q0: (n, nq) starts, m and rad.
            q1: (n, nq) ends.
            resolution: As for `check_motion`.
            tolerance: As for `check_motion`.
            threads: Number of threads to use for proofs of straight motions.
            curve: As for `check_motion`.
            turning_radius: As for `check_motion`.

        Returns:
            (n,), True means free.
        """
        check_curve(self.robot, curve, turning_radius)
        motions = self._motion_ends(q0, q1, curve)
        starts, ends, given = motions
        if curve != "straight":
            rows = zip(*motions, strict=True)
            judged = [self._curve_is_free(row, resolution, tolerance, curve, turning_radius) for row in rows]
            return np.array(judged, dtype=bool)
        if resolution is None:
            return self.motion_certifier.check(starts, ends, tolerance, checked_threads(threads, len(starts)), given)
        steps = self.motion_sampler.steps(starts, ends, resolution)
        free = np.asarray(self._core.motions_are_free(starts, ends, steps)).astype(bool)
        return with_given_ends(self, free, motions)

    def explain_motion(
        self,
        q0: Configuration,
        q1: Configuration,
        tolerance: float = DEFAULT_TOLERANCE,
        proofs: bool = False,
        *,
        curve: Curve = "straight",
        turning_radius: float | None = None,
    ) -> MotionVerdict:
        """How far a motion is free and what stops it, with certificates.

        Args:
            q0: (nq,) start, m and rad.
            q1: (nq,) end.
            tolerance: As for `check_motion`.
            proofs: Whether to return the proof of the free part: lines for all pairs, interval by interval.
            curve: As for `check_motion`.
            turning_radius: As for `check_motion`.

        Returns:
            The verdict.
        """
        check_curve(self.robot, curve, turning_radius)
        (start,), (end,), (given,) = self._motion_ends(self._single(q0), self._single(q1), curve)
        pieces, certifier = self._motions.pieces(start, end, curve, turning_radius), self.motion_certifier
        result = certifier.motion_result(start, end, tolerance, proofs, pieces, given)
        prover = partial(self._proof, (start, end, given), tolerance, curve, turning_radius)
        return explained_motion(self, result, lambda t: certifier.states(start, end, t, pieces), tolerance, prover)

    def certify_motions(
        self,
        q0: ArrayLike,
        q1: ArrayLike,
        tolerance: float = DEFAULT_TOLERANCE,
        threads: int = 1,
        *,
        curve: Curve = "straight",
        turning_radius: float | None = None,
    ) -> tuple[Proof | None, ...]:
        """Proofs of motions that anyone can check, without this checker (`Proof.verify`, `Proof.save`).

        Args:
            q0: (n, nq) starts, m and rad.
            q1: (n, nq) ends.
            tolerance: As for `check_motion`.
            threads: As for `check_motions`.
            curve: As for `check_motion`.
            turning_radius: As for `check_motion`.

        Returns:
            One for each motion. None where the motion is not free, and where it is free but so near the tolerance that
            only circles and boxes settle a pair: a proof needs lines for all pairs.

        Raises:
            PlannercheckError: If python-flint is not installed.
        """
        free = self.check_motions(q0, q1, None, tolerance, threads, curve=curve, turning_radius=turning_radius)
        rows = zip(*self._motion_ends(q0, q1, curve), free.tolist(), strict=True)
        return tuple(
            self._proof((start, end, given), tolerance, curve, turning_radius) if passed else None
            for start, end, given, passed in rows
        )

    def _proof(
        self, ends: tuple[Floats, Floats, Floats], tolerance: float, curve: Curve, turning_radius: float | None
    ) -> Proof | None:
        start, end, given = ends
        pieces = self._motions.pieces(start, end, curve, turning_radius)
        return self._prover.proof(start, end, given, tolerance, pieces, curve, turning_radius)

    @cached_property
    def _prover(self) -> PlanarBuilder:
        """Builds proofs of motions; made when first needed."""
        return PlanarBuilder(self)

    @cached_property
    def motion_certifier(self) -> MotionCertifier:
        """Proves motions free; built when first needed."""
        return MotionCertifier(self._model)

    def _motion_ends(self, q0: ArrayLike, q1: ArrayLike, curve: Curve = "straight") -> Motions:
        """Motions between configurations (n, nq): angles without limits take the short way.

        On curves the heading also stays as given.
        """
        starts, ends = checked_ends(self.robot, q0, q1)
        near = self.motion_sampler.shorter_turn(starts, ends)
        if curve != "straight":
            near[:, 2] = ends[:, 2]  # the very double: rounding may choose between two curves of equal length
        return Motions(starts, near, ends)

    def _curve_is_free(
        self,
        ends: tuple[Floats, Floats, Floats],
        resolution: float | None,
        tolerance: float,
        curve: Curve,
        turning_radius: float | None,
    ) -> bool:
        start, end, given = ends
        pieces = self._motions.pieces(start, end, curve, turning_radius)
        if resolution is None:
            return self.motion_certifier.is_free(start, end, tolerance, pieces, given)
        steps = self._motions.steps(start, end, curve, turning_radius, resolution)
        states = partial(self.motion_certifier.states, start, end, pieces=pieces)
        return samples_are_free(self, states, steps) and self.is_valid(given)

    def _certificate(self, a: int, b: int, poses: Floats) -> Certificate:
        return certify(self.bodies[a].vertices, self.bodies[b].vertices, poses[a], poses[b])

    def statistics(self) -> dict[str, Any]:
        """Counters of all calls so far: states, pairs, what settled them, and the algorithm's rounds and vertices."""
        return dict(self._core.statistics())

    def _kinematic_error(self, q: Floats, poses: Floats) -> float:
        """A bound on how far any point is from where exact kinematics of the same numbers puts it, m."""
        robot, free = self.robot, 2 if self.robot.is_free else 0
        anchors = np.abs([link.anchor for link in robot.links])
        size = self.motion_sampler.extent + float(np.abs(q[:free]).sum() + anchors[:, :2].sum())
        angles = 1 + float(np.abs(q[free:]).sum() + anchors[:, 2].sum())
        return _KINEMATIC_ROUNDING * len(robot.links) * size * angles

    def __repr__(self) -> str:
        return f"planar.Checker({self.robot.name!r} in {self.scene.name!r}, {len(self.pairs)} pairs)"


def _rebuilt(robot: Robot, scene: Scene, self_collision: bool, method: Method, bounds: bool) -> Checker:
    """A checker from a pickle; it is built again, which is quick."""
    return Checker(robot, scene, self_collision, method=method, bounds=bounds)
