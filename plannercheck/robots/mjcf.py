"""Builds a robot from an MJCF file that MuJoCo has compiled.

In: a path. Out: `MjcfRobot`: Pinocchio's model (`mjcf_model.py`), one body for each geom that can collide, the pairs
that MuJoCo tests, mimic joints, and the initial values of joints. Bodies are links, the world is the link "world".
Equalities of joints that are linear become mimic joints, as `y - y0 = a0 + a1 (x - x0)` in MuJoCo's XML reference.

Geoms of the world and of bodies that no joint moves are obstacles (`Scene.from_mjcf`), and are left out with a warning.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin

from plannercheck.bodies.mesh_files import MeshFile, MeshObject
from plannercheck.bodies.mjcf_files import BALL, EQUAL_JOINTS, MESH, MjcfFile, read_mjcf
from plannercheck.bodies.mjcf_pairs import obstacle_geoms, robot_geoms, tested_pairs
from plannercheck.bodies.mjcf_shapes import check_flexes, mesh_of_geom, shape_of_geom
from plannercheck.bodies.shapes import GeometryObject
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.errors import PlannercheckError, shortened
from plannercheck.common.user_warnings import warn
from plannercheck.robots.configurations import followed
from plannercheck.robots.link_bodies import LinkBodies
from plannercheck.robots.mjcf_model import initial_values, pinocchio_model
from plannercheck.robots.srdf import DisabledPair, Srdf, untested_pairs
from plannercheck.robots.urdf import Mimic

# How many names a warning lists.
_SHOWN = 5


@dataclass(frozen=True, eq=False)
class MjcfRobot:
    """What an MJCF file says of a robot.

    Attributes:
        model: Pinocchio's model.
        links: A body for each geom that can collide and is on a link, in MuJoCo's order.
        pairs: (k, 2) indices of bodies: the pairs that MuJoCo tests.
        mimics: The joints that follow others, by name.
        initial: The value of each joint that follows no other one in MuJoCo's initial configuration, within its limits.
    """

    model: pin.Model
    links: LinkBodies
    pairs: Ints64
    mimics: dict[str, Mimic]
    initial: dict[str, Floats]

    def allowed_pairs(self, srdf: Srdf | None, disabled: Iterable[DisabledPair]) -> Ints64:
        """The pairs (k, 2) of bodies that neither an SRDF nor a robot's YAML disables."""
        links = [str(body.link) for body in self.links.bodies]
        named = {frozenset((pair.link_a, pair.link_b)) for pair in disabled}
        if srdf is not None:
            untested = untested_pairs(srdf.root, list(dict.fromkeys(links)))
            named |= {frozenset((pair.link_a, pair.link_b)) for pair in untested}
        kept = [frozenset((links[a], links[b])) not in named for a, b in self.pairs.tolist()]
        return np.asarray(self.pairs[np.array(kept, dtype=bool)])


def read_mjcf_robot(path: Path, floating: bool) -> MjcfRobot:
    """Compiles an MJCF file and takes the robot out of it.

    Args:
        path: The file.
        floating: Whether the user asks for a root that floats, which only the file can say.

    Returns:
        The robot.

    Raises:
        PlannercheckError: If the file is no robot, or holds what can't be taken; the error names file and element.
    """
    if floating:
        raise PlannercheckError(f"MJCF {path}: give the root body a <freejoint/> for a root that floats")
    file = read_mjcf(path)
    if not len(file.jnt_type):
        raise PlannercheckError(
            f"MJCF {path} has no joints, so that it is no robot but obstacles: take it as Scene.from_mjcf(path), or by "
            "--scene"
        )
    check_flexes(file)
    geoms = robot_geoms(file)
    mimics = _mimics(file)
    _warn(file, geoms)
    names, links = file.names["geom"], file.names["body"]
    bodies = tuple(
        GeometryObject(names[k], links[file.geom_bodyid[k]], file.geom_pose(k), shape_of_geom(file, k))
        for k in geoms.tolist()
    )
    meshes = tuple(_mesh(file, k) if file.geom_type[k] == MESH else None for k in geoms.tolist())
    model = pinocchio_model(file)
    joints = [model.frames[model.getFrameId(str(body.link), pin.FrameType.BODY)].parentJoint for body in bodies]
    pairs = tested_pairs(file)
    own = np.searchsorted(geoms, pairs[np.isin(pairs, geoms).all(axis=1)])
    of_links = LinkBodies(bodies, np.array(joints, dtype=np.int64), meshes)
    return MjcfRobot(model, of_links, own, mimics, initial_values(file, mimics))


def _mesh(file: MjcfFile, geom: int) -> MeshFile:
    """The mesh of a geom as MuJoCo has compiled it."""
    return MeshFile(file.path, (MeshObject("", *mesh_of_geom(file, geom)),), "")


def _mimics(file: MjcfFile) -> dict[str, Mimic]:
    """The joints that equalities bind to others.

    Raises:
        PlannercheckError: For an equality that is not linear, a second one for the same joint, or a circle.
    """
    mimics: dict[str, Mimic] = {}
    joints = file.names["joint"]
    for k in _equalities(file):
        dependent, leader = int(file.eq_obj1id[k]), int(file.eq_obj2id[k])
        if file.eq_type[k] != EQUAL_JOINTS or leader < 0:
            continue
        shift, factor, *more = file.eq_data[k][:5].tolist()
        if any(more):
            raise file.refused(
                "equality",
                k,
                f"has polycoef {[shift, factor, *more]}: a mimic joint is linear, so the last 3 must be 0",
            )
        if joints[dependent] in mimics:
            raise file.refused("equality", k, f"is a second one for joint {joints[dependent]!r}: leave one")
        at, of = file.qpos0[file.jnt_qposadr[[dependent, leader]]].tolist()
        mimics[joints[dependent]] = Mimic(joints[leader], factor, at + shift - factor * of)
    for name in mimics:
        try:
            followed(name, mimics, ())
        except PlannercheckError as error:
            raise PlannercheckError(f"MJCF {file.path}: {error}") from None
    return mimics


def _equalities(file: MjcfFile) -> list[int]:
    """The equalities that are active."""
    return [] if "EQUALITY" in file.disabled else np.flatnonzero(file.eq_active0).tolist()


def _warn(file: MjcfFile, geoms: Ints64) -> None:
    """Warns of what the file says and the robot does not do."""
    names = file.names
    others = [
        names["equality"][k] for k in _equalities(file) if file.eq_type[k] != EQUAL_JOINTS or file.eq_obj2id[k] < 0
    ]
    balls = np.flatnonzero((file.jnt_type == BALL) & (file.jnt_limited != 0))
    fixed = np.flatnonzero((file.body_mocapid >= 0) & file.is_of_robot)
    obstacles = [names["geom"][k] for k in obstacle_geoms(file)]
    said = [
        (obstacles, f"obstacles, no part of the robot: give scene=Scene.from_mjcf({str(file.path)!r}), or --scene"),
        (others, "equalities that bind no two joints: they are not applied, so configurations may violate them"),
        ([names["joint"][k] for k in balls], "ball joints, whose range is not applied"),
        ([names["body"][k] for k in fixed], "mocap bodies, which stand where they begin"),
    ]
    for found, what in said:
        if found:
            warn(f"MJCF {file.path}: {_listed(found)}: {what}")
    if not len(geoms):
        warn(f"MJCF {file.path} has no geoms that collide: nothing will ever")
    elif file.disabled & {"CONSTRAINT", "CONTACT"}:
        text = "disables contacts, so that no two of its geoms are tested against each other"
        warn(f"MJCF {file.path} {text}")


def _listed(names: list[str]) -> str:
    more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    return ", ".join(map(shortened, names[:_SHOWN])) + more
