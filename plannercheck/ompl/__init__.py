"""Planning with OMPL: a checker as the judge of states and motions.

Read `planning` first (`setup` and `plan`), then `joint_space`, `pose_space` with `pose_parts` and `pose_bounds`,
`planar_space`, `state_numbers` and `projections` (configurations as OMPL has them), `motion_validators` (the checker
as OMPL's validator), `prepared_spaces` (all of these together with a validator of states, reused by later
plans), `simple_setup` (checks that OMPL lacks), `searches` with `near_first` (planners at work), `goals`,
`start_and_goal`, `angle_checkers`, `constrained` (equations that hold along the whole path), `clearance` (an objective)
and `plans`. OMPL itself is loaded on first use, so that `plans` and `joint_space` can be had without it.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from plannercheck.ompl.constrained import plan_constrained as plan_constrained
    from plannercheck.ompl.planning import LONGEST_MOTION as LONGEST_MOTION
    from plannercheck.ompl.planning import SIMPLIFICATION_TIME as SIMPLIFICATION_TIME
    from plannercheck.ompl.planning import clearance_objective as clearance_objective
    from plannercheck.ompl.planning import plan as plan
    from plannercheck.ompl.planning import planner_names as planner_names
    from plannercheck.ompl.planning import setup as setup
    from plannercheck.ompl.prepared_spaces import space_of as space_of

__all__ = [
    "LONGEST_MOTION",
    "SIMPLIFICATION_TIME",
    "clearance_objective",
    "plan",
    "plan_constrained",
    "planner_names",
    "setup",
    "space_of",
]


_HOMES = {"plan_constrained": "constrained", "space_of": "prepared_spaces"}


def __getattr__(name: str) -> Any:
    if name in __all__:
        found = getattr(importlib.import_module(f"plannercheck.ompl.{_HOMES.get(name, 'planning')}"), name)
        globals()[name] = found  # asked once for each name
        return found
    raise AttributeError(f"module 'plannercheck.ompl' has no attribute {name!r}")
