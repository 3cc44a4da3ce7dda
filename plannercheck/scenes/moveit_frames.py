"""Frames of a MoveIt planning scene, and the poses of objects in them.

In: `fixed_frame_transforms` of a parsed planning scene, and the scene as built so far. Out: `SceneFrames`, and objects
posed in the world, or with a pose frame where the pose depends on the robot.

The rules are those of MoveIt's sources. `Transforms::copyTransforms` and `setTransform` (moveit_core, transforms.cpp)
put the frame's name into header.frame_id and the planning frame into child_frame_id; the transform takes points of that
frame to the planning frame. `PlanningScene::getFrameTransform` and `RobotState::getFrameInfo` drop leading slashes.
They then search the planning frame, links, attached objects and their subframes ("object/subframe"), obstacles and
their subframes, and fixed frames, in this order. Links are not known here, so any other name is taken for a link's; a
checker refuses frames of other kinds that have a link's name.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.objects import PoseFrame, SceneFrames, SceneObject, StatedJoints
from plannercheck.common.arrays import read_only
from plannercheck.common.checked_yaml import Node, check_keys, error_context, mapping, required, sequence
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.transforms import is_identity
from plannercheck.scenes.contents import SceneContents
from plannercheck.scenes.moveit_messages import frame_name, header_frame, transform

Matrix = NDArray[np.float64]

# The frame of messages without a header: robowflex and MotionBenchMaker leave out headers that name it.
_DEFAULT = "world"


def scene_frames(document: Node) -> SceneFrames:
    """The planning frame and the fixed frames of a planning scene."""
    planning = ""
    fixed: dict[str, Matrix] = {}
    for k, item in enumerate(sequence(document.get("fixed_frame_transforms"), "'fixed_frame_transforms'")):
        with error_context(f"fixed_frame_transforms {k}"):
            node = mapping(item, "it")
            check_keys(node, ("header", "child_frame_id", "transform"))
            name = header_frame(node) or _DEFAULT
            target = frame_name(required(node, "child_frame_id"), "child_frame_id")
            if not target or planning not in ("", target):
                raise PlannercheckError(
                    f"child_frame_id is {target!r}, but all have to name the planning frame"
                    f"{f', which others call {planning!r}' if planning else ''}; the frame that a transform places "
                    "is header.frame_id"
                )
            planning = target
            pose = transform(mapping(required(node, "transform"), "'transform'"))
            if name in fixed and not np.array_equal(fixed[name], pose):
                raise PlannercheckError(f"frame {name!r} has another transform already")
            fixed[name] = pose
    if planning in fixed and not is_identity(fixed.pop(planning)):
        raise PlannercheckError(f"fixed_frame_transforms: the planning frame {planning!r} must be at the identity")
    return SceneFrames(planning, fixed)


@dataclass(frozen=True)
class Frame:
    """A frame and its pose.

    Attributes:
        pose_frame: The link that it is fixed to, and the robot state; None for the world.
        pose: (4, 4) in the world or on that link, m.
        name: Its name in the file if it is a fixed frame or an object's; else empty.
    """

    pose_frame: PoseFrame | None
    pose: Matrix
    name: str = ""

    @property
    def is_world(self) -> bool:
        """Whether it is the planning frame itself."""
        return self is _WORLD or (self.pose_frame is None and not self.name and is_identity(self.pose))

    def holds(self, item: SceneObject) -> SceneObject:
        """The object whose pose is given in this frame, posed in the world or with a pose frame."""
        if self.is_world and item.pose_frame is None and not item.frame:
            return item
        return dataclasses.replace(item.moved(self.pose @ item.pose), pose_frame=self.pose_frame, frame=self.name)


_WORLD = Frame(None, read_only(np.eye(4)))


def find_frame(scene: SceneContents, name: str, state: StatedJoints, later: Collection[str] = ()) -> Frame:
    """Finds a frame by name; a name that is none of the scene's is taken for a link's.

    Args:
        scene: The scene with its frames and the objects read so far.
        name: The frame's name, without leading slashes; "" if a header names none.
        state: The joints at which links are to be posed.
        later: Names of objects that have not been read yet.

    Returns:
        The frame.

    Raises:
        PlannercheckError: If the frame is that of a later object, or if a missing name could mean two frames.
    """
    frames = scene.frames
    if name in _planning_names(frames):
        return _WORLD
    if not name:
        raise PlannercheckError(
            f"its header names no frame, which could be {_DEFAULT!r} or the planning frame {frames.planning!r}: name it"
        )
    for item in (*scene.attached, *scene.objects):
        if name == item.name:
            return _frame_of(item, np.eye(4), state, name)
    for item in (*scene.attached, *scene.objects):
        subframe = item.subframes.get(name.removeprefix(f"{item.name}/"))
        if subframe is not None and name.startswith(f"{item.name}/"):
            return _frame_of(item, subframe, state, name)
    if name in frames.fixed:
        return Frame(None, frames.fixed[name], name)
    if any(name == other or name.startswith(f"{other}/") for other in later):
        raise PlannercheckError(f"frame {name!r} is of an object that comes later: put that object before this one")
    return Frame(PoseFrame(name, state, _known(scene)), np.eye(4))


def _planning_names(frames: SceneFrames) -> set[str]:
    """Names of the planning frame; the empty name is one if it can't mean another frame."""
    names = {frames.planning or _DEFAULT}
    world = frames.fixed.get(_DEFAULT)
    return names if world is not None and not is_identity(world) else names | {""}


def _frame_of(item: SceneObject, subframe: Matrix, state: StatedJoints, name: str) -> Frame:
    """An object's frame, or a subframe of it, at the object's own state, else at the given one."""
    if item.pose_frame is None:
        return Frame(None if item.link is None else PoseFrame(item.link, state), item.pose @ subframe, name)
    if item.pose_frame.state != state:
        raise PlannercheckError(
            f"frame {name!r} is of an object that is placed at another robot state: give one robot_state to both"
        )
    return Frame(item.pose_frame, item.pose @ subframe, name)


def _known(scene: SceneContents) -> tuple[str, ...]:
    """Names of all frames of a scene besides links."""
    names: Iterable[str] = (scene.frames.planning or _DEFAULT, *scene.frames.fixed)
    objects = (*scene.objects, *scene.attached)
    return (*names, *(f"{item.name}{sub}" for item in objects for sub in ("", *(f"/{s}" for s in item.subframes))))
