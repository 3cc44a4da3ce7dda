"""Joints that carry objects along screws, from pose to pose.

In: poses. Out: a `Carrier` and the numbers of its joints at each pose. From pose k to pose k + 1 the world's screw S(s)
turns about an axis and slides along it, both at constant speed, so the pose on the way is S(s) A(k). Each step has a
joint that slides and one that turns on its own axis; the chain begins with those of the last step, and those of other
steps stand still at their start or end. So screws are bounded and proved as any robot's joints.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.robots.carriers import Carrier
from plannercheck.robots.configurations import whole_robot

# Beyond these, posing an object takes long, and rounding is large.
_MOST_STEPS, _FURTHEST = 50, 1e3

_LINK = "carried"


class _Screw(NamedTuple):
    """A turn, rad, about the z axis of a frame in the world, and a slide along it, m."""

    frame: pin.SE3
    turn: float
    slide: float


def screw_carrier(objects: Sequence[str], rows: Floats) -> tuple[Carrier, Floats]:
    """The joints that carry named objects along screws to positions and quaternions (m, 7), m.

    The numbers of the joints at each pose are (m, width).

    Raises:
        PlannercheckError: If there are too many steps, or an axis is too far away.
    """
    if len(rows) - 1 > _MOST_STEPS:
        raise PlannercheckError(
            f"object {objects[0]!r} moves along {len(rows) - 1} screws, and at most {_MOST_STEPS} are posed: give more"
            " poses by path='slerp', or several objects"
        )
    poses = [pin.XYZQUATToSE3(row) for row in rows]
    model, at_rest, parent = pin.Model(), pin.SE3.Identity(), 0
    columns = list[Floats]()
    for k in range(len(poses) - 2, -1, -1):
        screw = _screw(poses[k], poses[k + 1], f"poses {k} and {k + 1} of object {objects[0]!r}")
        after = np.arange(len(poses)) > k
        for joint, name, value in _joints(screw, k):
            parent = model.addJoint(parent, joint, at_rest.actInv(screw.frame), name)
            columns.append(np.where(after, value, 0.0))
            at_rest = screw.frame
    model.addFrame(pin.Frame(_LINK, parent, 0, at_rest.actInv(poses[0]), pin.FrameType.BODY))
    values = np.stack(columns, axis=1) if columns else np.zeros((len(rows), 0))
    links = dict.fromkeys(objects, _LINK)
    bounds = values.min(axis=0), values.max(axis=0)
    return Carrier(objects[0], model, whole_robot(model), np.eye(4), links, values[0], *bounds), values


def _joints(screw: _Screw, step: int) -> Iterator[tuple[pin.JointModel, str, float]]:
    """The joints of a step, those that do not move left out."""
    if screw.slide:
        yield pin.JointModelPZ(), f"slide {step}", screw.slide
    if screw.turn:
        yield pin.JointModelRZ(), f"turn {step}", screw.turn


def _screw(start: pin.SE3, end: pin.SE3, what: str) -> _Screw:
    """The screw that leads from a pose to the next one the short way."""
    turned = pin.log3(end.rotation @ start.rotation.T) if (start.rotation != end.rotation).any() else np.zeros(3)
    angle = float(np.linalg.norm(turned))
    way = end.translation - start.translation
    along = turned if angle else way
    length = float(np.linalg.norm(along))
    axis = along / length if length else np.array([0.0, 0.0, 1.0])
    slide = float(way @ axis)
    point = start.translation.copy()
    if angle:
        across = way - slide * axis
        point += (across + np.cross(axis, across) / np.tan(angle / 2)) / 2
        if not np.abs(point).max() <= _FURTHEST:
            raise PlannercheckError(
                f"{what} turn so little that their screw's axis is {np.abs(point).max():.3g} m away, and at most"
                f" {_FURTHEST:g} m are taken: let the step slide alone, or use path='slerp'"
            )
    return _Screw(pin.SE3(_facing(axis), point), angle, slide)


def _facing(axis: Floats) -> Floats:
    """(3, 3) a rotation whose z axis this is."""
    least = np.eye(3)[int(np.abs(axis).argmin())]
    x = np.cross(least, axis)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])
