"""The settings of a checker that do not depend on its scene.

In: the arguments of `Checker`. Out: `Settings`, which also apply to another scene.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from plannercheck.bodies.objects import SceneObject
from plannercheck.bodies.shapes import GeometryObject
from plannercheck.bodies.tuning import Tuning
from plannercheck.checking.padding import PaddedPairs, Padding, padded_pairs, padding_that_fits
from plannercheck.checking.pair_table import Acm, pair_table
from plannercheck.common.errors import PlannercheckError
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene


@dataclass(frozen=True)
class Settings:
    """The arguments of a checker that apply to any scene, see `Checker`; `on_clock`: the robot carries what moves."""

    robot: Robot
    self_collision: bool
    padding: Padding
    acm: Acm
    kinematics: str
    bodies: Sequence[GeometryObject] | None
    tuning: Tuning
    on_clock: bool = False

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
    """The bodies that are given in place of others, on the same links; copies for pairs behind them are left out."""
    if given is None:
        return bodies
    own, copies = tuple(given[: len(bodies)]), given[len(bodies) :]
    if [body.link for body in own] != [body.link for body in bodies] or not set(copies) <= set(own):
        raise PlannercheckError(
            f"bodies must stand in for the {len(bodies)} of the robot and the scene, each on the same link; pairs with "
            "a padding of their own get copies of these"
        )
    return own
