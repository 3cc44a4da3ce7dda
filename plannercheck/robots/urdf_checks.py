"""Checks the links and joints of a URDF before any reader takes it, so that nothing is dropped or read loosely.

In: the root of a URDF's XML. Out: nothing, or an error that names file and element. urdfdom reads the first of two
elements, skips elements in the wrong place, and takes an <axis> without numbers for 0 0 0; Pinocchio turns about an
axis of length 0, and follows links around a circle. `geometry_elements.py` checks shapes.
"""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ElementTree
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from xml.etree.ElementTree import Element

from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError, shortened, unknown_name

# A number as urdfdom reads it: Python's own `float` also takes "nan", "inf", "1_0" and digits of other scripts.
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?", re.ASCII)

# No position or length is longer, m: squares and products of three stay far from the largest double.
LARGEST_NUMBER = 1e60

# A mimic's multiplier and offset; values of joints may be up to 1e15.
_LARGEST_FACTOR = 1e12

# Between these the square of an axis's length neither over- nor underflows.
_SHORTEST_AXIS, _LONGEST_AXIS = 1e-100, 1e100

# An <origin>'s quaternion may be this far from length 1; readers make it a unit quaternion.
_UNIT = 1e-3

_TURNING_OR_SLIDING = ("revolute", "continuous", "prismatic")
_LIMITED = ("revolute", "prismatic")

# Elements that decide where bodies are; its parent has one, or the same one
# again.
_ONCE = {
    "joint": ("origin", "parent", "child", "axis", "limit", "mimic"),
    "collision": ("origin", "geometry"),
}

# What is written as attributes of elements that hold nothing; and what each of them takes.
ATTRIBUTES = {
    "origin": ("xyz", "rpy", "quat_xyzw"),
    "axis": ("xyz",),
    "limit": ("lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"),
    "mimic": ("joint", "multiplier", "offset"),
    "parent": ("link",),
    "child": ("link",),
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "sphere": ("radius",),
    "capsule": ("radius", "length"),
    "mesh": ("filename", "scale"),
}

# Names that are read somewhere in a URDF or an SDF, so that a body is elsewhere if they are passed over.
READ_NAMES = {"geometry", "pose", "uri", *ATTRIBUTES, *(key for keys in ATTRIBUTES.values() for key in keys)}

# Within links and joints, these hold elements of other programs.
_FOREIGN = ("gazebo", "sensor", "plugin")


def check_robot(root: Element, path: Path) -> None:
    """Raises for links and joints that can't be read as they are written.

    Raises:
        PlannercheckError: It names the file and the first faulty element.
    """
    with error_context(f"URDF {path}"):
        _check_places(root)
        links, joints = (_by_name(root, kind) for kind in ("link", "joint"))
        for name, link in links.items():
            _check_link(name, link, _version(root))
        for name, joint in joints.items():
            _check_joint(name, joint, _version(root))
        if joints:
            _check_tree(links, joints)
        _check_mimics(joints)


def number(text: str | None, what: str) -> float:
    """The finite number of an attribute; `what` names it in errors."""
    (value,) = numbers(text, 1, what)
    return value


def numbers(text: str | None, count: int, what: str) -> list[float]:
    """So many finite numbers of an attribute; `what` names it in errors, e.g. "xyz of <origin>".

    Raises:
        PlannercheckError: If it is missing, or has others, or not so many.
    """
    words = [] if text is None else text.split()
    values = [float(word) for word in words if _NUMBER.fullmatch(word)]
    if text is None or len(words) != count or len(values) != count or not all(map(math.isfinite, values)):
        wanted = "a finite number" if count == 1 else f"{count} finite numbers with blanks between them"
        raise PlannercheckError(f"{what} must be {wanted}, not {'missing' if text is None else repr(shortened(text))}")
    return values


def _version(root: Element) -> tuple[int, ...]:
    """The version of the format; (1, 0) if it is not given, or given in a way that urdfdom refuses."""
    words = root.get("version", "1.0").split(".")
    return tuple(int(word) for word in words) if all(re.fullmatch("[0-9]{1,3}", word) for word in words) else (1, 0)


def _check_places(root: Element) -> None:
    """Raises for links, joints and collisions where every reader passes over them."""
    for element in root:
        if element.tag == "collision":
            raise PlannercheckError("<collision> stands in no <link>, where none is read")
        if element.tag in ("link", "joint"):
            name = f"{element.tag} {shortened(element.get('name'))!r}"
            for part in element:
                _check_nothing_within(part, name, placed=element.tag == "link" and part.tag == "collision")


def _check_nothing_within(part: Element, name: str, placed: bool = False) -> None:
    if not placed and part.tag in ("link", "joint", "collision"):
        raise PlannercheckError(f"<{part.tag}> stands within {name}, where none is read")
    if part.tag not in _FOREIGN:
        for inner in part:
            _check_nothing_within(inner, name)


def _by_name(root: Element, kind: str) -> dict[str, Element]:
    """The links or joints by name; each needs one, and its own."""
    found: dict[str, Element] = {}
    for element in root.iterfind(kind):
        name = element.get("name", "")
        if not name:
            raise PlannercheckError(f"a {kind} has no name")
        if name in found:
            raise PlannercheckError(f"two {kind}s have the name {shortened(name)!r}")
        found[name] = element
    return found


def _check_link(name: str, link: Element, version: tuple[int, ...]) -> None:
    for collision in link.iterfind("collision"):
        owner = f"a <collision> of link {shortened(name)!r}"
        _check_once(collision, owner)
        if collision.find("geometry") is None:
            raise PlannercheckError(f"{owner} has no <geometry>")
        _check_empty(collision, owner)
        for geometry in collision.iterfind("geometry"):
            _check_empty(geometry, owner)
        _check_origin(collision, owner, version)


def _check_once(element: Element, owner: str) -> None:
    counts = Counter(part.tag for part in element)
    for tag in (tag for tag in _ONCE[str(element.tag)] if counts[tag] > 1):
        if len({ElementTree.tostring(part).strip() for part in element.iterfind(tag)}) > 1:
            raise PlannercheckError(f"{owner} has {counts[tag]} <{tag}> elements, of which one would be read: keep one")


def _check_empty(holder: Element, owner: str) -> None:
    """Raises for elements or text within an element that has attributes alone."""
    for part in (part for part in holder if part.tag in ATTRIBUTES):
        inner = [f"<{each.tag}>" for each in part if each.tag in READ_NAMES]
        texts = (each.strip() for each in (part.text, *(each.tail for each in part)) if each)
        found = [*inner, *(f"the text {shortened(text)!r}" for text in texts if text)]
        if found:
            keys = ", ".join(f"{key}=" for key in ATTRIBUTES[part.tag])
            raise PlannercheckError(
                f"the <{part.tag}> of {owner} holds {found[0]}, which is not read there: "
                f"<{part.tag}> has the attributes {keys}, other elements stand beside it"
            )


def _check_origin(element: Element, owner: str, version: tuple[int, ...]) -> None:
    origin = element.find("origin")
    if origin is None:
        return
    for key, count in (("xyz", 3), ("rpy", 3), ("quat_xyzw", 4)):
        if origin.get(key) is not None:
            values = numbers(origin.get(key), count, f"{key} in the <origin> of {owner}")
            if max(map(abs, values)) > LARGEST_NUMBER:
                raise PlannercheckError(f"{key} in the <origin> of {owner} is beyond {LARGEST_NUMBER:g}: {values}")
    if origin.get("quat_xyzw") is not None:
        _check_quaternion(origin, owner, version)


def _check_quaternion(origin: Element, owner: str, version: tuple[int, ...]) -> None:
    if version < (1, 1):
        raise PlannercheckError(f'{owner} is turned by quat_xyzw, which is read from <robot version="1.1"> on')
    if origin.get("rpy") is not None:
        raise PlannercheckError(f"{owner} is turned by both rpy and quat_xyzw: keep one")
    length = math.hypot(*numbers(origin.get("quat_xyzw"), 4, "quat_xyzw"))
    if not abs(length - 1) <= _UNIT:
        raise PlannercheckError(f"quat_xyzw in the <origin> of {owner} must have length 1, not {length:g}")


def _check_joint(name: str, joint: Element, version: tuple[int, ...]) -> None:
    owner = f"joint {shortened(name)!r}"
    _check_once(joint, owner)
    _check_empty(joint, owner)
    kind = joint.get("type")
    if kind is None:
        raise PlannercheckError(f"{owner} has no type=")
    _check_origin(joint, owner, version)
    if kind in _TURNING_OR_SLIDING:
        _check_axis(joint, owner)
    elif kind == "planar":
        _check_plane(joint, owner)
    if kind in _LIMITED:
        _check_limits(joint, owner, kind)


def _check_axis(joint: Element, owner: str) -> None:
    axis = _axis(joint, owner)
    if axis is not None and not _SHORTEST_AXIS <= math.hypot(*axis) <= _LONGEST_AXIS:
        raise PlannercheckError(f'the <axis> of {owner} must have a length, as xyz="0 0 1" has, not xyz={_xyz(joint)}')


def _check_plane(joint: Element, owner: str) -> None:
    """Raises for a plane other than the joint's xy.

    The <axis> of a planar joint is the plane's normal (URDF specification, "axis"). Pinocchio (JointModelPlanar) and
    MoveIt (PlanarJointModel::computeTransform) move it in xy whatever it says, and so does every file without <axis>,
    though the specification's default would be x.
    """
    axis = _axis(joint, owner)
    if axis is not None and not (axis[0] == axis[1] == 0 and _SHORTEST_AXIS <= abs(axis[2]) <= _LONGEST_AXIS):
        raise PlannercheckError(
            f"the planar {owner} has the normal xyz={_xyz(joint)}; it can only move in its own xy: turn its <origin> "
            'so that z is the normal, and write <axis xyz="0 0 1"/>'
        )


def _axis(joint: Element, owner: str) -> list[float] | None:
    """The numbers of the <axis>; None if there is none."""
    axis = joint.find("axis")
    return None if axis is None else numbers(axis.get("xyz"), 3, f"xyz in the <axis> of {owner}")


def _xyz(joint: Element) -> str:
    axis = joint.find("axis")
    return f'"{"" if axis is None else shortened(axis.get("xyz"))}"'


def _check_limits(joint: Element, owner: str, kind: str) -> None:
    limit = joint.find("limit")
    if limit is None:
        raise PlannercheckError(f'{owner} is {kind} and has no <limit lower="" upper="" effort="" velocity=""/>')
    for key in ("effort", "velocity"):
        if limit.get(key) is None:
            raise PlannercheckError(f"the <limit> of {owner} has no {key}=")
    for key in ("lower", "upper", "effort", "velocity"):
        if limit.get(key) is not None:
            number(limit.get(key), f"{key} in the <limit> of {owner}")
    lower, upper = (float(limit.get(key, "0")) for key in ("lower", "upper"))
    if not lower <= upper:
        raise PlannercheckError(f"{owner} has a lower limit {lower:g} above its upper one {upper:g}")


def _check_tree(links: dict[str, Element], joints: dict[str, Element]) -> None:
    """Raises unless every link but one hangs on one joint, and all hang on that one."""
    above: dict[str, tuple[str, str]] = {}
    for name, joint in joints.items():
        parent, child = (_end(name, joint, tag, links) for tag in ("parent", "child"))
        if child in above:
            other = above[child][1]
            raise PlannercheckError(
                f"link {shortened(child)!r} is the child of joints {shortened(other)!r} and {shortened(name)!r}: "
                "a link hangs on one"
            )
        above[child] = parent, name
    roots = [link for link in links if link not in above]
    if len(roots) > 1:
        named = ", ".join(shortened(link) for link in roots[:3])
        raise PlannercheckError(f"{len(roots)} links are no joint's child, where one root must be: {named}")
    hanging, queue = set(roots), list(roots)
    children: dict[str, list[str]] = {}
    for child, (parent, _) in above.items():
        children.setdefault(parent, []).append(child)
    while queue:
        for child in children.get(queue.pop(), ()):
            hanging.add(child)
            queue.append(child)
    loose = next((link for link in links if link not in hanging), None)
    if loose is not None:
        raise PlannercheckError(
            f"link {shortened(loose)!r} hangs on itself, over joint {shortened(above[loose][1])!r} and others"
        )


def _end(name: str, joint: Element, tag: str, links: dict[str, Element]) -> str:
    end = joint.find(tag)
    link = None if end is None else end.get("link")
    if link is None:
        raise PlannercheckError(f'joint {shortened(name)!r} has no <{tag} link="">')
    if link not in links:
        raise unknown_name(f"{tag} link of joint {shortened(name)!r}", link, links)
    return link


def _check_mimics(joints: dict[str, Element]) -> None:
    """Raises for joints that follow what can't be followed; a fixed joint follows nothing, whatever it says."""
    followers = dict(_mimics(joints))
    for name, tag in followers.items():
        owner = f"joint {shortened(name)!r}"
        leader = tag.get("joint")
        if not leader:
            raise PlannercheckError(f'the <mimic> of {owner} has no joint="", the name of the joint that it follows')
        if leader not in joints:
            moving = [other for other, each in joints.items() if each.get("type") != "fixed" and other != name]
            raise unknown_name(f"joint that {owner} mimics", leader, moving)
        for each in (name, leader):
            kind = joints[each].get("type")
            if kind not in _TURNING_OR_SLIDING:
                raise PlannercheckError(
                    f"{owner} mimics joint {shortened(leader)!r}, and {shortened(each)!r} is {shortened(kind)}: both "
                    "must be revolute, continuous or prismatic"
                )
        for key in ("multiplier", "offset"):
            if tag.get(key) is not None:
                value = number(tag.get(key), f"{key} in the <mimic> of {owner}")
                if abs(value) > _LARGEST_FACTOR:
                    raise PlannercheckError(f"{key} in the <mimic> of {owner} is beyond {_LARGEST_FACTOR:g}: {value}")
        _check_ends(name, followers)


def _mimics(joints: dict[str, Element]) -> Iterator[tuple[str, Element]]:
    for name, joint in joints.items():
        tag = joint.find("mimic")
        if tag is not None and joint.get("type") != "fixed":
            yield name, tag


def _check_ends(name: str, followers: dict[str, Element]) -> None:
    """Raises if a chain of mimics comes back to itself."""
    chain = [name]
    while chain[-1] in followers:
        leader = followers[chain[-1]].get("joint", "")
        if leader in chain:
            raise PlannercheckError(
                f"joint {shortened(name)!r} mimics itself: {' > '.join(map(shortened, [*chain, leader]))}"
            )
        chain.append(leader)
