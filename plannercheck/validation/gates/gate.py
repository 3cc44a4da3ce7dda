"""`pc.Gate`: judges chunks of waypoints before a controller runs them.

In: a checker, settings; then chunks, each with where the robot stands. Out: a `GateVerdict` each. A chunk passes only
if every state that the controller may bring the robot to is proved free, tube and margin included, and so is a stop
behind it: whatever becomes of the next chunk, the robot can brake. The chunk itself is never changed.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module
from plannercheck.motions.certifier import DEFAULT_TOLERANCE
from plannercheck.motions.certifier_answers import check_tolerance
from plannercheck.motions.checker import Checker
from plannercheck.motions.trajectory_checks import TrajectoryChecks
from plannercheck.robots.configurations import LARGEST_VALUE
from plannercheck.trajectories.controllers import Controller
from plannercheck.validation.gates.chunks import STRAIGHT, chunk_of, is_rate
from plannercheck.validation.gates.limits import GateLimits
from plannercheck.validation.gates.proving import ChunkProofs
from plannercheck.validation.gates.quick import QuickJudge
from plannercheck.validation.gates.record import Hashes
from plannercheck.validation.gates.settings import GateSettings, settings_of
from plannercheck.validation.gates.verdict import GateTools, GateVerdict


@set_module("plannercheck")
class Gate:
    """Judges chunks of waypoints for one checker. Immutable; `of` gives one for a changed scene.

    Attributes:
        checker: The robot in its scene.
        settings: What the gate was told, as rows of the robot's joints.
    """

    def __init__(
        self,
        checker: Checker,
        controller: Controller = "jtc",
        *,
        velocity: ArrayLike | str | Path | None = None,
        acceleration: ArrayLike | str | Path | None = None,
        tube: ArrayLike = 0.01,
        margin: float = 0.005,
        brake: ArrayLike | None = None,
        tolerance: float = DEFAULT_TOLERANCE,
    ) -> None:
        """A gate.

        Args:
            checker: The robot, whose joints take one number each, in a scene that stands still.
            controller: Who runs the chunks: "jtc" or "linear", straight between waypoints; "jtc-upsampled" or "ur".
            velocity: (nq,) largest speeds or one number, rad/s and m/s; a joint_limits.yaml of MoveIt; None: those of
                the URDF.
            acceleration: Likewise, rad/s² and m/s². None: no limit.
            tube: By how much joints may be off the chunk at every instant, (nq,) or one number, rad and m.
            margin: How far bodies have to stay apart besides, m.
            brake: (nq,) the deceleration of each joint in a stop, or one number, rad/s² and m/s². None: `acceleration`.
            tolerance: What comes nearer than this to the margin may be refused, m.

        Raises:
            PlannercheckError: If an argument is malformed, or a joint has no largest speed or no deceleration.
        """
        if not isinstance(checker, Checker):
            raise PlannercheckError(f"checker must be a pc.Checker, not {checker!r:.80}")
        if checker.scene.moving:
            raise PlannercheckError(
                "a gate is of a scene that stands still: replace what moves by where it may be, "
                "or judge with check_trajectory(start_time=)"
            )
        check_tolerance(tolerance)
        row = TrajectoryChecks(checker, tube, tolerance).tube
        given = settings_of(checker.robot, controller, velocity, acceleration, row, margin, brake, tolerance)
        self._take(checker, given)

    def _take(self, checker: Checker, settings: GateSettings) -> None:
        self.checker, self.settings = checker, settings
        robot, proofs = checker.robot, ChunkProofs(checker, settings)
        limits, turning = GateLimits.of(robot, settings), np.flatnonzero(robot.configuration_map.turning_columns())
        self._tools = GateTools(settings, limits, proofs, Hashes(checker), turning.tolist())
        is_plain = (
            settings.controller in STRAIGHT and not len(turning) and np.isfinite((limits.lower, limits.upper)).all()
        )
        self._quick = QuickJudge(settings, limits, proofs) if is_plain else None

    def of(self, checker: Checker) -> Gate:
        """A gate with the same settings for another checker of the same joints, e.g. with the newest cloud."""
        if checker.robot.joint_names != self.checker.robot.joint_names or checker.scene.moving:
            raise PlannercheckError("of() takes a checker of the same joints, in a scene that stands still")
        made = Gate.__new__(Gate)
        made._take(checker, self.settings)
        return made

    def judge(
        self,
        chunk: ArrayLike,
        rate: float | None = None,
        *,
        times: ArrayLike | None = None,
        start: ArrayLike | tuple[Any, Any],
    ) -> GateVerdict:
        """Judges one chunk.

        Args:
            chunk: (n, nq) waypoints, rad and m.
            rate: Waypoints a second: the first is reached at 1 / rate.
            times: (n,) s, in place of a rate. If the first is 0, the robot has to stand there already, to within the
                tube.
            start: (q, dq), where the robot stands at 0 s and its velocities, (nq,) each; or q alone, at rest.

        Returns:
            The verdict.

        Raises:
            PlannercheckError: If something is malformed, empty or not finite.
        """
        known = self._judged_quickly(chunk, rate, times, start)
        if known is not None:
            return known
        return GateVerdict(chunk_of(self.checker.robot.nq, chunk, rate, times, start), self._tools)

    def _judged_quickly(
        self, chunk: ArrayLike, rate: float | None, times: ArrayLike | None, start: ArrayLike | tuple[Any, Any]
    ) -> GateVerdict | None:
        """The verdict by the fast path, if that is open and settles it."""
        if self._quick is None or times is not None or rate is None or not is_rate(rate):
            return None
        given = self._quick.rows(chunk, start)
        if given is None:
            return None
        found = self._quick.judge(*given, float(rate))
        if found is None:
            return None
        checked, ok = found
        if ok is False and not max(np.abs(rows).max() for rows in given) <= LARGEST_VALUE:
            return None  # the plain path says so
        return GateVerdict(checked, self._tools, ok, but_the_stop=True)

    def __repr__(self) -> str:
        return f"Gate({self.checker.robot.name} in {self.checker.scene.name}, {self.settings.controller})"
