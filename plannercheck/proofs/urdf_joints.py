"""The joints of a URDF, read with Python's XML only: the verifier's own reader of the model.

In: a URDF. Out: `UrdfTree`: the joints by name, and which link is the root. It shares no function with Pinocchio's
reader or with `plannercheck.robots.urdf`.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError


@dataclass(frozen=True, eq=False)
class UrdfJoint:
    """A joint as in the URDF.

    Attributes:
        name: Its name.
        kind: The URDF's type: fixed, revolute, continuous, prismatic, planar, floating.
        parent: Name of the link above.
        child: Name of the link below.
        placement: (4, 4) of the child's frame in the parent's where the joint stands at 0, m.
        axis: (3,) unit vector.
        mimic: Leader, multiplier, offset; None if it follows none.
    """

    name: str
    kind: str
    parent: str
    child: str
    placement: Floats
    axis: Floats
    mimic: tuple[str, float, float] | None


@dataclass(frozen=True, eq=False)
class UrdfTree:
    """Links and joints.

    Attributes:
        root: Name of the link that no joint carries.
        links: All names.
        above: By link, the joint that carries it.
    """

    root: str
    links: tuple[str, ...]
    above: dict[str, UrdfJoint]


def read_tree(urdf: str | Path, content: str | None = None) -> UrdfTree:
    """Reads a URDF's joints.

    Args:
        urdf: Path of the file.
        content: What to read in place of the file, whose path is for errors then: what a xacro expands to.

    Returns:
        The tree.

    Raises:
        PlannercheckError: If the file is no URDF, or has xacro's parts in it.
    """
    try:
        root = ElementTree.parse(urdf).getroot() if content is None else ElementTree.fromstring(content)
    except (OSError, ElementTree.ParseError, LookupError, ValueError) as error:  # the last two for encodings
        raise PlannercheckError(f"URDF {str(urdf)!r} can't be read: {error}") from None
    if root.tag != "robot":
        raise PlannercheckError(f"URDF {str(urdf)!r} begins with <{root.tag}>, not with <robot>")
    if any("xacro" in str(element.tag) for element in root.iter()):
        raise PlannercheckError(f"URDF {str(urdf)!r} holds xacro: expand it first, with `xacro FILE > robot.urdf`")
    links = tuple(link.get("name", "") for link in root.findall("link"))
    joints = [_joint(element, urdf) for element in root.findall("joint")]
    above = {joint.child: joint for joint in joints}
    roots = [link for link in links if link not in above]
    if len(roots) != 1 or len(above) != len(joints):
        raise PlannercheckError(
            f"URDF {str(urdf)!r} is no tree: without a joint above are {', '.join(roots) or 'none'}"
        )
    return UrdfTree(roots[0], links, above)


def _joint(element: ElementTree.Element, urdf: str | Path) -> UrdfJoint:
    name = element.get("name", "")
    parent, child = (element.find(tag) for tag in ("parent", "child"))
    if parent is None or child is None:
        raise PlannercheckError(f"URDF {str(urdf)!r}: joint {name!r} has no parent or no child")
    try:
        axis = _axis(element)
        placement = origin_of(element)
        mimic = _mimic(element.find("mimic"))
    except ValueError as error:
        raise PlannercheckError(f"URDF {str(urdf)!r}: joint {name!r}: {error}") from None
    unit = axis / math.hypot(*axis)
    links = parent.get("link", ""), child.get("link", "")
    return UrdfJoint(name, element.get("type", ""), *links, placement, unit, mimic)


def origin_of(element: ElementTree.Element) -> Floats:
    """(4, 4) the placement that an element's <origin> gives, m.

    Raises:
        ValueError: If it has other numbers than it should.
    """
    return _placement(_numbers(element, "origin", "xyz"), _rotation(element))


def _axis(element: ElementTree.Element) -> Floats:
    """The axis as given, of any length.

    Raises:
        ValueError: If a joint that moves has none, or is planar and moves in another plane than its xy, the only one
            that a proof knows. Without <axis>, a planar joint moves in xy for all readers.
    """
    kind = element.get("type")
    axis = _numbers(element, "axis", "xyz", (0.0, 0.0, 1.0) if kind == "planar" else (1.0, 0.0, 0.0))
    if kind in ("fixed", "floating"):
        return np.array([1.0, 0.0, 0.0])
    if not 1e-100 <= math.hypot(*axis) <= 1e100:
        raise ValueError(f"its axis {axis.tolist()} has no direction")
    if kind == "planar" and (axis[0] != 0 or axis[1] != 0):
        raise ValueError(f"its plane is normal to {axis.tolist()}, and proofs know planes normal to z only")
    return axis


def _rotation(element: ElementTree.Element) -> Floats:
    """(3, 3) by roll, pitch and yaw or by a quaternion, which is made a unit one."""
    origin = element.find("origin")
    text = None if origin is None else origin.get("quat_xyzw")
    if text is None:
        return _turned(_numbers(element, "origin", "rpy"))
    values = [float(word) for word in text.split()]
    length = math.hypot(*values)
    if len(values) != 4 or not 0.5 <= length <= 2:
        raise ValueError(f"<origin quat_xyzw={text!r:.80}> must be four numbers of length 1")
    x, y, z, w = (value / length for value in values)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def _numbers(
    element: ElementTree.Element, tag: str, attribute: str, otherwise: tuple[float, ...] = (0, 0, 0)
) -> Floats:
    found = element.find(tag)
    text = None if found is None else found.get(attribute)
    values = list(otherwise) if text is None else [float(word) for word in text.split()]
    if len(values) != 3 or not all(map(math.isfinite, values)):
        raise ValueError(f"<{tag} {attribute}={text!r:.80}> must be three numbers")
    return np.array(values)


def _mimic(element: ElementTree.Element | None) -> tuple[str, float, float] | None:
    if element is None:
        return None
    return element.get("joint", ""), float(element.get("multiplier", "1")), float(element.get("offset", "0"))


def _placement(xyz: Floats, rotation: Floats) -> Floats:
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = rotation, xyz
    return out


def _turned(rpy: Floats) -> Floats:
    """(3, 3) turned about the fixed axes x, y, z by roll, pitch, yaw, in this order."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
