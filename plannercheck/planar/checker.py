"""Validity of planar configurations: a robot in a scene, every pair of polygons decided by the algorithm in the plane.

In: a `Robot`, a `Scene`. Out: an immutable `Checker` with the interface of the one in space, whose verdicts are exact
for the polygons at the poses that kinematics computes in doubles. Everything is a thin wrapper of one batch call in the
core (cpp/planar_checker).
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.arrays import contiguous
from plannercheck.certified_motions import DEFAULT_TOLERANCE, imprecise
from plannercheck.core import core
from plannercheck.errors import PlannercheckError, unknown_name
from plannercheck.motion_verdicts import explained_motion
from plannercheck.planar.certificates import certify
from plannercheck.planar.certified_motions import STRAIGHT, MotionCertifier, straight_piece
from plannercheck.planar.curves import Curve, Curves, check_curve
from plannercheck.planar.motion import MotionSampler
from plannercheck.planar.polygons import METHODS, Method
from plannercheck.planar.robot import Body, Robot
from plannercheck.planar.scene import Scene
from plannercheck.report import MotionVerdict, PairVerdict, Verdict

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Ints = NDArray[np.int32]

# Room for rounding in circles and boxes, as a part of the coordinates' size: they round by less than 1e-14 of it.
_ROOM = 1e-12

# With L links and A = 1 + the sum of all angles' sizes, an angle is a sum that errs by L A u at most, sine and cosine
# by 4u more, which moves what they turn by as much of the reach; the at most L + 1 sums of a position add 3u each of
# the coordinates' size. Together that is less than 16u L A of reach, way to the root and anchors.
_KINEMATIC_ROUNDING = 2.0**-49

# Up to this sum of a configuration's angles, rad, the certifier's room for rounding (kPlanarRounding: 1024u, of which
# some hundred are taken) has as much left as they need: L A u, as above.
_FAR_ANGLES = 64.0

# At most this part of the tolerance may go to it; the core's own rounding may take a quarter.
_SLIP_PART = 1 / 16


class Checker:
    """Exact collision verdicts for one planar robot in one scene. Immutable, so threads may share it.

    Attributes:
        robot: The robot, its root within the scene's bounds if the scene has some.
        scene: The scene, as it was when the checker was built.
        bodies: The robot's convex polygons, then the scene's.
        pairs: (k, 2) indices into `bodies`: what is tested at every configuration.
        motion_sampler: Says how many states a motion needs, and interpolates them.
    """

    def __init__(
        self,
        robot: Robot,
        scene: Scene | None = None,
        self_collision: bool = True,
        *,
        method: Method = "filtered",
        bounds: bool = True,
    ) -> None:
        """Takes the polygons as they are; nothing is prepared but circles and boxes around them.

        Args:
            robot: The robot.
            scene: The scene; None is empty.
            self_collision: Whether links that are no neighbours are tested against each other.
            method: As for `planar.intersects`. Verdicts do not depend on it.
            bounds: Whether circles and boxes settle pairs that are far apart.
        """
        if not isinstance(robot, Robot) or not isinstance(scene, Scene | None):
            raise PlannercheckError(
                "planar.Checker takes a planar.Robot and a planar.Scene, "
                f"not {type(robot).__name__} and {type(scene).__name__}"
            )
        if method not in METHODS:
            raise unknown_name("method", method, METHODS)
        self.scene = scene if scene is not None else Scene("empty")
        self._recipe = robot, self.scene, self_collision, method, bounds
        self.robot = robot if self.scene.bounds is None else robot.within(*self.scene.bounds)
        self.bodies: tuple[Body, ...] = (*robot.bodies, *self.scene.bodies)
        self._labels = (*(robot.link_names[body.link] for body in robot.bodies), *self.scene.body_objects)
        self.pairs = _pair_table(robot, len(self.bodies), self_collision)
        self.motion_sampler = MotionSampler(self.robot)
        self._arguments = (
            *robot.core_links(),
            [body.vertices for body in self.bodies],
            np.array([body.link for body in self.bodies], dtype=np.int32),
            np.array([body.pose for body in self.bodies]).reshape(-1, 3, 3),
            np.array([_circle(body.vertices) for body in self.bodies]).reshape(-1, 3),
            np.array([_box(body) for body in self.bodies]).reshape(-1, 4),
            self.pairs,
        )
        self._core = core.PlanarChecker(*self._arguments, bounds, getattr(core.Precision, method))
        self._curves: dict[tuple[Curve, float], Curves] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt, self._recipe

    def is_valid(self, q: ArrayLike) -> bool:
        """Whether one configuration (nq,) is free of collision; limits are not looked at."""
        return bool(self.first_colliding_pair(self._single(q))[0] < 0)

    def check_states(self, q: ArrayLike, threads: int = 1) -> Bools:
        """Whether each configuration of a set is free of collision.

        Args:
            q: (n, nq) m and rad.
            threads: How many to use.

        Returns:
            (n,), True means valid.
        """
        return np.asarray(self.first_colliding_pair(q, threads) < 0)

    def first_colliding_pair(self, q: ArrayLike, threads: int = 1) -> Ints:
        """The first colliding pair of each configuration (n, nq): (n,) rows of `pairs`, -1 where it is valid."""
        rows = self.robot.check_configurations(q)
        return np.asarray(self._core.first_of_states(rows, min(_checked_threads(threads), max(len(rows), 1))))

    def colliding_pairs(self, q: ArrayLike) -> Bools:
        """Which pairs collide: (n, k) for configurations (n, nq) and the k rows of `pairs`."""
        return np.asarray(self._core.all_of_states(self.robot.check_configurations(q))).astype(bool)

    def body_poses(self, q: ArrayLike) -> Floats:
        """World poses of all bodies (n, bodies, 3, 3) at configurations (n, nq), the same bits that verdicts use."""
        rows = self.robot.check_configurations(q)
        links = self.robot.link_poses(rows)
        poses = np.empty((len(rows), len(self.bodies), 3, 3))
        for k, body in enumerate(self.bodies):
            poses[:, k] = body.pose if body.link < 0 else links[:, body.link]
        return poses

    def check_motion(
        self,
        q0: ArrayLike,
        q1: ArrayLike,
        resolution: float | None = None,
        tolerance: float = DEFAULT_TOLERANCE,
        *,
        curve: Curve = "straight",
        turning_radius: float | None = None,
    ) -> bool:
        """Whether a motion is free, both ends included: proved for every state on it, or sampled.

        Angles without limits (the heading, free hinges) take the short way, all other numbers go linearly; on curves
        the root moves as OMPL's Dubins and Reeds-Shepp spaces have it.

        Args:
            q0: (nq,) start, m and rad.
            q1: (nq,) end.
            resolution: None for a proof. Else only states are checked, so close that no point of the robot moves
                further than this between two of them, in m; nothing is proved about what lies between.
            tolerance: A motion that is never within this of a collision is proved free, in m; one that is may be
                refused. Free motions that touch something are never passed, whatever the tolerance.
            curve: How the root moves: "straight", "dubins" (forwards) or "reeds_shepp" (either way).
            turning_radius: Of curves, m.

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
            threads: How many to use for proofs of straight motions.
            curve: As for `check_motion`.
            turning_radius: As for `check_motion`.

        Returns:
            (n,), True means free.
        """
        check_curve(self.robot, curve, turning_radius)
        starts, ends = self._motion_ends(q0, q1, curve)
        slips = self._slips(starts, q1, tolerance if resolution is None else np.inf)
        if curve != "straight":
            rows = zip(starts, ends, slips, strict=True)
            judged = [self._curve_is_free(*row, resolution, tolerance, curve, turning_radius) for row in rows]
            return np.array(judged, dtype=bool)
        if resolution is None:
            free = self.motion_certifier.check(starts, ends, tolerance, _checked_threads(threads))
            for k in np.flatnonzero(slips).tolist():
                pieces = self._pieces(starts[k], ends[k], curve, None, slips[k])
                free[k] = self.motion_certifier.is_free(starts[k], ends[k], tolerance, pieces)
            return free
        steps = self.motion_sampler.steps(starts, ends, resolution)
        return np.asarray(self._core.motions_are_free(starts, ends, steps)).astype(bool)

    def explain_motion(
        self,
        q0: ArrayLike,
        q1: ArrayLike,
        tolerance: float = DEFAULT_TOLERANCE,
        proofs: bool = False,
        *,
        curve: Curve = "straight",
        turning_radius: float | None = None,
    ) -> MotionVerdict:
        """How far a motion is free, what stops it, and the certificates behind that.

        Args:
            q0: (nq,) start, m and rad.
            q1: (nq,) end.
            tolerance: As for `check_motion`.
            proofs: Whether to give what proves the free part: lines for all pairs, interval by interval.
            curve: As for `check_motion`.
            turning_radius: As for `check_motion`.

        Returns:
            The verdict.
        """
        check_curve(self.robot, curve, turning_radius)
        starts, ends = self._motion_ends(self._single(q0), self._single(q1), curve)
        (start,), (end,), (slip,) = starts, ends, self._slips(starts, q1, tolerance)
        pieces, certifier = self._pieces(start, end, curve, turning_radius, slip), self.motion_certifier
        passage = certifier.passage(start, end, tolerance, proofs, pieces)
        return explained_motion(self, passage, lambda t: certifier.states(start, end, t, pieces), tolerance)

    @cached_property
    def motion_certifier(self) -> MotionCertifier:
        """Proves motions free; built when it is first needed."""
        return MotionCertifier(*self._arguments)

    def _motion_ends(self, q0: ArrayLike, q1: ArrayLike, curve: Curve = "straight") -> tuple[Floats, Floats]:
        """Starts and ends (n, nq); angles without limits take the short way, but for the heading on curves."""
        starts, given = self.robot.check_configurations(q0), self.robot.check_configurations(q1)
        if starts.shape != given.shape:
            raise PlannercheckError(f"q0 and q1 must have the same shape, not {starts.shape} and {given.shape}")
        ends = self.motion_sampler.short_way(starts, given)
        if curve != "straight":
            ends = ends.copy()
            ends[:, 2] = given[:, 2]  # to the bit: of two curves of one length rounding may choose
        return starts, ends

    def _slips(self, starts: Floats, q1: ArrayLike, tolerance: float) -> Floats:
        """How far poses may be from those of the same angles less whole turns, by rounding of those far from 0.

        Args:
            starts: (n, nq) of motions.
            q1: (n, nq) their ends as they are given: these are posed, and the motion leads to their angles less turns.
            tolerance: m.

        Returns:
            (n,) m, 0 where the certifier's own room for rounding is enough.

        Raises:
            PlannercheckError: Where it is no small part of the tolerance.
        """
        taken = np.maximum(np.abs(starts), np.abs(contiguous(q1).reshape(starts.shape)))
        slips = np.zeros(len(starts))
        for k in np.flatnonzero(taken[:, 2 if self.robot.is_free else 0 :].sum(axis=1) > _FAR_ANGLES).tolist():
            slips[k] = self._kinematic_error(taken[k])
            if not slips[k] <= _SLIP_PART * tolerance:
                raise imprecise(k, tolerance)
        return slips

    def _curve_is_free(
        self,
        start: Floats,
        end: Floats,
        slip: float,
        resolution: float | None,
        tolerance: float,
        curve: Curve,
        turning_radius: float | None,
    ) -> bool:
        pieces = self._pieces(start, end, curve, turning_radius, slip)
        if resolution is None:
            return self.motion_certifier.is_free(start, end, tolerance, pieces)
        way = self._curves_of(curve, turning_radius).way(start, end, self.motion_sampler)
        steps = int(self.motion_sampler.steps_of_way(np.array([way]), resolution)[0])
        states = self.motion_certifier.states(start, end, np.arange(steps + 1) / steps, pieces)
        return bool(self.check_states(states).all())

    def _curves_of(self, curve: Curve, turning_radius: float | None) -> Curves:
        assert turning_radius is not None  # it was checked
        key = curve, float(turning_radius)
        if key not in self._curves:
            self._curves[key] = Curves(*key)
        return self._curves[key]

    def _pieces(
        self, start: Floats, end: Floats, curve: Curve, turning_radius: float | None, slip: float = 0.0
    ) -> Floats:
        """A motion's pieces, each with this much more slip, m; none if the core's own straight one will do."""
        if curve == "straight":
            return STRAIGHT if slip == 0 else straight_piece(start, end, self.robot.is_free, slip)
        pieces = self._curves_of(curve, turning_radius).pieces(start, end, self.motion_sampler.reach)
        pieces[:, -1] += slip
        return pieces

    def explain(self, q: ArrayLike, separations: bool = False) -> Verdict:
        """The verdict of one configuration with the names and certificates behind it.

        Args:
            q: (nq,) m and rad.
            separations: Whether to give the separating lines of all other pairs, too.

        Returns:
            The verdict; certificates are in world coordinates.
        """
        row = self._single(q)
        colliding, poses = self.colliding_pairs(row)[0], self.body_poses(row)[0]
        wanted = range(len(self.pairs)) if separations else np.flatnonzero(colliding).tolist()
        found = [self.pair_verdict(k, poses, bool(colliding[k])) for k in wanted]
        return Verdict(
            not colliding.any(),
            tuple(v for v in found if v.colliding),
            tuple(v for v in found if not v.colliding),
            self._kinematic_error(row[0]),
        )

    def explain_pair(self, k: int, q: ArrayLike) -> PairVerdict:
        """The verdict of row k of `pairs` alone at one configuration (nq,), with its certificate."""
        row = self._single(q)
        return self.pair_verdict(k, self.body_poses(row)[0], bool(self.colliding_pairs(row)[0, k]))

    def pair_verdict(self, k: int, poses: Floats, colliding: bool) -> PairVerdict:
        """The verdict of row k of `pairs` at poses of all bodies (bodies, 3, 3), with its certificate."""
        a, b = (int(i) for i in self.pairs[k])
        certificate = certify(self.bodies[a].vertices, self.bodies[b].vertices, poses[a], poses[b])
        return PairVerdict(*self.pair_names(k), self.bodies[a].name, self.bodies[b].name, colliding, certificate)

    def pair_names(self, k: int) -> tuple[str, str]:
        """The link and the other link or obstacle of row k of `pairs`."""
        a, b = self.pairs[k]
        return self._labels[a], self._labels[b]

    def statistics(self) -> dict[str, Any]:
        """Counters of all calls so far: states, pairs, what settled them, and the algorithm's rounds and vertices."""
        return dict(self._core.statistics())

    def _kinematic_error(self, q: Floats) -> float:
        """No point is further than this from where exact kinematics of the same numbers puts it, m."""
        robot, free = self.robot, 2 if self.robot.is_free else 0
        anchors = np.abs([link.anchor for link in robot.links])
        size = self.motion_sampler.reach + float(np.abs(q[:free]).sum() + anchors[:, :2].sum())
        angles = 1 + float(np.abs(q[free:]).sum() + anchors[:, 2].sum())
        return _KINEMATIC_ROUNDING * len(robot.links) * size * angles

    def _single(self, q: ArrayLike) -> Floats:
        row = np.asarray(q, dtype=np.float64)
        if row.ndim != 1:
            raise PlannercheckError(f"one configuration must have shape ({self.robot.nq},), not {row.shape}")
        return row[None]

    def __repr__(self) -> str:
        return f"planar.Checker({self.robot.name!r} in {self.scene.name!r}, {len(self.pairs)} pairs)"


def _checked_threads(threads: int) -> int:
    if not isinstance(threads, int) or threads < 1:
        raise PlannercheckError(f"threads must be a whole number of at least 1, not {threads!r}")
    return threads


def _pair_table(robot: Robot, bodies: int, self_collision: bool) -> Ints:
    own = robot.self_pairs() if self_collision else []
    fixed = _fixed_links(robot)
    others = range(len(robot.bodies), bodies)
    moving = [k for k, body in enumerate(robot.bodies) if body.link not in fixed]
    return np.array([*own, *((a, b) for a in moving for b in others)], dtype=np.int32).reshape(-1, 2)


def _fixed_links(robot: Robot) -> set[int]:
    """Links that no joint moves: as in space, they are not tested against the scene."""
    fixed: set[int] = set()
    for k, link in enumerate(robot.links):
        if link.joint == "fixed" and (k == 0 or robot.parent_index(k) in fixed):
            fixed.add(k)
    return fixed


def _rebuilt(robot: Robot, scene: Scene, self_collision: bool, method: Method, bounds: bool) -> Checker:
    """A checker from a pickle; there is nothing in it that takes long to prepare."""
    return Checker(robot, scene, self_collision, method=method, bounds=bounds)


def _circle(vertices: Floats) -> tuple[float, float, float]:
    """A circle around vertices: centre and radius, with room for its rounding and that of its pose."""
    x, y = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    radius = float(np.hypot(vertices[:, 0] - x, vertices[:, 1] - y).max())
    return float(x), float(y), radius + _ROOM * (radius + abs(float(x)) + abs(float(y)))


def _box(body: Body) -> tuple[float, float, float, float]:
    """A box in the world around a posed polygon, with room for rounding."""
    posed = body.vertices @ body.pose[:2, :2].T + body.pose[:2, 2]
    room = _ROOM * (float(np.abs(body.vertices).sum(axis=1).max()) + float(np.abs(body.pose[:2, 2]).sum()))
    (x0, y0), (x1, y1) = posed.min(axis=0) - room, posed.max(axis=0) + room
    return float(x0), float(y0), float(x1), float(y1)
