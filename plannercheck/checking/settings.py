"""The settings of a checker that do not depend on its scene.

In: the arguments of `Checker`. Out: `Settings` with `CheckerSwitches`, which also apply to another scene.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from plannercheck.bodies.intersection import Switches
from plannercheck.bodies.objects import SceneObject
from plannercheck.bodies.shapes import GeometryObject
from plannercheck.checking.padding import PaddedPairs, Padding, padded_pairs, padding_that_fits
from plannercheck.checking.pair_table import Acm, pair_table
from plannercheck.common.errors import PlannercheckError
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene


@dataclass(frozen=True)
class CheckerSwitches:
    """Ways to save work, each of which can be switched off. Verdicts depend on none of them.

    Attributes:
        pair: The stages of the pair test.
        bounds: Bounding balls and a tree of the obstacles settle pairs that are far apart.
        boxes: Planes along the faces of the bodies' boxes settle pairs that are apart.
        overlaps: A ball inside one body that meets a box inside the other settles a pair, where any collision decides.
        learning: Pairs that collided lately are tested first, where any collision decides.
        reach: Pairs that can't meet within the limits are left out there.
        static_poses: Links that no joint of the group moves are posed once, as obstacles are.
        part_trees: Trees of boxes, many parts at once or along one direction, boxes around several bodies, and looks at
            the heights under a body settle sets of parts. Off, each part is tested by itself, as a body of its own.
        middle_states: The middle states of several motions are judged first, together; then the ends, where these often
            collide.
        sorted_states: Like states of a set are judged together.
        float_poses: Filters of sets look at poses in floats, whose error is bounded.
        apart_cells: Pairs whose relative pose depends on one or two joints are looked up in cells proved apart.
    """

    pair: Switches = field(default_factory=Switches)
    bounds: bool = True
    boxes: bool = True
    overlaps: bool = True
    learning: bool = True
    reach: bool = True
    static_poses: bool = True
    middle_states: bool = True
    part_trees: bool = True
    sorted_states: bool = True
    float_poses: bool = True
    apart_cells: bool = True

    def core_options(self) -> tuple[Any, ...]:
        """The switches in the order in which core.Checker takes them."""
        return (
            self.pair.pair_options(),
            self.bounds,
            self.boxes,
            self.overlaps,
            self.learning,
            self.part_trees,
            self.sorted_states,
            self.float_poses,
        )


@dataclass(frozen=True)
class Settings:
    """The arguments of a checker that apply to any scene; see `Checker`."""

    robot: Robot
    self_collision: bool
    padding: Padding
    acm: Acm
    kinematics: str
    bodies: Sequence[GeometryObject] | None
    switches: CheckerSwitches

    def __post_init__(self) -> None:
        if isinstance(self.padding, Mapping):  # whoever gave it may change it, and a later scene asks for it again
            object.__setattr__(self, "padding", dict(self.padding))

    def carrier(self, attached: Sequence[SceneObject], earlier: Robot | None) -> Robot:
        """The robot with what a scene attaches to it: an earlier checker's robot, if that carries the same."""
        carried = (*self.robot.carried, *attached)
        if earlier is not None and earlier.carried == carried:
            return earlier
        return self.robot.carrying(carried) if attached else self.robot

    def padded(self, robot: Robot, scene: Scene, is_first: bool) -> PaddedPairs:
        """All bodies of a robot and a scene, and two tables of pairs: the tested ones, and those fixed to the world.

        Args:
            robot: The robot with what it carries.
            scene: The scene with the obstacles.
            is_first: Whether every entry of a padding has to fit; a later scene sets aside entries that do not, and a
                still later one takes them again.
        """
        bodies = substitute_bodies(self.bodies, (*robot.bodies, *scene.bodies))
        table = pair_table(robot, scene, self.self_collision, self.acm)
        labels = (*(body.label for body in robot.bodies), *scene.body_objects)
        tables = (table.pairs, table.static)
        padding = self.padding if is_first else padding_that_fits(self.padding, bodies, labels, tables)
        return padded_pairs(padding, bodies, labels, tables)


def without_attached(robot: Robot, attached: Sequence[SceneObject]) -> Robot:
    """The robot without what a scene attaches to it; the robot of another checker may carry that already."""
    names = {item.name for item in attached}
    if names.isdisjoint(item.name for item in robot.carried):
        return robot
    return robot.carrying(item for item in robot.carried if item.name not in names)


def substitute_bodies(
    given: Sequence[GeometryObject] | None, bodies: tuple[GeometryObject, ...]
) -> tuple[GeometryObject, ...]:
    """The bodies that are given in place of others, on the same links."""
    if given is None:
        return bodies
    if [body.link for body in given] != [body.link for body in bodies]:
        raise PlannercheckError(
            f"bodies must stand in for the {len(bodies)} of the robot and the scene, each on the same link"
        )
    return tuple(given)
