"""Reads a URDF through Pinocchio: the model, the tree of links, and mimic joints.

In: a URDF (`urdf_file`). Out: a Pinocchio model, the tree of links, and the mimic joints. Pinocchio's model is the
reference. Our errors repeat what Pinocchio and urdfdom say about a file that they can't read.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pinocchio as pin

from plannercheck.common.errors import PlannercheckError
from plannercheck.common.silence import urdf_silence
from plannercheck.robots.link_tree import LinkTree
from plannercheck.robots.urdf_file import SDF_ROOT, UrdfFile
from plannercheck.robots.urdf_hints import foreign_joints, wrong_order_of_imports


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another one, by its name: its value is multiplier * leader + offset, rad or m."""

    leader: str
    multiplier: float
    offset: float


def read_model(urdf: Path | UrdfFile, floating: bool = False) -> pin.Model:
    """Builds Pinocchio's model of a URDF, mimic joints as joints of their own.

    `floating`: the root link is free to move (joint `root_joint`).
    """
    file = _file(urdf)
    if file.kind == SDF_ROOT:
        raise PlannercheckError(
            f"robot {file.path} is an SDF file, which is not read: convert it into a URDF, for example by `ros2 run "
            "sdformat_tools sdf2urdf` (github.com/gezp/sdformat_tools)"
        )
    root = [pin.JointModelFreeFlyer()] if floating else []
    try:
        with urdf_silence()():
            model = pin.buildModelFromXML(file.native, *root)
    except (ValueError, RuntimeError, IndexError) as error:
        reason = file.hint or foreign_joints(file.root) or wrong_order_of_imports()
        reason = reason or _one_line(file.messages(floating)) or _one_line(str(error))
        raise PlannercheckError(f"URDF {file.path} does not parse: {reason}") from None
    return model


def _file(urdf: Path | UrdfFile) -> UrdfFile:
    return UrdfFile.read(urdf) if isinstance(urdf, Path) else urdf


def link_tree(model: pin.Model) -> LinkTree:
    """Links and the URDF joints between them, from Pinocchio's frames."""
    frames = list(model.frames)
    ids = tuple(i for i, frame in enumerate(frames) if frame.type == pin.FrameType.BODY)
    parents: dict[str, str] = {}
    joints: dict[str, str] = {}
    for frame in (frames[i] for i in ids):
        joint = frames[frame.parentFrame]
        above = frames[joint.parentFrame]
        if above.type == pin.FrameType.BODY and joint.type != pin.FrameType.BODY:
            parents[frame.name] = above.name
        joints[frame.name] = joint.name
    return LinkTree(tuple(frames[i].name for i in ids), ids, parents, joints)


def mimic_joints(urdf: Path | UrdfFile) -> dict[str, Mimic]:
    """The joints that a URDF lets follow others, by name."""
    mimics: dict[str, Mimic] = {}
    for joint in _file(urdf).root.iterfind("joint"):
        tag = joint.find("mimic")
        if tag is not None:
            multiplier, offset = float(tag.get("multiplier", 1)), float(tag.get("offset", 0))
            mimics[joint.get("name", "")] = Mimic(tag.get("joint", ""), multiplier, offset)
    return mimics


def _one_line(*messages: str) -> str:
    """Messages without breaks."""
    return "; ".join(" ".join(message.split()) for message in messages if message.strip())
