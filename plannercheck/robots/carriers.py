"""Joints that carry what moves in a scene, beside those of a robot.

In: a robot, carriers. Out: `CarriedRobot`: the robot with each carrier's joints under the world and a link for each
object. Its configurations are the robot's numbers, then each carrier's; its bodies and pairs are the robot's.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio as pin

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import read_only
from plannercheck.common.errors import PlannercheckError
from plannercheck.robots.cells import append
from plannercheck.robots.configurations import ConfigurationMap, side_by_side, whole_robot
from plannercheck.robots.forward_kinematics import ForwardKinematics
from plannercheck.robots.joint_values import JointValues
from plannercheck.robots.robot import Robot
from plannercheck.robots.robot_memory import RobotMemory
from plannercheck.robots.urdf import link_tree

# Limits are wider than what a carrier runs through by this part, so that rounding stays within them.
_ROOM = 1e-9

# Limits of the numbers of a unit vector.
_UNIT = 1.01


@dataclass(frozen=True, eq=False)
class Carrier:
    """Joints that move objects.

    Attributes:
        name: Before the names of its joints and links, with a slash; that of its only joint if they have none.
        model: Pinocchio's.
        sources: Its columns.
        base: (4, 4) its base in the world, m.
        links: By name of each object, the name of the link in `model` that it rides on; "" for the one joint.
        first: (width,) its first configuration, rad and m.
        low: (width,) the least of each number that it runs through.
        high: (width,) the largest.
    """

    name: str
    model: pin.Model
    sources: ConfigurationMap
    base: Floats
    links: Mapping[str, str]
    first: Floats
    low: Floats
    high: Floats

    def named(self, own: str) -> str:
        """The name that one of its joints or links has beside the robot."""
        return f"{self.name}/{own}" if own else self.name

    @property
    def names(self) -> tuple[list[str], list[str]]:
        """Of its joints, and of its links and the objects' ones, beside the robot."""
        own = [frame.name for frame in self.model.frames if frame.type == pin.FrameType.BODY]
        return [self.named(each) for each in list(self.model.names)[1:]], [*map(self.named, own), *self.links]

    @property
    def limited(self) -> ConfigurationMap:
        """Its columns with what it runs through as their limits."""
        room = _ROOM * (1 + np.maximum(np.abs(self.low), np.abs(self.high)))
        low, high = self.low - room, self.high + room
        for first, past in self.sources.units:
            low[first:past], high[first:past] = -_UNIT, _UNIT
        return replace(self.sources, lower=low, upper=high)


def free_carrier(objects: Sequence[str], rows: Floats) -> Carrier:
    """A free joint under the world that goes through poses, (m, 7) position and quaternion."""
    model = pin.Model()
    model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "")
    links = dict.fromkeys(objects, "")
    bounds = rows.min(axis=0), rows.max(axis=0)
    return Carrier(objects[0], model, whole_robot(model), np.eye(4), links, rows[0], *bounds)


class CarriedRobot(Robot):
    """A robot with carriers; `own_width` is the number of its columns without them."""

    def __init__(self, robot: Robot, carriers: Sequence[Carrier]) -> None:
        """Appends carriers to a robot, which keeps its columns, names and what it carries."""
        self._origin = robot, tuple(carriers)
        _check_names(robot, carriers)
        model = pin.Model(robot.model)
        for carrier in carriers:
            _append(model, carrier)
        tree = link_tree(model)
        parts = robot.parts_of_files()
        self._parts = replace(parts, model=model, tree=tree, memory=RobotMemory(), carried=robot.carried)
        self.name, self.model, self.group = robot.name, model, robot.group
        self.disabled_pairs, self.pieces, self.open_links = robot.disabled_pairs, robot.pieces, robot.open_links
        self._map = side_by_side(model, [robot.configuration_map, *(carrier.limited for carrier in carriers)])
        self.reference = read_only(np.concatenate([robot.reference, *(carrier.first for carrier in carriers)]))
        self._forward = ForwardKinematics(model, self._map, tree.frames, robot.name)
        self._carry(robot.carried)

    @property
    def own_width(self) -> int:
        """Numbers of a configuration of the robot without carriers."""
        return self._origin[0].nq

    @cached_property
    def joint_values(self) -> JointValues:
        """Configurations by their numbers alone."""
        return JointValues(self._map, self._parts.model, self._parts.mimics, is_whole=False)

    def __copy__(self) -> CarriedRobot:
        other = object.__new__(CarriedRobot)
        other.__dict__.update(self.__dict__)
        return other

    def __reduce__(self) -> tuple[Any, ...]:
        robot, carriers = self._origin
        return CarriedRobot, (robot.carrying(self.carried), carriers)


def _check_names(robot: Robot, carriers: Sequence[Carrier]) -> None:
    """Raises if two joints or two links would have one name, by which Pinocchio finds the first alone."""
    for k, known in enumerate((list(robot.model.names), robot.link_names)):
        names = [name for carrier in carriers for name in carrier.names[k]]
        twice = next((name for name, count in Counter(names).items() if count > 1 or name in known), None)
        if twice is not None:
            raise PlannercheckError(
                f"the name {twice!r} would be that of two {('joints', 'links')[k]}, since what carries an object that"
                " moves has its name: rename the object"
            )


def _append(model: pin.Model, carrier: Carrier) -> None:
    """Appends a carrier's joints and frames, and a link for each object on it."""
    name, count = carrier.name, model.njoints - 1
    append(model, carrier.model, carrier.named, pin.SE3(carrier.base))
    if not any(carrier.links.values()):
        joint = pin.Frame(name, count + 1, 0, pin.SE3.Identity(), pin.FrameType.JOINT)
        above = model.addFrame(joint)
    for item, link in carrier.links.items():
        if link:
            above = model.getBodyId(f"{name}/{link}")
        joint, placement = model.frames[above].parentJoint, model.frames[above].placement
        model.addFrame(pin.Frame(item, joint, above, placement, pin.FrameType.BODY))
