"""Planning where an equation holds along the whole path: a cup stays upright, a tool on its plane.

In: a checker with bounded joints, a function of configurations that is to be 0. Out: a `Plan` whose configurations
satisfy it, a step apart, with all motions between them proved free.

OMPL plans (ProjectedStateSpace: Newton's method brings states back to where the function is 0). Its Python bindings
(2.0.1) neither read nor write states of such spaces (ompl issue 1454), but they do pass a state's numbers to a
`Constraint` as an array: `_Numbers` is one that reads and writes them. The bindings do not give OMPL's path between two
states (`discreteGeodesic`), so this module computes the states between them; the path that is proved is the path that
is returned.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from ompl import base, geometric

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import Configuration
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.real_numbers import positive_number
from plannercheck.motions.checker import Checker
from plannercheck.ompl.joint_space import JointSpace
from plannercheck.ompl.planning import LONGEST_MOTION, OMPL_SILENCE, full_name, seed_ompl, shortened, why_not
from plannercheck.ompl.plans import Plan, joint_length
from plannercheck.ompl.searches import made_planner
from plannercheck.ompl.simple_setup import SimpleSetup
from plannercheck.ompl.start_and_goal import check_end_state, checked_end

# Half the width of central differences, rad or m: the cube root of a double's rounding, where both errors are least.
_DIFFERENCE = 6e-6
# A step on the way may be so much longer than planned, and the whole way than the straight one (OMPL's lambda).
_DETOUR = 2.0
# OMPL's own steps, by which it finds where to go next, in rad: coarse, since each costs several calls of the user's
# function, and since what it finds is walked again in the path's steps before it is used.
_STRIDE = 0.4
# OMPL takes no step of 1 or more.
_LONGEST_STRIDE = 0.99
# Steps of Newton's method after which a state is given up. Near a solution each doubles the digits: 5 are many.
_NEWTON_STEPS = 10


def plan_constrained(
    checker: Checker,
    start: Configuration,
    goal: Configuration,
    constraint: Callable[[Floats], ArrayLike],
    jacobian: Callable[[Floats], ArrayLike] | None = None,
    *,
    tolerance: float = 1e-3,
    step: float = 0.05,
    planner: str = "RRTConnect",
    time_limit: float = 10.0,
    simplify: bool = True,
    seed: int | None = None,
) -> Plan:
    """Plans from one configuration to another on which, and between which, a constraint holds.

    Args:
        checker: Who judges states and motions; its robot's joints are bounded.
        start: (nq,) rad and m, or each joint's value by its name.
        goal: (nq,) rad and m, or by names.
        constraint: From configurations (n, nq) to numbers (n, k), k < nq, all 0 where it holds.
        jacobian: From one configuration (nq,) to their derivatives (k, nq); None for central differences.
        tolerance: So large the numbers' Euclidean norm may be, in their unit.
        step: Between configurations of the path, rad; between them the constraint is off by what the motion bends,
            about the square of the step.
        planner: One of `planner_names()`.
        time_limit: For the search, s.
        simplify: Whether to shorten the path.
        seed: As for `plan`.

    Returns:
        The plan: configurations that satisfy the constraint within the tolerance, all motions between them proved free.

    Raises:
        PlannercheckError: If a joint has no limits, or start or goal do not satisfy the constraint.
    """
    if not isinstance(checker, Checker):
        raise PlannercheckError(f"checker must be a pc.Checker, not {checker!r:.80}")
    if not (callable(constraint) and (jacobian is None or callable(jacobian))):
        raise PlannercheckError("constraint and jacobian must be functions of configurations")
    planner = full_name(planner)
    for name, value in (("tolerance", tolerance), ("step", step), ("time_limit", time_limit)):
        positive_number(value, f"{name} must be a positive number")
    space = JointSpace(checker.robot)
    if space.continuous.any():
        names = [name for name, turns in zip(checker.robot.joint_names, space.continuous, strict=True) if turns]
        raise PlannercheckError(f"OMPL plans with constraints for bounded joints only, not for {', '.join(names)}")
    ends = [checked_end(checker, q, name) for name, q in (("start", start), ("goal", goal))]
    equation = _Equation(constraint, jacobian, ends[0], tolerance)
    for name, q in zip(("start", "goal"), ends, strict=True):
        if not equation.isSatisfied(q):
            off = f"{equation.distance(q):.3g} is over the tolerance {tolerance:g}"
            raise PlannercheckError(f"{name} does not satisfy the constraint: {off}")
    reasons = [check_end_state(checker, q).reason(name) for name, q in zip(("start", "goal"), ends, strict=True)]
    if any(reasons):
        return _plan(checker, space, planner, "; ".join(filter(None, reasons)))
    with OMPL_SILENCE():
        seed_ompl(seed)
        return _search(checker, space, equation, ends, planner, step, time_limit, simplify)


class _Equation(base.Constraint):  # type: ignore[misc]  # OMPL's bindings are untyped
    """The user's function, as OMPL asks it."""

    def __init__(
        self,
        values: Callable[[Floats], ArrayLike],
        jacobian: Callable[[Floats], ArrayLike] | None,
        q: Floats,
        tolerance: float,
    ) -> None:
        """Asks once, at a configuration (nq,), how many numbers there are."""
        shape = np.shape(values(np.stack([q, q, q])))
        if len(shape) != 2 or shape[0] != 3 or not 0 < shape[1] < len(q):
            raise PlannercheckError(
                f"a constraint takes (n, {len(q)}) and gives (n, k) with k from 1 to {len(q) - 1}: of 3 configurations "
                f"it gave {shape}"
            )
        super().__init__(len(q), shape[1], tolerance)
        self.setMaxIterations(_NEWTON_STEPS)
        self._values, self._jacobian = values, jacobian

    def function(self, x: Floats, out: Floats) -> None:
        """Writes the numbers (k,) at a configuration."""
        out[:] = np.asarray(self._values(np.array(x)[None]))[0]

    def jacobian(self, x: Floats, out: Floats) -> None:
        """Writes their derivatives (k, nq)."""
        if self._jacobian is not None:
            out[:] = self._jacobian(np.array(x))
            return
        aside = _DIFFERENCE * np.eye(len(x))
        values = np.asarray(self._values(np.concatenate([x + aside, x - aside])))
        out[:] = (values[: len(x)] - values[len(x) :]).T / (2 * _DIFFERENCE)


class _Numbers(base.Constraint):  # type: ignore[misc]
    """Reads and writes states of constrained spaces: OMPL hands the numbers of a state to a constraint."""

    def __init__(self, width: int) -> None:
        super().__init__(width, 1)
        self._row = np.zeros(width)

    def function(self, x: Floats, out: Floats) -> None:
        """Is always satisfied."""
        out[0] = 0.0

    def distance(self, x: Floats) -> float:
        """Takes the numbers (nq,) of a state."""
        self._row = np.array(x)
        return 0.0

    def project(self, x: Floats) -> bool:
        """Puts numbers (nq,) into a state."""
        x[:] = self._row
        return True

    def read(self, state: Any) -> Floats:
        """The configuration (nq,) of a state."""
        base.Constraint.distance(self, state)
        return self._row

    def write(self, state: Any, q: Floats) -> None:
        """Sets a state to a configuration (nq,)."""
        self._row = q
        base.Constraint.project(self, state)


class _Ways:
    """Ways on which the constraint holds: straight motions between states a step apart."""

    def __init__(self, checker: Checker, equation: _Equation, step: float) -> None:
        self.checker, self._equation, self._step = checker, equation, step
        self._lower, self._upper = checker.robot.lower, checker.robot.upper

    def way(self, q0: Floats, q1: Floats) -> Floats | None:
        """Configurations (n, nq) from one to another, each satisfying the constraint; None if there is no short way."""
        rows, at, left = [q0], q0, float(np.linalg.norm(q1 - q0))
        room = _DETOUR * left
        while left > self._step:
            here = at + (self._step / left) * (q1 - at)
            if not self._equation.project(here) or not self._is_within(here):
                return None
            moved, ahead = float(np.linalg.norm(here - at)), float(np.linalg.norm(q1 - here))
            room -= moved
            if moved > _DETOUR * self._step or ahead >= left or room < 0:
                return None
            rows.append(here)
            at, left = here, ahead
        return np.array([*rows, q1])

    def free_way(self, q0: Floats, q1: Floats) -> Floats | None:
        """A way from one configuration to another, walked from either end, with all its motions proved free."""
        if not (self._equation.isSatisfied(q0) and self._equation.isSatisfied(q1)):
            return None  # a sampler drew it elsewhere
        for first, last, turn in ((q0, q1, 1), (q1, q0, -1)):
            rows = self.way(first, last)
            if rows is not None and self._are_free(rows[::turn]):
                return rows[::turn]
        return None

    def _are_free(self, rows: Floats) -> bool:
        return bool(self.checker.check_states(rows).all() and self.checker.check_motions(rows[:-1], rows[1:]).all())

    def is_valid(self, q: Floats) -> bool:
        """Whether a configuration satisfies the constraint, is free and within the limits."""
        return self._is_within(q) and self._equation.isSatisfied(q) and self.checker.is_valid(q)

    def _is_within(self, q: Floats) -> bool:
        return bool((q >= self._lower).all() and (q <= self._upper).all())


class _States(base.StateValidityChecker):  # type: ignore[misc]
    def __init__(self, information: Any, ways: _Ways, numbers: _Numbers) -> None:
        super().__init__(information)
        self._ways, self._numbers = ways, numbers

    def isValid(self, state: Any) -> bool:  # noqa: N802  # OMPL's name
        return self._ways.is_valid(self._numbers.read(state))


class _Motions(base.MotionValidator):  # type: ignore[misc]
    def __init__(self, information: Any, ways: _Ways, numbers: _Numbers) -> None:
        super().__init__(information)
        self._ways, self._numbers = ways, numbers

    def checkMotion(self, s1: Any, s2: Any) -> bool:  # noqa: N802  # OMPL's name
        return self._ways.free_way(self._numbers.read(s1), self._numbers.read(s2)) is not None


def _search(
    checker: Checker,
    space: JointSpace,
    equation: _Equation,
    ends: list[Floats],
    planner: str,
    step: float,
    time_limit: float,
    simplify: bool,
) -> Plan:
    manifold = base.ProjectedStateSpace(space.ompl_space(), equation)
    manifold.setDelta(min(max(step, _STRIDE), _LONGEST_STRIDE))
    manifold.setLambda(_DETOUR)
    setup = SimpleSetup(base.ConstrainedSpaceInformation(manifold))
    information, numbers = setup.getSpaceInformation(), _Numbers(checker.robot.nq)
    ways = _Ways(checker, equation, step)
    setup.setStateValidityChecker(_States(information, ways, numbers))
    information.setMotionValidator(_Motions(information, ways, numbers))
    states = [information.allocState() for _ in ends]
    for state, q in zip(states, ends, strict=True):
        numbers.write(state, q)
    setup.setStartAndGoalStates(*states)
    setup.setPlanner(made_planner(planner, information, LONGEST_MOTION))
    began = time.perf_counter()
    status = setup.solve(base.timedPlannerTerminationCondition(time_limit))
    found = time.perf_counter()
    if not setup.haveExactSolutionPath():
        reason = why_not(planner, setup, status, found - began)
        return _plan(checker, space, planner, reason, spent=found - began)
    solution: geometric.PathGeometric = shortened(setup) if simplify else setup.getSolutionPath()
    corners = [numbers.read(state) for state in solution.getStates()]
    parts = [part for a, b in pairwise(corners) if (part := ways.free_way(a, b)) is not None]
    if len(parts) < len(corners) - 1:  # proved in the other direction alone, by a planner that takes both for one
        return _plan(checker, space, planner, f"{planner} found a path that is not proved free", spent=found - began)
    path = np.concatenate([corners[:1], *(part[1:] for part in parts)])
    return _plan(checker, space, planner, "", path, found - began, time.perf_counter() - found)


def _plan(
    checker: Checker,
    space: JointSpace,
    planner: str,
    reason: str,
    path: Floats | None = None,
    spent: float = 0.0,
    shortening: float = 0.0,
) -> Plan:
    rows = np.empty((0, checker.robot.nq)) if path is None else path
    length = joint_length(rows, space.differences)
    return Plan(path is not None, rows, length, spent, shortening, planner, reason, checker.robot.joint_names)
