"""The joints of a URDF, read with Python's XML only: the verifier's own reader of the model.

In: a URDF. Out: `UrdfTree`: the joints by name, in exact numbers, and which link is the root. It shares no function
with Pinocchio's reader or with `plannercheck.robots.urdf`.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from plannercheck.common.errors import PlannercheckError, shortened
from plannercheck.proofs.exact_placements import Placement, decimals, origin_of, unit

# Links that an error names.
_SHOWN = 5


@dataclass(frozen=True, eq=False)
class UrdfJoint:
    """A joint as in the URDF.

    Attributes:
        name: Its name.
        kind: The URDF's type: fixed, revolute, continuous, prismatic, planar, floating.
        parent: Name of the link above.
        child: Name of the link below.
        placement: Of the child's frame in the parent's where the joint stands at 0.
        axis: The unit vector, three balls.
        mimic: Leader, multiplier, offset; None if it follows none.
        limits: Texts of its lower and upper limit; None if it has none.
    """

    name: str
    kind: str
    parent: str
    child: str
    placement: Placement
    axis: list[Any]
    mimic: tuple[str, Fraction, Fraction] | None
    limits: tuple[str, str] | None


@dataclass(frozen=True, eq=False)
class UrdfTree:
    """Links and joints.

    Attributes:
        root: Name of the link that no joint carries.
        links: All names.
        above: By link, the joint that carries it; parents first.
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
        raise PlannercheckError(f"URDF {str(urdf)!r} begins with <{shortened(root.tag)}>, not with <robot>")
    if any("xacro" in str(element.tag) for element in root.iter()):
        raise PlannercheckError(f"URDF {str(urdf)!r} holds xacro: expand it first, with `xacro FILE > robot.urdf`")
    links = tuple(link.get("name", "") for link in root.findall("link"))
    joints = [_joint(element, urdf) for element in root.findall("joint")]
    children = {joint.child for joint in joints}
    roots = [link for link in links if link not in children]
    above = _parents_first(joints, roots[:1])
    if len(roots) != 1 or len(above) != len(joints):
        named = ", ".join(map(shortened, roots[:_SHOWN]))
        raise PlannercheckError(f"URDF {str(urdf)!r} is no tree: without a joint above are {named or 'none'}")
    return UrdfTree(roots[0], links, above)


def _parents_first(joints: Sequence[UrdfJoint], reached: list[str]) -> dict[str, UrdfJoint]:
    """By link, the joint that carries it, of all links that hang on those reached."""
    below = defaultdict[str, list[UrdfJoint]](list)
    for joint in joints:
        below[joint.parent].append(joint)
    above = dict[str, UrdfJoint]()
    while reached:
        for joint in below.pop(reached.pop(), []):
            above[joint.child] = joint
            reached.append(joint.child)
    return above


def _joint(element: ElementTree.Element, urdf: str | Path) -> UrdfJoint:
    name = element.get("name", "")
    parent, child = (element.find(tag) for tag in ("parent", "child"))
    if parent is None or child is None:
        raise PlannercheckError(f"URDF {str(urdf)!r}: joint {shortened(name)!r} has no parent or no child")
    try:
        axis, placement, mimic = unit(_axis(element)), origin_of(element), _mimic(element.find("mimic"))
    except ValueError as error:
        raise PlannercheckError(f"URDF {str(urdf)!r}: joint {shortened(name)!r}: {error}") from None
    links = parent.get("link", ""), child.get("link", "")
    limit = element.find("limit")
    limits = None if limit is None else (limit.get("lower", "0"), limit.get("upper", "0"))
    return UrdfJoint(name, element.get("type", ""), *links, placement, axis, mimic, limits)


def _axis(element: ElementTree.Element) -> list[Fraction]:
    """The axis as given, of any length.

    Raises:
        ValueError: If a joint that moves has none, or is planar and moves in another plane than its xy, the only one
            that a proof knows. Without <axis>, a planar joint moves in xy for all readers.
    """
    kind, found = element.get("type"), element.find("axis")
    text = None if found is None else found.get("xyz")
    axis = decimals(text or ("0 0 1" if kind == "planar" else "1 0 0"), 3, "xyz of <axis>")
    if kind in ("fixed", "floating"):
        return [Fraction(1), Fraction(0), Fraction(0)]
    rounded = list(map(float, axis))
    if not 1e-100 <= math.hypot(*rounded) <= 1e100:
        raise ValueError(f"its axis {rounded} has no direction")
    if kind == "planar" and (axis[0] != 0 or axis[1] != 0):
        raise ValueError(f"its plane is normal to {rounded}, and proofs know planes normal to z only")
    return axis


def _mimic(element: ElementTree.Element | None) -> tuple[str, Fraction, Fraction] | None:
    if element is None:
        return None
    (multiplier,) = decimals(element.get("multiplier", "1"), 1, "multiplier of <mimic>")
    (offset,) = decimals(element.get("offset", "0"), 1, "offset of <mimic>")
    return element.get("joint", ""), multiplier, offset
