"""The public `Checker`: verdicts on configurations (by `StateChecker`) and on the motions between them.

In: a `Robot`, a `Scene`. Out: an immutable `Checker`. A motion is proved free for every state on it, or sampled.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from typing import ClassVar, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.checking.named_configurations import given_configurations
from plannercheck.checking.state_checker import StateChecker
from plannercheck.checking.verdicts import MotionVerdict
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.arrays import Configuration
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.compiled_first import compiled_first
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.motion_paths import MotionPath, check_path
from plannercheck.common.public_names import set_module
from plannercheck.common.threads import MOST_THREADS, checked_threads
from plannercheck.motions.added_obstacles import added_obstacles
from plannercheck.motions.box_search import search_boxes
from plannercheck.motions.certifier import DEFAULT_TOLERANCE, JudgeMotion, MotionCertifier
from plannercheck.motions.explanation import explained_motion
from plannercheck.motions.free_boxes import FreeBox, FreeBoxes
from plannercheck.motions.joint_drives import split_joints
from plannercheck.motions.motion_ends import Motions, checked_ends, with_given_ends
from plannercheck.motions.prepared_cell import CellInputs, check_can_be_saved, write_cell
from plannercheck.motions.proof_builder import Builder
from plannercheck.motions.sampling import MotionSampler
from plannercheck.motions.trajectory_checks import TrajectoryChecks, check_trajectory_of, named_piece, several
from plannercheck.motions.trajectory_verdict import TrajectoryVerdict
from plannercheck.proofs.proof import Proof
from plannercheck.trajectories.trajectory import Trajectory

Same = TypeVar("Same", bound="Checker")


@set_module("plannercheck")
class Checker(StateChecker):
    """Exact collision verdicts for one robot in one scene. Immutable, so threads may share it."""

    __slots__ = ("_judge_motion",)  # the twin of `check_motion`

    _COMPILED: ClassVar[frozenset[str]] = StateChecker._COMPILED | {
        "motion_certifier",
        "_slerp_certifier",
        "_prover",
    }

    def _compile(self) -> None:
        self._judge_motion: JudgeMotion | None = None  # made when first needed
        super()._compile()

    def __copy__(self: Same) -> Same:
        other = super().__copy__()
        other._judge_motion = self._judge_motion
        return other

    def _scene_taken(self) -> None:
        kept = ("motion_certifier", "_slerp_certifier", "_prover", "motion_sampler")
        for name in kept:  # of the earlier scene, or of what it attached
            self.__dict__.pop(name, None)

    @cached_property
    def motion_sampler(self) -> MotionSampler:
        """Computes how many states a motion needs, and interpolates them; made once a robot, when first needed."""
        key = "motion sampler", self.excess
        return self.robot.remembered(key, lambda: MotionSampler(self.robot, self.excess))

    @compiled_first("_judge_motion", 2, DEFAULT_TOLERANCE)
    def check_motion(
        self,
        q0: Configuration,
        q1: Configuration,
        resolution: float | None = None,
        tolerance: float = DEFAULT_TOLERANCE,
        *,
        path: MotionPath = "screw",
    ) -> bool:
        """Whether a motion is free, both ends included: proved for every state on it, or sampled.

        Each joint moves by itself: revolute and prismatic ones linearly, continuous ones the short way round,
        quaternions by slerp, planar and floating bases along the path that is named.

        Args:
            q0: (nq,) start, rad and m.
            q1: (nq,) end.
            resolution: None for a proof. Else only sampled states are checked: no point of a link moves further than
                this between two of them, in m, and nothing is proved about the motion between them.
            tolerance: A motion that keeps more than this distance from all collisions is proved free, in m; a motion
                that comes nearer may be refused. A motion that touches something is never called free, whatever the
                tolerance.
            path: How planar and floating joints move: "screw", along the one screw from start to end (Pinocchio's
                interpolation), or "slerp", with their position on a straight line and their turn the short way at
                constant speed, each by itself (OMPL's in SE(2) and SE(3)).

        Returns:
            True if the motion is free.
        """
        if resolution is None and path == "screw" and self._kernel is not None:
            if self._judge_motion is None:
                self._judge_motion = self.motion_certifier.judge_rows
            known = self._judge_motion(q0, q1, tolerance)
            if known is None:
                known = self.motion_certifier.judge_rows_beyond(q0, q1, tolerance)
            if known is not None:
                return known
        return bool(self.check_motions(self._single(q0), self._single(q1), resolution, tolerance, path=path)[0])

    def check_motions(
        self,
        q0: ArrayLike,
        q1: ArrayLike,
        resolution: float | None = None,
        tolerance: float = DEFAULT_TOLERANCE,
        threads: int = 1,
        *,
        path: MotionPath = "screw",
    ) -> Bools:
        """Whether each of n motions is free.

        Args:
            q0: (n, nq) starts, rad and m.
            q1: (n, nq) ends.
            resolution: As for `check_motion`.
            tolerance: As for `check_motion`.
            threads: Number of threads to use for proofs.
            path: As for `check_motion`.

        Returns:
            (n,), True means free.
        """
        check_path(path)
        if resolution is None and type(threads) is int and threads >= 1 and self._kernel is not None:
            known = self.motion_certifier.judge_sets(q0, q1, tolerance, min(threads, MOST_THREADS))
            if known is not None:
                return known.view(bool)
        motions = self._motion_ends(q0, q1)
        if resolution is None:
            threads = checked_threads(threads, len(motions.starts))
            return self.certifier_of(path).check(motions, tolerance, threads)
        return with_given_ends(self, self._sampled_free(motions, resolution, path), motions)

    def _motion_ends(self, q0: ArrayLike, q1: ArrayLike) -> Motions:
        """Motions between configurations (n, nq); continuous joints take the short way."""
        starts, given = checked_ends(self.robot, q0, q1)
        return Motions(starts, self.motion_sampler.shorter_turn(starts, given), given)

    def _sampled_free(self, motions: Motions, resolution: float, path: MotionPath) -> Bools:
        starts, ends = motions.starts, motions.ends
        if self._kernel is None or not self.motion_sampler.is_vector_space:
            return self.motion_sampler.check(self, starts, ends, resolution, path)
        steps = self.motion_sampler.steps(starts, ends, resolution)
        # Between two states within the limits, rounding takes no state further beyond them than the proof's margin
        # allows.
        return self._tables.judged(
            lambda table, *part: table.core.motions_are_free(self._kernel, *part).view(bool), starts, ends, steps
        )

    def explain_motion(
        self,
        q0: Configuration,
        q1: Configuration,
        tolerance: float = DEFAULT_TOLERANCE,
        proofs: bool = False,
        *,
        path: MotionPath = "screw",
    ) -> MotionVerdict:
        """How far a motion is free and what stops it, with certificates.

        Args:
            q0: (nq,) start, rad and m.
            q1: (nq,) end.
            tolerance: As for `check_motion`.
            proofs: Whether to return the proof of the free part: planes for all pairs, interval by interval.
            path: As for `check_motion`.

        Returns:
            The verdict.
        """
        (start,), (end,), (given,) = self._motion_ends(self._single(q0), self._single(q1))
        certifier = self.certifier_of(path)
        result = certifier.motion_result(start, end, tolerance, proofs, given)
        prover = partial(self._proof, start, end, given, tolerance, path)
        return explained_motion(self, result, lambda t: certifier.states(start, end, t), tolerance, prover)

    def free_box(self, q: Configuration, shape: ArrayLike | None = None, cells: int = 1000) -> FreeBox | None:
        """A box of configurations around a configuration, within the limits, every one proved free.

        The box is the largest of its proportions that the cells cover; then its sides move out one by one.

        Args:
            q: (nq,) rad and m.
            shape: (nq,) the proportions of its sides, or one number; None for equal sides.
            cells: How many cells may cover it: a larger number proves larger boxes, and takes longer.

        Returns:
            The box; None if none is proved.

        Raises:
            PlannercheckError: If an argument is malformed, q is beyond the limits, the robot's configurations have unit
                vectors, or the scene moves.
        """
        return self.free_boxes(self._single(q), shape, cells).box(0)

    def free_boxes(
        self, q: ArrayLike, shape: ArrayLike | None = None, cells: int = 1000, threads: int = 1
    ) -> FreeBoxes:
        """Boxes around n configurations: a row is the `free_box` of one, whatever the threads and the others.

        Args:
            q: (n, nq) rad and m.
            shape: As for `free_box`, of all.
            cells: As for `free_box`, of each.
            threads: Number of threads to use.

        Returns:
            A table.

        Raises:
            PlannercheckError: As of `free_box`.
        """
        if self._moving is not None:
            raise PlannercheckError(
                "free boxes are of a scene that stands still: replace what moves by where it may be"
            )
        rows = self.robot.check_configurations(given_configurations(self.robot, q))
        threads = checked_threads(threads, MOST_THREADS)
        return search_boxes(self, self.certifier_of("slerp"), rows, shape, cells, threads)

    def check_trajectory(
        self,
        trajectory: Trajectory,
        tube: ArrayLike = 0.0,
        tolerance: float = DEFAULT_TOLERANCE,
        *,
        start_time: float = 0.0,
    ) -> bool:
        """Whether a trajectory is proved free at every instant, both ends included.

        Every joint follows its polynomial; continuous joints turn as far as it says. Turns of floating and planar bases
        go from one control point of a piece to the last by slerp. What moves in the scene does so meanwhile.

        Args:
            trajectory: What the robot executes.
            tube: By how much each number may be off the curve at every instant, all at once: one number or (nq,), rad
                and m. The proof then covers tracking errors, but no delay.
            tolerance: A trajectory that keeps further than this from all collisions, with its tube, is proved free, in
                m; how far a tube moves points is bounded by its sum over lever arms. One that touches is never free.
            start_time: The scene's clock where the trajectory begins, s; without effect where nothing moves.

        Returns:
            True if it is free.
        """
        checker, (trajectory,) = self._on_clock([trajectory], start_time)
        return TrajectoryChecks(checker, tube, tolerance).is_free(trajectory)

    def check_trajectories(
        self,
        trajectories: Iterable[Trajectory],
        tube: ArrayLike = 0.0,
        tolerance: float = DEFAULT_TOLERANCE,
        threads: int = 1,
        *,
        start_time: ArrayLike = 0.0,
    ) -> Bools:
        """Whether each of n trajectories is proved free: (n,); arguments as for `check_trajectory`.

        `start_time` is one number, or (n,).
        """
        threads = checked_threads(threads, MOST_THREADS)
        checker, judged = self._on_clock(several(trajectories), start_time)
        return TrajectoryChecks(checker, tube, tolerance).are_free(judged, threads)

    def _on_clock(
        self: Same, trajectories: Sequence[Trajectory], start_time: ArrayLike
    ) -> tuple[Same, Sequence[Trajectory]]:
        """The checker that judges trajectories in a scene that moves, and the trajectories on the scene's clock."""
        if self._moving is None:
            return self, trajectories
        given = np.asarray(start_time, dtype=object)
        if given.shape not in ((), (len(trajectories),)):
            raise PlannercheckError(f"start_time must be one number, s, or ({len(trajectories)},), not {given.shape}")
        times = np.broadcast_to(given, len(trajectories)).tolist()
        for trajectory in trajectories:
            check_trajectory_of(self.robot, trajectory)
        clock, checker = self._moving.clock, self._moving.checker
        return checker, [clock.on_clock(*each) for each in zip(trajectories, times, strict=True)]

    def explain_trajectory(
        self,
        trajectory: Trajectory,
        tube: ArrayLike = 0.0,
        tolerance: float = DEFAULT_TOLERANCE,
        *,
        start_time: float = 0.0,
    ) -> TrajectoryVerdict:
        """How far a trajectory is free, what stops it, and how much room it leaves; arguments as above.

        Where something in the scene moves, the verdict's instants are on the scene's clock.
        """
        prover = partial(self.certify_trajectory, trajectory, tube, tolerance, start_time=start_time)
        checker, (judged,) = self._on_clock([trajectory], start_time)
        late = float(judged.curve.breaks[0] - trajectory.curve.breaks[0])
        own = trajectory.limits(self.robot) if len(self.robot.joint_names) == self.robot.nq else ()
        limits = tuple(replace(each, time=each.time + late) for each in own)
        found = TrajectoryChecks(checker, tube, tolerance).explain(judged, limits, prover)
        return found if self._moving is None else replace(found, clock=" of the scene's clock")

    def certify_motions(
        self,
        q0: ArrayLike,
        q1: ArrayLike,
        tolerance: float = DEFAULT_TOLERANCE,
        threads: int = 1,
        *,
        path: MotionPath = "screw",
    ) -> tuple[Proof | None, ...]:
        """Proofs of motions that anyone can check, without this checker (`Proof.verify`, `Proof.save`).

        Args:
            q0: (n, nq) starts, rad and m.
            q1: (n, nq) ends.
            tolerance: As for `check_motion`.
            threads: Number of threads to use to find the motions that are free.
            path: As for `check_motion`.

        Returns:
            One for each motion. None where the motion is not free, and where it is free but rounding takes nearly all
            of the part of the tolerance that it may take: a proof covers all pairs, those that a verdict leaves out
            included. None also where the proof would take more than a million planes.

        Raises:
            PlannercheckError: If Pinocchio itself poses, or python-flint is not installed; or no proof is found of a
                free motion on which a solid or a set of parts comes near: the pair is named; or one turns a quaternion,
                or a cosine and sine, by half a turn.
        """
        free = self.check_motions(q0, q1, tolerance=tolerance, threads=threads, path=path)
        motions = zip(free.tolist(), *self._motion_ends(q0, q1), strict=True)
        return tuple(self._proof(q, end, to, tolerance, path) if passed else None for passed, q, end, to in motions)

    def certify_trajectory(
        self,
        trajectory: Trajectory,
        tube: ArrayLike = 0.0,
        tolerance: float = DEFAULT_TOLERANCE,
        *,
        start_time: float = 0.0,
    ) -> tuple[Proof, ...] | None:
        """Proofs of a trajectory's pieces that anyone can check, in order; arguments as for `check_trajectory`.

        Returns:
            One for each piece; None where the trajectory is not free. Where something in the scene moves, pieces end at
            its knots as well, the columns of what moves follow the robot's, and each proof has its times.

        Raises:
            PlannercheckError: As of `certify_motions`.
        """
        checker, (judged,) = self._on_clock([trajectory], start_time)
        checks = TrajectoryChecks(checker, tube, tolerance)
        if not checks.are_free([judged])[0]:
            return None
        around = checks.tube_of(judged)
        proofs = list[Proof | None]()
        for k, points in enumerate(judged.curve.pieces):
            with error_context(named_piece(judged, k)):
                clock = () if self._moving is None else tuple(judged.curve.breaks[k : k + 2].tolist())
                proofs.append(checker._prover.curve_proof(points, around, tolerance, clock))
        found = tuple(proof for proof in proofs if proof is not None)
        return found if len(found) == len(proofs) else None

    def save(self, path: str | Path) -> None:
        """Writes a prepared cell: all that plannercheck's C++ library needs to judge as this checker does.

        There, no URDF, mesh or Pinocchio is read (plannercheck/cpp/library/include/plannercheck/checker.hpp). Motions
        along screws are judged, as `check_motion` does by default.

        Args:
            path: The file, "….plannercheck"; its folder must exist.

        Raises:
            PlannercheckError: If Pinocchio itself poses the robot, or something in the scene moves: a cell has neither;
                or the file can't be written.
        """
        kernel, robot = check_can_be_saved(self.robot, self.scene, self._kernel), self.robot
        _ = self.polytopes  # prepares those of all pairs
        added = added_obstacles(self._settings, robot, self.scene, self.bodies, self.paddings)
        polytopes = added.prepared(robot, self._preparation)
        bodies = self.bodies, self._labels, polytopes, self.pairs, self.paddings, self.unreachable
        parts = *bodies, added, self._tables, self.motion_certifier
        write_cell(CellInputs(robot, kernel, self.scene, *parts), Path(path))

    def _proof(self, start: Floats, end: Floats, asked_end: Floats, tolerance: float, path: MotionPath) -> Proof | None:
        return self._prover.proof(start, end, asked_end, tolerance, path)

    @cached_property
    def _prover(self) -> Builder:
        """Builds proofs of motions; made when first needed."""
        return Builder(self)

    def certifier_of(self, path: MotionPath) -> MotionCertifier:
        """Proves motions along a path free; arguments as for `check_motion`, errors as of `motion_certifier`."""
        check_path(path)
        return self.motion_certifier if path == "screw" else self._slerp_certifier

    @cached_property
    def _slerp_certifier(self) -> MotionCertifier:
        """The one along screws where no joint both slides and turns."""
        table = self.robot.joint_table
        splits = table is not None and split_joints(table, "slerp")
        return self._made_certifier("slerp") if splits else self.motion_certifier

    @cached_property
    def motion_certifier(self) -> MotionCertifier:
        """Proves motions along screws free; built when first needed.

        Raises:
            PlannercheckError: If Pinocchio itself poses.
        """
        return self._made_certifier("screw")

    def _made_certifier(self, path: MotionPath) -> MotionCertifier:
        if self._kernel is None:
            raise PlannercheckError(
                f"motions of {self.robot.name!r} are proved free for the compiled kinematics only, and Pinocchio poses "
                "here: choose sampled motions by resolution=, in m"
            )
        tuning = self._settings.tuning
        return MotionCertifier(self.robot, self.bodies, self.pairs, self._tables, self.excess, tuning, path)
