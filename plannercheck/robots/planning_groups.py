"""The joints of a planning group, in order.

In: an explicit list of joints, or the name of an SRDF group. Out: names of joints without fixed and virtual joints and
without mimic joints, which follow others.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from xml.etree.ElementTree import Element

import pinocchio as pin

from plannercheck.common.errors import PlannercheckError, shortened, unknown_name
from plannercheck.common.user_warnings import warn
from plannercheck.robots.configurations import followed, joint_by_name, joint_width
from plannercheck.robots.link_tree import LinkTree
from plannercheck.robots.srdf import group_joints, virtual_joints
from plannercheck.robots.urdf import Mimic, mimic_joints
from plannercheck.robots.urdf_file import UrdfFile


def usable_mimics(model: pin.Model, urdf: Path | UrdfFile) -> dict[str, Mimic]:
    """The URDF's mimic joints whose leader moves; both must be joints of one value."""
    names = set(model.names)
    mimics = {name: mimic for name, mimic in mimic_joints(urdf).items() if name in names and mimic.leader in names}
    for name in mimics:
        followed(name, mimics, ())  # raises if they form a circle
        if joint_width(joint_by_name(model, name)) != 1 or joint_width(joint_by_name(model, mimics[name].leader)) != 1:
            raise PlannercheckError(f"joint {name!r} mimics {mimics[name].leader!r}: both must be joints of one value")
    return mimics


def joint_list(joints: object) -> tuple[str, ...]:
    """The names of joints as listed, or an error for what is no list of names."""
    if isinstance(joints, str) or not isinstance(joints, Iterable):
        raise PlannercheckError(f"a group is a list of names of joints, not {joints!r:.80}")
    listed = tuple(joints)
    if not all(isinstance(name, str) for name in listed):
        raise PlannercheckError(f"a group is a list of names of joints, not {list(listed)!r:.80}")
    return listed


def explicit_group(model: pin.Model, joints: Sequence[str], mimics: Mapping[str, Mimic]) -> tuple[str, ...]:
    """The names of joints as listed, checked; joints that follow others may not be listed."""
    for name in joints:
        joint_by_name(model, name)
        if name in mimics:
            raise PlannercheckError(
                f"group joint {name!r} mimics {mimics[name].leader!r}: list that one, the other follows"
            )
    if len(set(joints)) != len(joints) or not joints:
        raise PlannercheckError(f"a group must list each of its joints once, not {list(joints)}")
    return tuple(joints)


def srdf_group(
    model: pin.Model, srdf: Element | None, name: str, tree: LinkTree, mimics: Mapping[str, Mimic]
) -> tuple[str, ...]:
    """The moving joints of an SRDF group, in document order; the tree is the URDF's, `mimics` follow others."""
    moving = list(model.names)[1:]
    joints = group_joints(srdf, name, tree)
    resting = set(tree.joints.values())
    virtual = virtual_joints(srdf) - resting if srdf is not None else set()
    for joint in (joint for joint in joints if joint not in moving):
        if joint in virtual:
            warn(
                f"group {name!r} has the virtual joint {shortened(joint)}, which does not move: the root link stays "
                "where it is, unless the robot is loaded with floating=True and the group names root_joint"
            )
        elif joint not in resting:
            raise unknown_name(f"joint of group {name!r}", joint, moving)
    own = tuple(joint for joint in joints if joint in moving and joint not in mimics)
    if not own:
        raise PlannercheckError(f"planning group {name!r} has no joint that moves")
    return own
