"""Places objects of a scene whose pose is given in a link's frame.

In: a robot, a scene. Out: the same scene, in which every object is posed in the world or on its link (see
robots/objects_in_frames.py), or an error if MoveIt would take one of its frames for another frame.
"""

from __future__ import annotations

import numpy as np

from plannercheck.common.errors import PlannercheckError
from plannercheck.robots.objects_in_frames import placed
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene


def place_objects(robot: Robot, scene: Scene) -> None:
    """Places all objects of a scene, which is changed; afterwards it has no pose frames. Frames are the robot's links.

    Raises:
        PlannercheckError: If a frame is unknown, if the state does not say where it is, or if the robot has a link with
            the name of an obstacle, or of a frame that is no link in the file.
    """
    _check_planning_frame(robot, scene)
    items = (*scene.objects, *scene.attached)
    for item in items:
        if item.frame and item.frame in robot.link_names:
            raise PlannercheckError(
                f"object {item.name!r}: frame {item.frame!r} is one of the scene's, but also a link of "
                f"{robot.name!r}, which MoveIt would take: rename one of them"
            )
    _check_names(robot, scene)
    scene.placed(placed(robot, [item for item in items if item.pose_frame is not None]))


def _check_names(robot: Robot, scene: Scene) -> None:
    """Raises if an obstacle has the name of a link, or of what the robot carries.

    What moves is a link itself, whose name its clock has checked.
    """
    carried = {item.name for item in robot.carried}
    for item in scene.objects:
        if item.name in carried:
            raise PlannercheckError(
                f"object {item.name!r} has the name of one that {robot.name!r} carries: rename it, or take the robot "
                "without it, robot.carrying(())"
            )
        if item.moving is None and item.name in robot.link_names:
            raise PlannercheckError(
                f"object {item.name!r} has the name of a link of {robot.name!r}, so what the scene allows the link "
                "would hold for the object: rename the object"
            )


def _check_planning_frame(robot: Robot, scene: Scene) -> None:
    """Raises if the scene's planning frame is a link of the robot that does not always stand at the world's origin."""
    planning = scene.frames.planning
    if planning in robot.link_names and not _is_at_origin(robot, planning):
        raise PlannercheckError(
            f"the scene's planning frame (child_frame_id of its fixed_frame_transforms) is {planning!r}, a link of "
            f"{robot.name!r}, but not its root: MoveIt's is the root link or the parent of the virtual joint"
        )


def _is_at_origin(robot: Robot, link: str) -> bool:
    """Whether a link is fixed to the world with the same frame, e.g. base_link where the URDF's root is world.

    The root of a floating robot is taken as it is before it moves.
    """
    frame = robot.model.frames[robot.frames[robot.link_index(link)]]
    joint = frame.parentJoint
    if joint and (link in robot.link_tree.parents or robot.model.parents[joint]):
        return False
    return np.array_equal((robot.model.jointPlacements[joint] * frame.placement).homogeneous, np.eye(4))
