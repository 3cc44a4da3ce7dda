"""Objects that a MoveIt robot state attaches to links.

In: `attached_collision_objects` of a parsed robot state, and its scene. Out: the scene with these objects attached.

As in MoveIt (`PlanningScene::processAttachedCollisionObjectMsg`), an object without shapes is the obstacle of that
name, attached where it stands. An object with shapes replaces an object of that name. Its pose is relative to the frame
that its header names: the link itself, as MoveIt writes it, another link, a fixed frame, or another object's frame. In
the latter cases the pose on the link is known once a robot can be posed at the state's joint values.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from plannercheck.bodies.objects import PoseFrame, SceneObject, StatedJoints, scene_object
from plannercheck.common.checked_yaml import Node, check_keys, error_context, mapping, required, sequence, text
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.scenes.contents import SceneContents
from plannercheck.scenes.moveit_frames import find_frame
from plannercheck.scenes.moveit_objects import ObjectMessage, read_object
from plannercheck.scenes.scene_paths import FindFile

# The fields of moveit_msgs/AttachedCollisionObject; the detach posture and the weight are accepted and ignored.
_KEYS = ("link_name", "object", "touch_links", "detach_posture", "weight")


@dataclass(frozen=True)
class AttachedMessage:
    """An attached object as in a message.

    Attributes:
        link: The link that carries it.
        touch_links: Links that it may touch.
        object: The attached object; without parts, an obstacle of the scene.
        state: The joints of the state that attaches it.
    """

    link: str
    touch_links: tuple[str, ...]
    object: ObjectMessage
    state: StatedJoints


def read_attached(state: Node, joints: StatedJoints, find_file: FindFile) -> list[AttachedMessage]:
    """Reads what a robot state with these joints attaches."""
    found: list[AttachedMessage] = []
    for k, item in enumerate(sequence(state.get("attached_collision_objects"), "'attached_collision_objects'")):
        with error_context(f"attached object {k}"):
            node = mapping(item, "it")
            check_keys(node, _KEYS)
            link = text(required(node, "link_name"), "link_name")
            touched = tuple(text(name, "touch_links") for name in sequence(node.get("touch_links"), "'touch_links'"))
            read = read_object(mapping(required(node, "object"), "'object'"), find_file)
            if any(other.object.name == read.name for other in found):
                raise PlannercheckError(f"{read.name!r} is attached twice")
            found.append(AttachedMessage(link, touched, read, joints))
    return found


def attach_with_shapes(scene: SceneContents, messages: list[AttachedMessage]) -> None:
    """Attaches objects with shapes of their own; each replaces a scene's object of the same name."""
    for message in messages:
        if message.object.parts:
            item = _posed(scene, message)
            if item.name in {other.name for other in (*scene.objects, *scene.attached)}:
                scene.remove(item.name)
            scene.put(item)


def attach_from_world(scene: SceneContents, messages: list[AttachedMessage]) -> None:
    """Attaches obstacles where they stand; objects that are attached already stay as they are."""
    attached = {item.name for item in scene.attached}
    for message in messages:
        name = message.object.name
        if message.object.parts or name in attached:
            continue
        if name not in scene.object_names:
            raise unknown_name("object to attach, without shapes of its own,", name, scene.object_names)
        item = scene.object(name)
        with error_context(f"attached object {name!r}"):
            pose_frame = item.pose_frame or PoseFrame("", message.state)
            if pose_frame.state != message.state:
                raise PlannercheckError("is placed at another robot state: give one robot_state to both")
        scene.remove(name)
        carried = item.attached(message.link, item.pose, message.touch_links)
        scene.put(dataclasses.replace(carried, pose_frame=pose_frame, frame=item.frame))


def _posed(scene: SceneContents, message: AttachedMessage) -> SceneObject:
    """The object on its link, or with a pose frame."""
    read = message.object
    item = dataclasses.replace(scene_object(read.name, read.parts, read.pose), subframes=read.subframes)
    with error_context(f"attached object {read.name!r}"):
        if not read.frame:
            raise PlannercheckError(
                f"its header names no frame: give header.frame_id, {message.link!r} if its pose is on that link"
            )
        if read.frame == message.link:
            return item.attached(message.link, read.pose, message.touch_links)
        frame = find_frame(scene, read.frame, message.state)
    held = frame.holds(item)
    on_own_link = frame.pose_frame is not None and frame.pose_frame.frame == message.link
    pose_frame = None if on_own_link else frame.pose_frame or PoseFrame("", message.state)
    carried = held.attached(message.link, held.pose, message.touch_links)
    return dataclasses.replace(carried, pose_frame=pose_frame, frame=frame.name)
