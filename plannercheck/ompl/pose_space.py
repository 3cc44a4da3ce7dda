"""The space of a robot with free bodies, as OMPL has it: SE(3), SE(2), SO(3), and parts for its other joints.

In: a robot with a floating, planar or ball joint; a box for positions. Out: `PoseSpace`: an OMPL state space, and
conversions between its states and configurations. A floating joint is an SE3StateSpace, a planar one an SE2StateSpace,
a ball joint an SO3StateSpace; all other joints are as in `JointSpace`. Several of them are a compound, a part each,
weighted equally.

Motions are OMPL's: positions move straight, and turns by slerp (the path "slerp" of `Checker`). OMPL's slerp has two
peculiarities. Between quaternions that are equal up to `_ALIKE` it stays at the first, and jumps at the end. At half a
turn, rounding chooses the direction. `pieces` takes a motion apart so that what is proved is what OMPL does.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from ompl import base

from plannercheck.common.angles import nearest_turns, wrapped
from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.sampling import MotionSampler
from plannercheck.ompl.curved_space import CurvedSpace
from plannercheck.ompl.joint_space import bounded_space, bounds_of
from plannercheck.ompl.pose_parts import WIDTHS, Kind, Part, limits_of, parts_of
from plannercheck.ompl.projections import register_projection
from plannercheck.robots.robot import Robot

# OMPL keeps the first of two quaternions whose product is nearer to 1 than 1e-9; with room for rounding.
_ALIKE = 2e-9

# So near to half a turn (half its cosine for quaternions, rad for angles) a motion is cut in the middle.
_HALF_TURN_ROOM = 1e-6

# OMPL calls a quaternion valid if its length is 1 up to 1e-9; others are normalised where a state is written.
_UNIT_ROOM = 1e-10


class PoseSpace(CurvedSpace):
    """The configuration space of a robot with free bodies.

    Attributes:
        is_straight: False: a motion back may differ from the motion there, as OMPL keeps the first of two alike turns.
        continuous: (nq,) which columns are angles that a whole turn does not change.
    """

    is_straight: Literal[False] = False

    def __init__(self, robot: Robot, bounds: ArrayLike | None, *held: Floats) -> None:
        """Reads the joints.

        Args:
            robot: The robot.
            bounds: (2, 3) least and largest position of floating and planar joints, m; None for the robot's limits.
            held: Configurations (nq,) that the bounds of joints without limits of their own have to include.

        Raises:
            PlannercheckError: If a joint has no limits and is no angle, or bounds are missing or no box.
        """
        self._robot, self._width = robot, robot.nq
        self._parts = parts_of(robot)
        self.continuous = np.zeros(robot.nq, dtype=bool)
        for part in self._parts:
            self.continuous[part.column] |= part.kind == "angle"
        self._lower, self._upper = limits_of(robot, self._parts, bounds, held)
        last = self._parts[-1]
        self._count = last.number + WIDTHS[last.kind][1]
        self._is_alike = all(part.kind not in ("planar", "circle") for part in self._parts)

    def ompl_space(self) -> Any:
        """A new OMPL state space."""
        spaces = [self._part_space(part) for part in self._parts]
        if len(spaces) == 1:
            return self._numbered(spaces[0], self._count)
        compound = base.CompoundStateSpace()
        for space in spaces:
            compound.addSubspace(space, 1.0)
        register_projection(compound)
        return self._numbered(compound, self._count)

    def _part_space(self, part: Part) -> Any:
        made = {"free": base.SE3StateSpace, "planar": base.SE2StateSpace, "ball": base.SO3StateSpace}.get(part.kind)
        if made is None:
            bounded = part.kind == "number"
            limits = self._lower[part.columns], self._upper[part.columns]
            return bounded_space(*limits) if bounded else base.SO2StateSpace()
        space = made()
        if part.kind != "ball":
            space.setBounds(bounds_of(self._lower[part.position], self._upper[part.position]))
        return space

    # ----- states and configurations

    def read(self, state: Any) -> list[float]:
        """The configuration of an OMPL state, nq numbers; quaternions as they are."""
        numbers = self.numbers.read(state)
        if not self._is_alike:
            numbers = self._expanded(np.array([numbers]))[0].tolist()
        return numbers

    def rows(self, states: list[Any]) -> Floats:
        """(n, nq) the configurations of a path's states; between two that are half a turn apart, the middle as well."""
        rows = self._expanded(self.numbers.rows(states))
        out = [rows[:1]]
        for k in range(1, len(rows)):
            if self._turns_half(rows[k - 1], rows[k]):
                out.append(self.curve_states(states[k - 1], states[k], np.array([0.5])))
            out.append(rows[k : k + 1])
        return np.concatenate(out)

    def _expanded(self, numbers: Floats) -> Floats:
        """Configurations (n, nq) of OMPL's numbers (n, k): cosine and sine for an angle, where they have these."""
        if self._is_alike:
            return numbers
        out = np.empty((len(numbers), self._width))
        for part in self._parts:
            own = numbers[:, part.number : part.number + WIDTHS[part.kind][1]]
            if part.kind in ("planar", "circle"):
                out[:, part.position] = own[:, :-1]
                out[:, part.turn] = np.stack([np.cos(own[:, -1]), np.sin(own[:, -1])], axis=1)
            else:
                out[:, part.columns] = own
        return out

    def write(self, state: Any, q: Sequence[float] | Floats) -> None:
        """Sets an OMPL state to a configuration (nq,); quaternions get length 1, angles are brought to [-pi, pi).

        Raises:
            PlannercheckError: If a position is beyond the space's bounds.
        """
        row = np.asarray(q, dtype=np.float64)
        self._check_within(row)
        for k, part in enumerate(self._parts):
            _write(state if len(self._parts) == 1 else state[k], part.kind, row[part.position], row[part.turn])

    def _check_within(self, q: Floats) -> None:
        for part in self._parts:
            low, high = self._lower[part.position], self._upper[part.position]
            if not ((q[part.position] >= low) & (q[part.position] <= high)).all():
                raise PlannercheckError(
                    f"a body is at {q[part.position].tolist()} m, beyond the bounds {low.tolist()} to {high.tolist()} "
                    "in which it is planned for: give larger ones by bounds="
                )

    def differences(self, q0: Floats, q1: Floats) -> Floats:
        """Differences (…, k) from configurations (…, nq) to others: lengths, and angles the short way."""
        out = []
        for part in self._parts:
            a, b = q0[..., part.turn], q1[..., part.turn]
            out.append(q1[..., part.position] - q0[..., part.position])
            out.append((nearest_turns(a, b) if part.kind == "angle" else b) - a if a.shape[-1] == 1 else _angles(a, b))
        return np.concatenate(out, axis=-1)

    # ----- motions

    def pieces(self, s1: Any, s2: Any) -> tuple[Floats, Floats, Floats, Floats]:
        """A motion of OMPL's as motions on the path "slerp" of which none turns by half a turn.

        Returns:
            Starts and ends (k, nq), one after the other, and then those (m, nq) which OMPL goes besides or instead,
            where turns of both ends are alike: they keep the turn of their start.
        """
        q0, q1 = (np.array(self.read(state)) for state in (s1, s2))
        starts, ends = q0[None], q1[None]
        if self._turns_half(q0, q1):
            (middle,) = self.curve_states(s1, s2, np.array([0.5]))
            starts, ends = np.array([q0, middle]), np.array([middle, q1])
        kept = ends.copy()
        for part in self._parts:
            if part.kind in ("free", "ball") and abs(float(q0[part.turn] @ q1[part.turn])) > 1 - _ALIKE:
                kept[:, part.turn] = starts[:, part.turn]
        others = (kept != ends).any(axis=1)
        return starts, ends, starts[others], kept[others]

    def _turns_half(self, q0: Floats, q1: Floats) -> bool:
        """Whether a joint turns by half a turn, nearly."""
        for part in self._parts:
            a, b = q0[part.turn], q1[part.turn]
            if part.kind in ("free", "ball") and abs(float(a @ b)) < _HALF_TURN_ROOM:
                return True
            if part.kind in ("planar", "circle", "angle"):
                way = abs(float((nearest_turns(a, b) - a)[0] if part.kind == "angle" else _angles(a, b)[0]))
                if way > np.pi - _HALF_TURN_ROOM:
                    return True
        return False

    def curve_steps(self, s1: Any, s2: Any, sampler: MotionSampler, resolution: float | None) -> int:
        """How many steps a motion needs: no point moves over `resolution` m in one."""
        q0, q1 = (np.array([self.read(state)]) for state in (s1, s2))
        return int(sampler.steps(q0, sampler.shorter_turn(q0, q1), resolution)[0])


def _write(state: Any, kind: Kind, position: Floats, turn: Floats) -> None:
    if kind == "free":
        state.setXYZ(*position.tolist())
        _write_quaternion(state.rotation(), turn)
    elif kind == "planar":
        state.setXY(*position.tolist())
        state.setYaw(float(np.arctan2(turn[1], turn[0])))
    elif kind == "ball":
        _write_quaternion(state, turn)
    elif kind == "number":
        state[0] = float(turn[0])
    else:
        angle = np.arctan2(turn[1], turn[0]) if kind == "circle" else wrapped(turn[0])
        state.value = float(angle)


def _write_quaternion(state: Any, turn: Floats) -> None:
    length = float(np.linalg.norm(turn))
    x, y, z, w = (turn if abs(length - 1) <= _UNIT_ROOM else turn / length).tolist()
    state.x, state.y, state.z, state.w = x, y, z, w


def _angles(a: Floats, b: Floats) -> NDArray[np.float64]:
    """(…, 1) the angles between unit quaternions (…, 4), or pairs of cosine and sine (…, 2), the short way, rad."""
    less, more = np.linalg.norm(b - a, axis=-1, keepdims=True), np.linalg.norm(b + a, axis=-1, keepdims=True)
    if a.shape[-1] == 4:  # a quaternion and its negative are the same turn
        return np.asarray(4 * np.arctan2(np.minimum(less, more), np.maximum(less, more)))
    return np.asarray(2 * np.arctan2(less, more))
