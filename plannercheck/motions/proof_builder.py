"""Builds proofs of motions in space: a few entries for each pair, found in doubles from the certifier's planes.

In: a checker, a motion or a curve that its certifier proves free. Out: a `Proof`. For bodies that are far apart, one
entry by balls is enough. For the others, the certifier's planes are used, each for as long as it holds: an interval is
halved until one plane holds on it. The verifier's check decides whether an entry holds, so that few proofs are refused
later. If no entry holds, an entry with the certifier's plane is written, which the verifier refuses.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.certificates import Separation
from plannercheck.checking.verdicts import PairVerdict
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.motion_paths import MotionPath
from plannercheck.common.optional_imports import extra_module
from plannercheck.motions.certifier import MotionCertifier
from plannercheck.motions.certifier_answers import MotionResult
from plannercheck.motions.certifier_answers import Proof as Plane
from plannercheck.motions.motion_ends import Curves, Motions
from plannercheck.motions.part_covers import PartCover
from plannercheck.motions.proof_model import PosedPairs, space_model
from plannercheck.motions.solid_covers import PartHulls, Poses, SolidCover
from plannercheck.proofs.data import WORLD, Entry, Hashes, Model, Motion
from plannercheck.proofs.proof import Proof
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene

if TYPE_CHECKING:
    from plannercheck.proofs.entries import EntryChecker


# An interval is halved at most this often in search of a plane or balls that hold on it.
_DEEPEST = 14
# From this many halvings on, intervals are cut where planes end, since a plane may hold only up to there.
_BY_PLANES = 7

# Halvings that the verifier may need within an entry: beyond that, several short entries take it less time.
_WITHIN = 2

# The error of computed states and poses besides that of kinematics, as a part of the robot's size: rounding of states
# and of bodies' placements, and unit vectors whose length is not exactly 1.
_ROUNDING = 2.0**-44
_OFF_UNIT = 12.0


class CertifiedPairs(PosedPairs, Protocol):
    """The parts of a `Checker` from which proofs of motions in space are built."""

    scene: Scene

    def certifier_of(self, path: MotionPath) -> MotionCertifier:
        """Proves motions along a path free."""

    def body_poses(self, q: ArrayLike) -> Floats:
        """(n, bodies, 4, 4) poses of the bodies at configurations (n, nq)."""

    def explain_pair(self, k: int, q: ArrayLike) -> PairVerdict:
        """The verdict of row k of `pairs`, with its certificate."""


class Builder:
    """Builds proofs for one checker."""

    def __init__(self, checker: CertifiedPairs) -> None:
        """Reads the checker.

        Raises:
            PlannercheckError: If python-flint is not installed.
        """
        extra_module("flint", "proofs", "proofs of motions")
        from plannercheck.proofs.well_formed import hashes_of

        self._checker = checker
        self._model: Model = space_model(checker)
        self._hashes: Hashes = hashes_of(self._model)
        self._is_in_parts = any(body.triangles or body.parts for body in self._model.bodies)
        self._parts = PartHulls(self._model)

    def proof(
        self, start: Floats, end: Floats, asked_end: Floats, tolerance: float, path: MotionPath = "screw"
    ) -> Proof | None:
        """The proof of one motion (nq,) to the end of the short way round; None if the certifier does not find it free.

        `asked_end` (nq,) is the end as it was asked for; the tolerance is in m.

        Raises:
            PlannercheckError: If the motion is free, but no proof is found of a pair with a solid or a set of parts, or
                a quaternion, or a cosine and sine, turns by half a turn.
        """
        motion = Motion(tuple(start.tolist()), tuple(end.tolist()), tuple(asked_end.tolist()), path)
        return self._proof(Motions(start[None], end[None], asked_end[None]), motion, tolerance)

    def curve_proof(
        self, points: Floats, tube: Floats, tolerance: float, clock: tuple[float, ...] = ()
    ) -> Proof | None:
        """The proof of one piece of a trajectory, None if the certifier does not find it free.

        Args:
            points: (degree + 1, nq) control points.
            tube: (nq,) by how much each number may be off, rad and m; the errors of the control points included.
            tolerance: m.
            clock: When it begins and ends on the scene's clock, s; none where nothing moves.

        Raises:
            PlannercheckError: As of `proof`.
        """
        wider = tube.copy()
        turns = list(self._model.whole_turns)
        if len(points) == 2 and np.abs(points[1] - points[0])[turns].max(initial=0.0) > np.pi:
            points = np.stack([points[0], points.mean(axis=0), points[1]])  # a straight motion would be the short way
            wider += 2.0**-51 * np.abs(points).max(axis=0)
        for first, past in self._checker.robot.configuration_map.units:
            wider[first:past] = 0.0
        start, end = tuple(points[0].tolist()), tuple(points[-1].tolist())
        inner, around = tuple(points[1:-1].ravel().tolist()), tuple(wider.tolist())
        motion = Motion(start, end, end, "slerp", inner, around, clock)
        return self._proof(Curves(points[None], np.append(wider, 0.0)[None]), motion, tolerance)

    def _proof(self, moved: Motions | Curves, motion: Motion, tolerance: float) -> Proof | None:
        """The proof of a set of one motion, of which the proof's data are known."""
        result = self._motion_result(moved, tolerance, motion.path)
        if result is None:
            return None
        margin, points = self._margin(moved), moved.points[0]
        names = self._checker.robot.name, self._checker.scene.name
        empty = Proof("space", *names, self._hashes, self._model, motion, margin, ())
        if self._is_in_parts:
            entries = self._of_solids(empty, points, motion.path)
        else:
            resting = _resting_directions(self._checker, result.proofs, points[0])
            entries = _entries(empty, result.proofs, resting)
        return Proof("space", *names, self._hashes, self._model, motion, margin, entries)

    def _not_found(self, pair: int, why: str) -> PlannercheckError:
        first, second = (self._model.bodies[k].label for k in self._model.pairs[pair])
        return _not_found(f"of {first} and {second}: {why}")

    def _of_solids(self, empty: Proof, points: Floats, path: MotionPath) -> tuple[Entry, ...]:
        """The entries of all pairs; planes between parts of surfaces are sought here, not by the certifier."""
        import flint

        bits, flint.ctx.prec = flint.ctx.prec, 64
        try:
            verifier = _verifier(empty)
            poses = _MotionPoses(self._checker, points, path)
            return tuple(
                entry
                for pair in range(len(self._model.pairs))
                for entry in self._entries_of_solids(verifier, pair, poses)
            )
        finally:
            flint.ctx.prec = bits

    def _entries_of_solids(self, verifier: EntryChecker, pair: int, poses: _MotionPoses) -> list[Entry]:
        from plannercheck.proofs.faults import UnprovedError

        if has_half_space(self._model, pair):
            of_plane = _PairEntries(verifier, pair, (), None, is_plane=True)
            found = of_plane.over(0.0, 1.0, 0)
            if of_plane.lost:
                raise self._not_found(pair, "it comes too near to the plane")
            return found
        is_set = any(self._model.bodies[k].parts for k in self._model.pairs[pair])
        cover_of = PartCover if is_set else SolidCover
        cover = cover_of(verifier, self._parts, pair, poses, verifier.needed(pair))
        found = cover.entries()
        if cover.lost:
            raise self._not_found(pair, "parts come too near to each other for planes between them")
        try:
            verifier.check_nesting(found)
        except UnprovedError as why:
            raise self._not_found(pair, f"one may be inside the other: {why}") from None
        return found

    def _motion_result(self, moved: Motions | Curves, tolerance: float, path: MotionPath) -> MotionResult | None:
        """The certifier's proofs of all pairs; None if the motion is not free or a pair has no proof."""
        try:
            result = self._checker.certifier_of(path).result(moved, tolerance, not self._is_in_parts)
        except PlannercheckError:  # rounding is too large a part of the tolerance
            return None
        return result if result.free and (self._is_in_parts or result.proved_until == 1.0) else None

    def _margin(self, moved: Motions | Curves) -> float:
        (low,), (high,) = moved.ranges()
        return rounding_margin(self._checker.robot, self._model, low, high, moved.points[0])


def rounding_margin(robot: Robot, model: Model, low: Floats, high: Floats, points: Floats) -> float:
    """What covers the error of computed poses and states of a robot, m.

    `points` (n, nq) are control points of a motion between numbers low (nq,) and high (nq,), rad and m.
    """
    error = 2 * robot.kinematic_error_within(low, high)  # of two bodies
    largest = float(np.abs(points).max(initial=0.0))  # of the states in between; the asked end's is in the error
    units = robot.configuration_map.units
    off = max((abs(float(np.linalg.norm(q[a:b])) - 1) for q in points[[0, -1]] for a, b in units), default=0.0)
    leverage = sum(abs(factor) for joint in model.joints for factor in joint.multipliers)
    roundings = 16 + 4 * (len(points) - 2)  # of a computed state
    part = _ROUNDING + _OFF_UNIT * off + roundings * 2.0**-53 * leverage * (1 + largest)
    return error + part * (1 + _size(model))


class _MotionPoses:
    """Poses on a motion, kept by parameter: pairs ask at the same ones."""

    def __init__(self, checker: CertifiedPairs, points: Floats, path: MotionPath) -> None:
        self._checker, self._points, self._states = checker, points, checker.certifier_of(path).states_on
        self._used = distinct(checker.pairs)
        self._known: dict[float, Poses] = {}

    def at(self, t: float) -> Poses:
        """World poses of the model's bodies and of links at a parameter."""
        if t not in self._known:
            q = self._states(self._points, np.array([t]))
            self._known[t] = Poses(self._checker.body_poses(q)[0][self._used], self._checker.robot.link_poses(q)[0])
        return self._known[t]


def _size(model: Model) -> float:
    """The robot's size, m: the sum of the lengths along its longest chain, and of its bodies."""
    reach: list[float] = []
    for joint in model.joints:
        before = reach[joint.parent] if joint.parent >= 0 else 0.0
        reach.append(before + float(np.linalg.norm(np.reshape(joint.placement, (3, 4))[:, 3])))
    bodies = (
        np.linalg.norm(np.reshape(b.pose, (3, 4))[:, 3]) + np.linalg.norm(b.centre) + b.reach for b in model.bodies
    )
    return max(reach, default=0.0) + float(max(bodies, default=0.0))


def _resting_directions(checker: CertifiedPairs, planes: Sequence[Plane], q: Floats) -> dict[int, tuple[float, ...]]:
    """Separating directions in the world, by pair, for pairs without a certifier's plane since neither body moves."""
    moving = {plane.pair for plane in planes}
    found = {k: checker.explain_pair(k, q).certificate for k in range(len(checker.pairs)) if k not in moving}
    return {k: tuple(c.normal.tolist()) for k, c in found.items() if isinstance(c, Separation)}


def _entries(empty: Proof, planes: Sequence[Plane], resting: Mapping[int, tuple[float, ...]]) -> tuple[Entry, ...]:
    import flint

    assert isinstance(empty.model, Model)
    of_pair: dict[int, list[Plane]] = {}
    for plane in planes:
        of_pair.setdefault(plane.pair, []).append(plane)
    bits, flint.ctx.prec = flint.ctx.prec, 64
    found = list[Entry]()
    try:
        checker = _verifier(empty)
        for pair in range(len(empty.model.pairs)):
            is_plane = has_half_space(empty.model, pair)
            entries = _PairEntries(checker, pair, of_pair.get(pair, []), resting.get(pair), is_plane)
            found += entries.over(0.0, 1.0, 0)
        return tuple(found)
    finally:
        flint.ctx.prec = bits


def _not_found(why: str) -> PlannercheckError:
    return PlannercheckError(f"this motion is free, but no proof of it was found, since {why}")


def _verifier(empty: Proof) -> EntryChecker:
    """The verifier's own check of entries, or an error if it refuses the motion itself."""
    from plannercheck.proofs.entries import EntryChecker
    from plannercheck.proofs.faults import UnprovedError

    try:
        return EntryChecker(empty)
    except UnprovedError as why:
        raise _not_found(f"{why}: give a state in between") from None


def has_half_space(model: Model, pair: int) -> bool:
    """Whether one of both bodies is a half-space."""
    return any(model.bodies[k].half_space for k in model.pairs[pair])


class _PairEntries:
    """The entries of one pair.

    Attributes:
        lost: Whether an interval was found that no entry keeps apart; then the proof will be refused.
    """

    def __init__(
        self,
        checker: EntryChecker,
        pair: int,
        planes: Sequence[Plane],
        resting: tuple[float, ...] | None,
        is_plane: bool = False,
    ) -> None:
        """Takes what may keep a pair apart; `is_plane`: one body is a half-space."""
        self._is_plane = is_plane
        self._checker, self._pair, self._resting = checker, pair, resting
        self._planes = sorted(planes, key=lambda plane: plane.start)
        self.lost = False

    def over(self, start: float, end: float, depth: int) -> list[Entry]:
        """What keeps the pair apart from start to end."""
        candidates = self._candidates(start, end)
        if self.lost:
            return candidates[-1:]
        for entry in candidates:
            if self._checker.holds(entry, _WITHIN):
                return [entry]
        if depth >= _DEEPEST:
            self.lost = True  # the proof will be refused: the rest is not worth the search
            return candidates[-1:]
        cut = self._cut(start, end, depth)
        return self.over(start, cut, depth + 1) + self.over(cut, end, depth + 1)

    def _cut(self, start: float, end: float, depth: int) -> float:
        """Where to cut an interval: in the middle, or, if it is short, where one of the certifier's planes ends."""
        middle = (start + end) / 2
        ends = [plane.end for plane in self._planes if start < plane.end < end] if depth >= _BY_PLANES else []
        return min(ends, key=lambda t: abs(t - middle), default=middle)

    def _candidates(self, start: float, end: float) -> list[Entry]:
        """An entry by balls, then one by the certifier's plane in the middle; by a half-space's own."""
        if self._is_plane:
            return [Entry(self._pair, start, end, "half-space")]
        out = [Entry(self._pair, start, end, "balls")]
        middle = (start + end) / 2
        for plane in self._planes:
            if plane.start <= middle <= plane.end:
                normal = -plane.direction if plane.flipped else plane.direction
                out.append(Entry(self._pair, start, end, "plane", plane.frame, tuple(normal.tolist())))
                break
        if self._resting is not None:
            out.append(Entry(self._pair, start, end, "plane", WORLD, self._resting))
        return out
