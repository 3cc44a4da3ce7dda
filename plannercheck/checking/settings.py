"""What a checker keeps whatever its scene, and how it names what touches for good.

In: the arguments of `Checker`. Out: `Settings`, and what of them holds in another scene.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from plannercheck.bodies.objects import SceneObject
from plannercheck.bodies.shapes import Body
from plannercheck.checking.padding import Padding
from plannercheck.checking.pair_table import Acm
from plannercheck.common.errors import PlannercheckError
from plannercheck.robots.robot import Robot

UNCOUNTED = (
    "{0!r} of {robot}, which is fixed to the world, touches obstacle {1!r}; "
    "this pair is not counted at any configuration"
)
COUNTED = (
    "{1!r}, which a link of {robot} carries, touches {0!r} at every configuration, since no joint of the group moves "
    "one against the other: no configuration is valid unless {0!r} is one of its touch_links"
)


@dataclass(frozen=True)
class Settings:
    """What a checker was built with and keeps in any scene; see `Checker`."""

    robot: Robot
    self_collision: bool
    padding: Padding
    acm: Acm
    kinematics: str
    bodies: Sequence[Body] | None
    reach: bool
    static_poses: bool


def without(robot: Robot, attached: Sequence[SceneObject]) -> Robot:
    """The robot without what a scene attaches to it: the robot of another checker carries that already."""
    names = {item.name for item in attached}
    if names.isdisjoint(item.name for item in robot.carried):
        return robot
    return robot.carrying(item for item in robot.carried if item.name not in names)


def known_parts(padding: Padding, bodies: Sequence[Body], labels: Sequence[str]) -> Padding:
    """Paddings without the names of what the scene has no more."""
    if not isinstance(padding, Mapping):
        return padding
    names = {*labels, *(body.name for body in bodies)}
    return {
        name: length for name, length in padding.items() if names.issuperset([name] if isinstance(name, str) else name)
    }


def stand_ins(given: Sequence[Body] | None, bodies: tuple[Body, ...]) -> tuple[Body, ...]:
    """The bodies that are given in place of others, on the same links."""
    if given is None:
        return bodies
    if [body.link for body in given] != [body.link for body in bodies]:
        raise PlannercheckError(
            f"bodies must stand in for the {len(bodies)} of the robot and the scene, each on the same link"
        )
    return tuple(given)
