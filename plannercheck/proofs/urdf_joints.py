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
        axis = _numbers(element, "axis", "xyz", (1.0, 0.0, 0.0))
        placement = _placement(_numbers(element, "origin", "xyz"), _numbers(element, "origin", "rpy"))
        mimic = _mimic(element.find("mimic"))
    except ValueError as error:
        raise PlannercheckError(f"URDF {str(urdf)!r}: joint {name!r}: {error}") from None
    length = float(np.linalg.norm(axis))
    unit = axis / length if length > 0 else axis
    links = parent.get("link", ""), child.get("link", "")
    return UrdfJoint(name, element.get("type", ""), *links, placement, unit, mimic)


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


def _placement(xyz: Floats, rpy: Floats) -> Floats:
    """Turned about the fixed axes x, y, z by roll, pitch, yaw, in this order; then shifted."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    out = np.eye(4)
    out[:3, :3] = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    out[:3, 3] = xyz
    return out
