"""Hints for probable mistakes in a URDF: degrees, missing or soft limits, misspelt elements, shapes of other formats.

In: a URDF. Out: warnings that name the file, the element, the number and the likely mistake; for a file that does not
parse, the elements that no URDF has. Verdicts do not depend on them.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from difflib import get_close_matches
from pathlib import Path
from xml.etree.ElementTree import Element

from plannercheck.common.angles import LARGEST_USUAL_ANGLE
from plannercheck.common.errors import shortened
from plannercheck.common.user_warnings import warn
from plannercheck.robots.urdf_checks import ATTRIBUTES, READ_NAMES
from plannercheck.robots.urdf_file import UrdfFile

# Limits in whole numbers from 30 to 720 are degrees: 30 rad are five turns, which are written as 31.4159.
_LEAST_DEGREES, _MOST_DEGREES = 30.0, 720.0

# A link with a size beyond this and none below that, m, is in millimetres.
_LARGEST_USUAL, _THIN = 20.0, 1.0

# What the format has; Bullet's files, for example, have capsules and spherical joints beside these.
_JOINTS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")

# By element, the elements within it that decide where bodies are. Only what looks like one of them, or is read
# elsewhere, is warned of: files hold much for other programs.
_PARTS = {
    "link": ("inertial", "visual", "collision"),
    "joint": ("origin", "parent", "child", "axis", "limit", "mimic"),
    "collision": ("origin", "geometry"),
}

# From this ratio of difflib on, a name is taken for a misspelt one: "colision" and "Origin" are,
# "collision_checking" is not.
_ALIKE = 0.8

# How many elements a warning names.
_SHOWN = 3


def warn_of_odd_numbers(file: UrdfFile, is_shipped: bool = False) -> None:
    """Warns of angles and sizes in other units, and of joints that can't move since their limits are missing."""
    root = file.root
    _warn(file.path, list(_turned(root)), "look like degrees: rpy is in rad")
    _warn(file.path, list(_wide(root)), "look like degrees: limits are in rad")
    _warn(file.path, list(_large(root)), "look like millimetres: sizes are in m")
    _warn(file.path, list(_unlimited(root)), "keep the joint at 0: give lower= and upper= in rad or m")
    _warn(file.path, list(_flat(root)), 'moves in its xy, though the default normal is x: write <axis xyz="0 0 1"/>')
    _warn(file.path, list(_unknown_parts(root)), "are not read")
    _warn(
        file.path,
        [] if is_shipped else list(_soft_limits(root)),  # the YAML of a shipped robot says so
        "are not read, though MoveIt keeps to them: write them as lower= and upper= of <limit> to do so",
    )


def foreign_joints(root: Element) -> str:
    """Names joints of types that no URDF has, and the types that URDFs have; empty if there are none."""
    joints = [
        f"type {shortened(joint.get('type'))!r} of joint {shortened(joint.get('name'))!r}"
        for joint in root.iterfind("joint")
        if joint.get("type") is not None and joint.get("type") not in _JOINTS
    ]
    return f"URDFs have no {_some(joints)}: their types of joints are {', '.join(_JOINTS)}" if joints else ""


def wrong_order_of_imports() -> str:
    """What to do where CoACD was imported before Pinocchio, which reads no URDF then; empty elsewhere."""
    if [name for name in sys.modules if name in ("coacd", "pinocchio")] != ["coacd", "pinocchio"]:
        return ""
    return "CoACD was imported before Pinocchio, which reads no URDF then: import pinocchio before coacd"


def _some(names: list[str]) -> str:
    rest = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    return ", ".join(names[:_SHOWN]) + rest


def _warn(path: Path, found: list[str], meaning: str) -> None:
    if found:
        warn(f"URDF {path}: {_some(found)} {meaning}")


def _turned(root: Element) -> Iterator[str]:
    """Origins whose angles are beyond a turn."""
    for kind in ("link", "joint"):
        for owner in root.iterfind(kind):
            for origin in owner.iter("origin"):
                if max(map(abs, _numbers(origin.get("rpy", "")))) > LARGEST_USUAL_ANGLE:
                    yield f'rpy="{origin.get("rpy")}" of {kind} {owner.get("name", "")!r}'


def _wide(root: Element) -> Iterator[str]:
    """Limits of turning joints that are whole numbers of degrees."""
    for joint in root.iterfind("joint[@type='revolute']"):
        for limit in joint.iterfind("limit"):
            bounds = [*_numbers(limit.get("lower", "")), *_numbers(limit.get("upper", ""))]
            largest = max(map(abs, bounds))
            if _LEAST_DEGREES <= largest <= _MOST_DEGREES and all(bound == round(bound) for bound in bounds):
                lower, upper = limit.get("lower", "0"), limit.get("upper", "0")
                yield f"limits {lower} to {upper} of joint {joint.get('name', '')!r}"


def _large(root: Element) -> Iterator[str]:
    """Boxes, cylinders and spheres of links that are large and nowhere thin: a wide floor is thin."""
    for link in root.iterfind("link"):
        for element in link.iterfind("collision/geometry/*"):
            given = {key: text for key in ("size", "radius", "length") if (text := element.get(key, ""))}
            sizes = [number for text in given.values() for number in _numbers(text)]
            if sizes and max(sizes) > _LARGEST_USUAL and min(sizes) >= _THIN:
                words = " ".join(f'{key}="{shortened(text)}"' for key, text in given.items())
                yield f"{words} of link {shortened(link.get('name', ''))!r}"


def _unlimited(root: Element) -> Iterator[str]:
    """Joints whose limits have neither lower nor upper."""
    for joint in root.iterfind("joint"):
        limit, has_limits = joint.find("limit"), joint.get("type") in ("revolute", "prismatic")
        if has_limits and limit is not None and not {"lower", "upper"} & limit.attrib.keys():
            yield f"limits that are not given of joint {joint.get('name', '')!r}"


def _soft_limits(root: Element) -> Iterator[str]:
    """Soft limits of a <safety_controller> that are within the limits (MoveIt's jointBoundsFromURDF takes them)."""
    for joint in (*root.iterfind("joint[@type='revolute']"), *root.iterfind("joint[@type='prismatic']")):
        limit, soft = joint.find("limit"), joint.find("safety_controller")
        if limit is None or soft is None or not {"soft_lower_limit", "soft_upper_limit"} <= soft.attrib.keys():
            continue
        inner = [_numbers(soft.get(f"soft_{side}_limit", ""))[0] for side in ("lower", "upper")]
        outer = [_numbers(limit.get(side, ""))[0] for side in ("lower", "upper")]
        if inner[0] > outer[0] or inner[1] < outer[1]:
            yield f"soft limits {inner[0]:g} to {inner[1]:g} of joint {shortened(joint.get('name', ''))!r}"


def _flat(root: Element) -> Iterator[str]:
    """Planar joints whose plane is not given."""
    for joint in root.iterfind("joint[@type='planar']"):
        if joint.find("axis") is None:
            yield f"joint {joint.get('name', '')!r}, which is planar without <axis>,"


def _unknown_parts(root: Element) -> Iterator[str]:
    """Elements and attributes of links, joints and collisions that are misspelt or misplaced, as SDF's <pose> is."""
    for kind in ("link", "joint"):
        for owner in root.iterfind(kind):
            name = f"{kind} {shortened(owner.get('name', ''))!r}"
            for outer in (owner, *owner.iterfind("collision")):
                for part in outer:
                    if _is_strange(str(part.tag), _PARTS[str(outer.tag)]):
                        yield f"<{shortened(part.tag)}> of {name}"
                    for each in (part, *(part if outer.tag == "collision" and part.tag == "geometry" else ())):
                        yield from (f"{shortened(key)}= in <{each.tag}> of {name}" for key in _unread(each))


def _unread(part: Element) -> list[str]:
    """Attributes that no reader knows; those of a <collision> and a <geometry> if they belong to others."""
    known = ATTRIBUTES.get(str(part.tag), ())
    holds = part.tag in ("collision", "geometry")
    return [key for key in part.attrib if (known and key not in known) or (holds and key in READ_NAMES)]


def _is_strange(tag: str, known: tuple[str, ...]) -> bool:
    return tag not in known and (tag in READ_NAMES or bool(get_close_matches(tag.lower(), known, 1, _ALIKE)))


def _numbers(text: str) -> list[float]:
    """The numbers of an attribute; 0 if there are none or it is faulty, which the reader reports."""
    try:
        return [float(part) for part in text.split()] or [0.0]
    except ValueError:
        return [0.0]
