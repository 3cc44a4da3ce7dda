"""Reads an SRDF: planning groups, named states, and pairs of links that are not tested.

In: an SRDF and the tree of links. Out: for each group the joints that move it, in document order, group states, and
disabled pairs. A file is parsed once (`Srdf`). Elements whose names are not in the URDF are ignored with a warning, as
in MoveIt.
"""

from __future__ import annotations

import difflib
import xml.etree.ElementTree as ElementTree
from collections.abc import Container, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree.ElementTree import Element

from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError, shortened, unknown_name
from plannercheck.common.file_kinds import kind_of
from plannercheck.common.input_limits import INPUT_LIMITS, check_xml
from plannercheck.common.package_data import is_file, why_no_file
from plannercheck.common.user_warnings import warn
from plannercheck.robots.urdf_checks import numbers

if TYPE_CHECKING:
    from plannercheck.robots.link_tree import LinkTree

# What Pinocchio calls the joint of a root that floats; SRDFs name it in states without <virtual_joint>.
_ROOT_JOINT = "root_joint"

# The elements that say which pairs of links are tested, and their attributes.
_OF_LINKS = {
    "disable_collisions": ("link1", "link2"),
    "enable_collisions": ("link1", "link2"),
    "disable_default_collisions": ("link",),
}

# The other elements that MoveIt reads, and what a group consists of.
_OTHERS = ("group", "group_state", "virtual_joint", "end_effector", "passive_joint", "joint_property")
_OF_GROUPS = ("joint", "link", "chain", "group")

# From this ratio of difflib on, an element is taken for a misspelt one, as in URDFs.
_ALIKE = 0.8


@dataclass(frozen=True)
class DisabledPair:
    """Two links that are not tested against each other.

    Attributes:
        link_a: One link.
        link_b: The other.
        reason: Why, e.g. "adjacent".
    """

    link_a: str
    link_b: str
    reason: str


@dataclass(frozen=True)
class Srdf:
    """A parsed SRDF: its file, and its root element."""

    path: Path
    root: Element


def read_srdf(path: Path) -> Element:
    """Parses an SRDF to its root element; attributes lose the blanks around them, as in MoveIt's reader (srdfdom)."""
    if not is_file(path):
        raise PlannercheckError(f"SRDF {path} {why_no_file(path)}")
    check_xml(path, "SRDF")
    try:
        root = ElementTree.parse(path).getroot()
    except (ElementTree.ParseError, LookupError, ValueError) as error:  # the last two for encodings
        kind = kind_of(path)
        reason = str(error) if not kind or "XML" in kind or kind.endswith(("RDF", "xacro")) else kind
        raise PlannercheckError(f"SRDF {path} does not parse: {reason}") from None
    if root.tag != "robot":
        raise PlannercheckError(f"SRDF {path} is none: its root is <{root.tag}>, not <robot>")
    if kind_of(path) == "it is a xacro":
        raise PlannercheckError(f"SRDF {path} is a xacro, which has to be expanded first: xacro {path} > expanded.srdf")
    if root.find("link") is not None or root.find("joint[@type]") is not None:
        raise PlannercheckError(f"SRDF {path} is none: it has links and joints, as a URDF has, which --robot takes")
    for each in root.iter():
        each.attrib.update({key: value.strip() for key, value in each.attrib.items()})
    return root


def group_names(root: Element) -> list[str]:
    """The SRDF's planning groups."""
    return [group.get("name", "") for group in root.findall("group")]


def group_joints(root: Element | None, name: str, tree: LinkTree) -> list[str]:
    """The names of the joints of a planning group, in document order, each once.

    These are joints as listed, the parent joints of links, the joints of chains from base to tip, and those of
    subgroups. Fixed and virtual joints are among them.
    """
    if root is None:
        joints = ", ".join(tree.joints[link] for link in tree.parents)
        raise PlannercheckError(
            f"planning group {name!r}: without an SRDF, a group must be a list of joints, some of {joints}"
        )
    return _Groups(root, tree).joints(name, ())


class _Groups:
    """The groups of an SRDF, each resolved once."""

    def __init__(self, root: Element, tree: LinkTree) -> None:
        self._root, self._tree = root, tree
        self._groups: dict[str, list[Element]] = {}
        for group in root.findall("group"):
            self._groups.setdefault(group.get("name", ""), []).append(group)
        self._known: dict[str, list[str]] = {}

    def joints(self, name: str, outer: tuple[str, ...]) -> list[str]:
        """Names of a group's joints, each once, in the order of the document."""
        if name in self._known:
            return self._known[name]
        if name in outer:
            raise PlannercheckError(f"SRDF group {name!r} contains itself: {' > '.join((*outer, name))}")
        if len(outer) >= INPUT_LIMITS.depth:
            raise PlannercheckError(
                f"SRDF group {name!r} is nested deeper than {INPUT_LIMITS.depth} levels (INPUT_LIMITS.depth)"
            )
        if name not in self._groups:
            raise unknown_name("planning group", name, group_names(self._root))
        named = self._groups[name]
        if len({ElementTree.tostring(group).strip() for group in named}) > 1:
            raise PlannercheckError(f"SRDF has {len(named)} groups {name!r}, of which MoveIt takes one: keep one")
        found: dict[str, None] = {}
        for part in named[0]:
            inside = part.tag == "group"
            part_name = part.get("name", "")
            joints = self.joints(part_name, (*outer, name)) if inside else _joints_of_part(part, self._tree)
            found |= dict.fromkeys(joints)
        self._known[name] = list(found)
        return self._known[name]


def _joints_of_part(part: Element, tree: LinkTree) -> list[str]:
    """The joints that a joint, link or chain of a group names."""
    name = part.get("name", "")
    if part.tag == "joint":
        return [name]
    if part.tag == "link":
        return [tree.joints[_known_link(name, tree)]]
    if part.tag == "chain":
        return _chain(part.get("base_link", ""), part.get("tip_link", ""), tree)
    return []


def _chain(base: str, tip: str, tree: LinkTree) -> list[str]:
    """Joints from base to tip, through their common ancestor if the base is no ancestor of the tip."""
    up_from_tip, up_from_base = (_ancestry(_known_link(link, tree), tree) for link in (tip, base))
    shared = next((link for link in up_from_base if link in up_from_tip), None)
    if shared is None:
        raise PlannercheckError(f"SRDF chain from {base!r} to {tip!r}: no path of joints between them")
    up_path = up_from_base[: up_from_base.index(shared)]
    down_path = up_from_tip[: up_from_tip.index(shared)]
    return [tree.joints[link] for link in up_path + down_path[::-1]]


def _ancestry(link: str, tree: LinkTree) -> list[str]:
    """The link, its parent, and so on to the root."""
    line = [link]
    while line[-1] in tree.parents:
        line.append(tree.parents[line[-1]])
    return line


def _known_link(name: str, tree: LinkTree) -> str:
    if name not in tree.names:
        raise unknown_name("link", name, tree.names)
    return name


def disabled_collisions(root: Element) -> list[DisabledPair]:
    """The pairs of links that <disable_collisions> names, with the reasons it gives."""
    return _named_pairs(root, "disable_collisions")


def default_links(root: Element) -> tuple[str, ...]:
    """The links of <disable_default_collisions>: tested against nothing but what <enable_collisions> names."""
    names = (each.get("link", "") for each in root.findall("disable_default_collisions"))
    return tuple(dict.fromkeys(name for name in names if name))


def enabled_collisions(root: Element) -> list[DisabledPair]:
    """The pairs of links that <enable_collisions> takes out of the defaults."""
    return _named_pairs(root, "enable_collisions")


def untested_pairs(root: Element, links: Sequence[str]) -> list[DisabledPair]:
    """All pairs of links that an SRDF leaves out, each once, as MoveIt 2 has it (its AllowedCollisionMatrix).

    Links of <disable_default_collisions> are left out against every other link, then <enable_collisions> takes pairs
    back, and <disable_collisions> has the last word, whatever the order in the file.
    """
    found = {frozenset((pair.link_a, pair.link_b)): pair for pair in reversed(disabled_collisions(root))}
    enabled = {frozenset((pair.link_a, pair.link_b)) for pair in enabled_collisions(root)}
    for link in default_links(root):
        for other in links:
            both = frozenset((link, other))
            if link in links and other != link and both not in enabled and both not in found:
                found[both] = DisabledPair(link, other, "disable_default_collisions")
    return list(found.values())


def _named_pairs(root: Element, tag: str) -> list[DisabledPair]:
    return [
        DisabledPair(each.get("link1", ""), each.get("link2", ""), each.get("reason", ""))
        for each in root.findall(tag)
        if each.get("link1") and each.get("link2")
    ]


def warn_about_ignored_elements(srdf: Srdf, tree: LinkTree) -> None:
    """Warns of links that the URDF does not have, and of elements that name none: MoveIt passes over both."""
    known = set(tree.names)
    nameless = 0
    for tag, keys in _OF_LINKS.items():
        elements = srdf.root.findall(tag)
        named = [[each.get(key, "") for key in keys] for each in elements]
        unknown = sorted({name for names in named for name in names if name and name not in known})
        nameless += sum("" in names for names in named)
        if unknown:
            close = [match for name in unknown[:1] for match in difflib.get_close_matches(name, tree.names, 1)]
            hint = f" (did you mean {close[0]!r} by {unknown[0]!r}?)" if close else ""
            warn(
                f"SRDF {srdf.path} has <{tag}> of links that the URDF does not know: "
                f"{', '.join(map(shortened, unknown))}{hint}; these entries change nothing"
            )
    if nameless:
        needed = "; ".join(f"{tag} needs {'= and '.join(keys)}=" for tag, keys in _OF_LINKS.items())
        warn(f"SRDF {srdf.path}: {nameless} elements that name no links change nothing: {needed}")
    _warn_of_strange_elements(srdf)
    for group in srdf.root.findall("group"):
        strange = {str(part.tag): None for part in group if part.tag not in _OF_GROUPS}
        if strange:
            warn(
                f"SRDF {srdf.path}: group {shortened(group.get('name'))!r} holds "
                f"{', '.join(f'<{shortened(tag)}>' for tag in strange)}, which change nothing: a group has "
                f"{', '.join(f'<{tag}>' for tag in _OF_GROUPS)}"
            )
    defaults = [link for link in default_links(srdf.root) if link in known]
    if defaults:
        warn(
            f"SRDF {srdf.path}: links of <disable_default_collisions> are tested neither against obstacles nor against "
            f"links that <enable_collisions> does not name, as in MoveIt: {', '.join(defaults)}"
        )


def _warn_of_strange_elements(srdf: Srdf) -> None:
    """Warns of misspelt elements, and of pairs of links within others: no reader takes them."""
    known = (*_OF_LINKS, *_OTHERS)
    inner = (each.tag for part in srdf.root if part.tag != "group" for each in part.iter() if each is not part)
    strange = {tag: None for tag in inner if tag in _OF_LINKS}
    for tag in (str(part.tag) for part in srdf.root if part.tag not in known):
        if difflib.get_close_matches(tag.lower(), known, 1, _ALIKE):
            strange[tag] = None
    if strange:
        listed = ", ".join(f"<{shortened(tag)}>" for tag in strange)
        warn(
            f"SRDF {srdf.path} has {listed}, misspelt or within other elements, which change nothing: directly within "
            f"<robot> are read {', '.join(f'<{tag}>' for tag in known)}"
        )


def virtual_joints(root: Element) -> set[str]:
    """Names of the SRDF's virtual joints, which no URDF has."""
    return {joint.get("name", "") for joint in root.findall("virtual_joint")}


def group_state(
    srdf: Srdf | None, name: str, group: str | None, joints: Container[str], tree: LinkTree
) -> dict[str, list[float]]:
    """Joint values, rad or m, of a named state by joint name, without those of joints that the model lacks.

    A state belongs to a group, as in MoveIt: that of the `group` is taken if there is one, else all of the name at
    once. Joints that the URDF does not have are passed over with a warning, as in MoveIt.

    Raises:
        PlannercheckError: If there is none of the name, values are no numbers, or two values of one joint differ.
    """
    if srdf is None:
        raise PlannercheckError(f"group state {name!r}: there is no SRDF to take it from")
    states = srdf.root.findall("group_state")
    named = [state for state in states if state.get("name") == name]
    if not named:
        raise unknown_name("group state", name, (state.get("name", "") for state in states))
    own = [state for state in named if group is not None and state.get("group") == group]
    values: dict[str, list[float]] = {}
    unknown: dict[str, None] = {}
    known = {*tree.joints.values(), *virtual_joints(srdf.root), _ROOT_JOINT}
    with error_context(f"SRDF {srdf.path}"):
        for joint in (joint for state in own or named for joint in state.iter("joint")):
            key = joint.get("name", "")
            if key in joints:
                _add_value(values, key, joint.get("value"), name)
            elif key not in known:
                unknown[key] = None
    if unknown:
        warn(
            f"SRDF {srdf.path}: group state {name!r} gives joints that the URDF does not know: "
            f"{', '.join(map(shortened, unknown))}; these values change nothing"
        )
    return values


def _add_value(values: dict[str, list[float]], joint: str, text: str | None, state: str) -> None:
    what = f"value of joint {shortened(joint)!r} in group state {shortened(state)!r}"
    value = numbers(text, max(1, len((text or "").split())), what)
    if values.setdefault(joint, value) != value:
        raise PlannercheckError(
            f"{what} is both {values[joint]} and {value}: keep one, or load the group whose state is meant"
        )
