"""Objects of a scene: one or several posed shapes that move as one, in the world or carried by a link.

In: shapes and poses. Out: `SceneObject`, immutable, with its `bodies` posed. A moved or attached copy shares the
shapes, and thus the bodies that a checker has prepared from them. An object whose pose a file gives in a link's frame
has a `pose_frame`, until a checker knows where the link is (robots/objects_in_frames.py).
"""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

from numpy.typing import ArrayLike

from plannercheck.bodies.given_shapes import GivenShape, given_shape, in_frame, is_geometry
from plannercheck.bodies.half_spaces import check_stands_still
from plannercheck.bodies.moving import Moving, Placement
from plannercheck.bodies.shapes import Box, GeometryObject, Shape, checked_pose
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import read_only_copy
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module


@set_module("plannercheck")
@dataclass(frozen=True, slots=True)
class Part:
    """One shape of an object.

    Attributes:
        shape: The shape; in an object, points (n, 3) and objects of trimesh, coal and python-fcl become one of ours.
        pose: (4, 4) in the object's frame, m; None is the identity.
        source: The file of a mesh or a sensed shape (a cloud, an octree and so on) and the other keys of a scene's
            file, so that a saved scene can name it.
        name: The shape's name in its file, if that holds several; the body is then called "object/name".
    """

    shape: Shape
    pose: ArrayLike | None = field(default=None, repr=False)
    source: tuple[Path, Mapping[str, Any]] | None = None
    name: str = ""

    def __post_init__(self) -> None:
        if self.pose is None:
            return
        with contextlib.suppress(TypeError, ValueError):  # the object reports what is wrong with its part
            object.__setattr__(self, "pose", read_only_copy(self.pose))


Parts: TypeAlias = GivenShape | Iterable[Part]


@dataclass(frozen=True)
class SceneFrames:
    """The frames of a scene's file besides links and objects.

    Attributes:
        planning: The name of the planning frame, which is the world; "" if the file gives none.
        fixed: Poses (4, 4) of other frames in the planning frame, by name, m.
    """

    planning: str = ""
    fixed: Mapping[str, Floats] = field(default_factory=dict)


@dataclass(frozen=True)
class StatedJoints:
    """The joints of a robot state.

    Attributes:
        values: Values by joint name, rad or m.
        identities: Joints of several degrees of freedom that are at the identity.
    """

    values: Mapping[str, float] = field(default_factory=dict)
    identities: frozenset[str] = frozenset()


@dataclass(frozen=True, eq=False)
class PoseFrame:
    """The frame of an object's pose, if that is neither the world nor its own link: a frame at a robot state.

    Attributes:
        frame: A link, or "" for the world.
        state: The state at which the pose holds.
        known: Other frames of the file besides links, for errors.
    """

    frame: str
    state: StatedJoints
    known: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class SceneObject:
    """An object of a scene.

    Attributes:
        name: Unique in the scene.
        parts: Its shapes, posed in its frame.
        pose: (4, 4) of its frame in the world, or on its link, or in the pose frame, m; read-only.
        link: The link that carries it; None for obstacles.
        touch_links: Links (or other carried objects) that a carried object may touch; its own link is always one of
            them.
        pose_frame: Set if the pose is given in another frame at a robot state; objects of a checker's scene have none.
        frame: The name of the frame in which a file gave the pose, if that is a fixed frame or another object's frame;
            if the robot has a link of that name, MoveIt takes the link.
        subframes: (4, 4) by name in the object's frame, m: frames in which a file may pose other objects.
        moving: How an obstacle moves; None if it stands still.
        bodies: Its shapes, posed in the world or on the link (with a pose frame, in its frame; if it moves,
            on a link of its name): "name", or "name/0", "name/1", ...
    """

    name: str
    parts: tuple[Part, ...]
    pose: Floats
    link: str | None = None
    touch_links: tuple[str, ...] = ()
    pose_frame: PoseFrame | None = None
    frame: str = ""
    subframes: Mapping[str, Floats] = field(default_factory=dict)
    moving: Moving | None = None
    bodies: tuple[GeometryObject, ...] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "pose", checked_pose(self.pose, f"object {self.name!r}"))
        link = self.link if self.moving is None else self.name
        check_stands_still(self.name, self.link, [part.shape for part in self.parts], self.moving is not None)
        carried = None if self.link is None else self.name
        if len(self.parts) == 1 and self.parts[0].pose is None and not self.parts[0].name:  # most of all
            bodies = (_posed(self.name, link, self.pose, self.parts[0].shape, carried),)
            object.__setattr__(self, "bodies", bodies)
            return
        names = _body_names(self.name, self.parts)
        posed = (
            GeometryObject(name, link, in_frame(self.pose, part.pose, f"object {name!r}"), part.shape, carried)
            for name, part in zip(names, self.parts, strict=True)
        )
        object.__setattr__(self, "bodies", tuple(posed))

    def moved(self, pose: ArrayLike | None) -> SceneObject:
        """The same object elsewhere: in the world, or on its link."""
        self._check_still("move it")
        return dataclasses.replace(self, pose=checked_pose(pose, f"object {self.name!r}"), pose_frame=None, frame="")

    def _check_still(self, deed: str) -> None:
        if self.moving is not None:
            raise PlannercheckError(f"object {self.name!r} moves by itself: to {deed}, remove it and add another one")

    def reshaped(self, parts: tuple[Part, ...]) -> SceneObject:
        """The same object of other shapes."""
        self._check_still("update it")
        return dataclasses.replace(self, parts=parts)

    def attached(self, link: str, pose: ArrayLike | None, touch_links: Iterable[str] = ()) -> SceneObject:
        """The same object on a link, with its frame at a pose (4, 4) in the link's frame, m."""
        self._check_still("attach it")
        if not isinstance(link, str) or not link:
            raise PlannercheckError(f"object {self.name!r} is attached to a link by its name, not {link!r:.80}")
        return dataclasses.replace(
            self,
            pose=checked_pose(pose, f"object {self.name!r} on link {link!r}"),
            link=link,
            touch_links=_names(touch_links),
            pose_frame=None,
            frame="",
        )

    def released(self, pose: ArrayLike | None) -> SceneObject:
        """The same object as an obstacle, with its frame at a pose (4, 4) in the world, m."""
        freed = dataclasses.replace(self, link=None, touch_links=(), pose_frame=None)
        return freed.moved(pose)

    def __repr__(self) -> str:
        carrier = f", on link {self.link!r}" if self.link else ", which moves" if self.moving else ""
        return f"SceneObject({self.name!r}, {len(self.bodies)} bodies{carrier})"


def _body_names(name: str, parts: tuple[Part, ...]) -> list[str]:
    """A name for each part: the part's own, or its number where parts have none, or the same."""
    if len(parts) == 1 and not parts[0].name:
        return [name]
    own = [part.name or str(k) for k, part in enumerate(parts)]
    return [f"{name}/{each}" if own.count(each) == 1 else f"{name}/{each}.{k}" for k, each in enumerate(own)]


def _posed(name: str, link: str | None, pose: Floats, shape: Shape, carried: str | None) -> GeometryObject:
    """A `GeometryObject` that shares a pose which `checked_pose` has given."""
    made = object.__new__(GeometryObject)
    for field_name, value in zip(_FIELDS, (name, link, pose, shape, carried), strict=True):
        object.__setattr__(made, field_name, value)
    return made


_FIELDS = tuple(each.name for each in dataclasses.fields(GeometryObject))


def scene_object(
    name: str, parts: Parts, pose: Placement = None, subframes: Mapping[str, Floats] | None = None
) -> SceneObject:
    """Makes an obstacle.

    Args:
        name: The object's name.
        parts: One shape, or several posed ones; shapes of other libraries and points as `given_shape` takes them.
        pose: (4, 4) of the object's frame in the world, m; None is the identity; or how it moves.
        subframes: As of `SceneObject`.

    Returns:
        The object.
    """
    if type(parts) is Box:  # scenes may have very many
        shapes: tuple[Part, ...] = (Part(parts),)
    else:
        shapes = tuple(_known_part(part, f"object {name!r}") for part in _listed(parts))
    if not isinstance(name, str):
        raise PlannercheckError(f"the name of an object must be a text, not {name!r:.80}")
    if not name or not shapes:
        raise PlannercheckError(f"object {name!r} needs a name and at least one shape")
    moving = pose if isinstance(pose, Moving) else None
    placed: Any = None if moving is pose else pose
    return SceneObject(name, shapes, placed, subframes=subframes or {}, moving=moving)


def _listed(parts: Parts) -> tuple[Part | GivenShape, ...]:
    """The shapes or parts as a tuple; a list of points is one shape."""
    if type(parts) is tuple and all(type(part) is Part for part in parts):
        return parts
    if is_geometry(parts) or isinstance(parts, Part | str) or hasattr(parts, "__array__"):
        return (parts,)
    if not isinstance(parts, Iterable):
        return (parts,)
    listed = tuple(parts)
    return listed if all(isinstance(each, Part) or is_geometry(each) for each in listed) else (listed,)


def _known_part(part: Part | GivenShape, what: str) -> Part:
    """The part with one of our shapes; its pose includes the pose that another library gave the shape."""
    whole = part if isinstance(part, Part) else None
    given, pose, source, name = (
        (part, None, None, "") if whole is None else (whole.shape, whole.pose, whole.source, whole.name)
    )
    shape, own = given_shape(given, what)
    if isinstance(part, Part) and shape is given:
        return part
    return Part(shape, pose if own is None else in_frame(checked_pose(pose, what), own, what), source, name)


def unplaced(item: SceneObject) -> PlannercheckError:
    """The error for an object whose pose in the world, or on its link, is not known yet."""
    frame = "" if item.pose_frame is None else item.pose_frame.frame
    kind = "object" if item.link is None else "attached object"
    return PlannercheckError(
        f"{kind} {item.name!r} is posed in frame {frame or 'world'!r} at a state of the robot: build a checker, whose "
        "scene (checker.scene) knows where it is"
    )


def _names(names: Iterable[str]) -> tuple[str, ...]:
    listed = None if isinstance(names, str) or not isinstance(names, Iterable) else tuple(names)
    if listed is None or not all(isinstance(name, str) for name in listed):
        raise PlannercheckError(f"touch_links must be a list of names, not {names!r:.80}")
    return listed
