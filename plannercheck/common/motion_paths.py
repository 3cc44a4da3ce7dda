"""The paths of joints that turn as well as slide: planar and floating ones.

In: nothing. Out: the names of the paths. On "screw" such a joint follows the one screw that leads from start to end
(Pinocchio's interpolation). On "slerp" its position moves on a straight line, and it turns in the shorter direction at
constant speed (OMPL's interpolation in SE(2) and SE(3)). All other joints move alike on both.
"""

from __future__ import annotations

from typing import Literal, TypeAlias

from plannercheck.common.errors import unknown_name

MotionPath: TypeAlias = Literal["screw", "slerp"]
PATHS: tuple[MotionPath, ...] = ("screw", "slerp")


def check_path(path: MotionPath) -> None:
    """Raises unless a path has one of the names."""
    if path not in PATHS:
        raise unknown_name("path", path, PATHS)
