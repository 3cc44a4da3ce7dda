"""What the primitives of neighbouring links hold of a link in every configuration.

In: a robot and the primitives of its links. Out: for a link, spheres in its frame that lie in the primitives of others
whatever the joints do. Links without a joint that moves between them keep their places: their primitives count as they
are. A sphere across one joint is cut down to the sphere that it holds at all values of the joint: about the nearest
point of the axis of a turn, smaller by its distance from the axis; in the middle of a slide, smaller by half its
length. Other joints count for nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pinocchio as pin

from plannercheck.common.array_types import Floats
from plannercheck.coverings.primitives import Primitives
from plannercheck.coverings.regions import posed
from plannercheck.robots.configurations import followed
from plannercheck.robots.joints import CIRCLE, SLIDE, TURN, kind_of
from plannercheck.robots.robot import Robot

# m: by which spheres of other links are smaller, for the rounding of poses: far more than it is.
_ROUNDING = 1e-9


def of_neighbours(robot: Robot, covers: Mapping[str, Primitives], link: str) -> Primitives:
    """The spheres, capsules and boxes of other links that count for a link, in its frame."""
    found = Primitives.of()
    poses = robot.link_poses(robot.reference)
    own = np.linalg.inv(poses[robot.link_index(link)])
    for name, joint in _reached(robot, link).items():
        cover = covers.get(name)
        if cover is None or not len(cover):
            continue
        relative = own @ poses[robot.link_index(name)]
        if joint is None:
            found += _shrunk(_moved(cover, relative))
        else:
            found += _held(robot, joint, own, _moved(cover, relative))
    return found


def _reached(robot: Robot, link: str) -> dict[str, str | None]:
    """The other links with at most one joint between that moves, and this joint."""
    tree = robot.link_tree
    edges: dict[str, list[tuple[str, str]]] = {}
    for child, parent in tree.parents.items():
        edges.setdefault(child, []).append((parent, tree.joints[child]))
        edges.setdefault(parent, []).append((child, tree.joints[child]))
    found: dict[str, str | None] = {link: None}
    stack = [link]
    while stack:
        at = stack.pop()
        for near, joint in edges.get(at, ()):
            moving = joint if _moves(robot, joint) else None
            if near in found or (moving is not None and found[at] is not None):
                continue
            found[near] = moving if moving is not None else found[at]
            stack.append(near)
    return {name: joint for name, joint in found.items() if name != link}


def _moves(robot: Robot, joint: str) -> bool:
    if not robot.model.existJointName(joint):
        return False
    if robot.group is None:
        return True
    return followed(joint, robot.mimics, robot.joint_names)[0] in robot.joint_names


def _moved(cover: Primitives, pose: Floats) -> Primitives:
    return Primitives(posed(cover.ends, pose), cover.radii, pose @ cover.frames, cover.halves)


def _shrunk(cover: Primitives) -> Primitives:
    radii, halves = cover.radii - _ROUNDING, cover.halves - _ROUNDING
    keep, boxes = radii > 0, (halves > 0).all(axis=1)
    return Primitives(cover.ends[keep], radii[keep], cover.frames[boxes], halves[boxes])


def _held(robot: Robot, joint: str, own: Floats, cover: Primitives) -> Primitives:
    """What spheres (n, 3) of a link's frame at the reference hold at all values of a joint; other primitives: nothing.

    `own` (4, 4) is the world in the link's frame; the cover is that of the link across the joint, in the link's frame.
    """
    index = robot.model.getJointId(joint)
    if robot.joint_table is None or joint in robot.mimics:  # a follower's own limits say nothing
        return Primitives.of()
    kind, place = kind_of(robot.model.joints[index]), own @ _joint_pose(robot, index)
    spheres = (cover.ends[:, 0] == cover.ends[:, 1]).all(axis=1)
    centres, radii = cover.ends[spheres, 0], cover.radii[spheres]
    axis = place[:3, :3] @ robot.joint_table.axes[index - 1]
    from_axis = centres - place[:3, 3]
    if kind in (TURN, CIRCLE):
        feet = place[:3, 3] + np.outer(from_axis @ axis, axis)
        radii = radii - np.linalg.norm(centres - feet, axis=1)
    elif kind is SLIDE:
        low, high = _slide(robot, index)
        feet, radii = centres + (low + high) / 2 * axis, radii - (high - low) / 2
    else:
        return Primitives.of()
    return _shrunk(replace(Primitives.of(), ends=np.stack([feet, feet], axis=1), radii=radii))


def _joint_pose(robot: Robot, index: int) -> Floats:
    """(4, 4) of a joint's moving frame in the world at the reference."""
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, robot.expand(robot.reference))
    return np.asarray(data.oMi[index].homogeneous)


def _slide(robot: Robot, index: int) -> tuple[float, float]:
    """How far a slide moves from the reference, within its limits."""
    joint = robot.model.joints[index]
    at = float(robot.expand(robot.reference)[joint.idx_q])
    low, high = (
        float(limit[joint.idx_q]) for limit in (robot.model.lowerPositionLimit, robot.model.upperPositionLimit)
    )
    return (low - at, high - at) if np.isfinite([low, high]).all() else (-np.inf, np.inf)
