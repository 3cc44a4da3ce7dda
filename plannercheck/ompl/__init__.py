"""Planning with OMPL: a checker as the judge of states and motions.

Read `planning` first (`setup` and `plan`), then `joint_space` and `planar_space` (configurations as OMPL's states),
`state_validators` and `motion_validators` (the checker behind OMPL's interfaces), `clearance` (an objective),
`start_and_goal` and `plans`. OMPL itself is loaded on first use, so `plans` and `joint_space` can be used without it.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from plannercheck.ompl.planning import LONGEST_MOTION as LONGEST_MOTION
    from plannercheck.ompl.planning import SIMPLIFICATION_TIME as SIMPLIFICATION_TIME
    from plannercheck.ompl.planning import clearance_objective as clearance_objective
    from plannercheck.ompl.planning import plan as plan
    from plannercheck.ompl.planning import planner_names as planner_names
    from plannercheck.ompl.planning import setup as setup
    from plannercheck.ompl.planning import space_of as space_of

__all__ = [
    "LONGEST_MOTION",
    "SIMPLIFICATION_TIME",
    "clearance_objective",
    "plan",
    "planner_names",
    "setup",
    "space_of",
]


def __getattr__(name: str) -> Any:
    if name in __all__:
        return getattr(importlib.import_module("plannercheck.ompl.planning"), name)
    raise AttributeError(f"module 'plannercheck.ompl' has no attribute {name!r}")
