"""Sphere models of cuRobo: its robot configurations, and its XRDF files.

In: the YAML of a file. Out: `Primitives` by link, as cuRobo's own loader makes them: only links in
`collision_link_names` count; `collision_sphere_buffer`, one number or one a link, is added to each radius; numbers
are rounded to 32 bits; spheres of a negative radius are off, as are the placeholders of `extra_collision_spheres`,
which replace whatever their link has. `self_collision_buffer` plays no part against the scene. Links in `extra_links`
that are fixed to a link of the robot carry their spheres to it. Files that have `collision_spheres` alone, as
robometrics', are read likewise.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.checked_yaml import (
    Node,
    error_context,
    mapping,
    number,
    numbers,
    parse_yaml,
    read_bytes,
    required,
    sequence,
    text,
)
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.user_warnings import warn
from plannercheck.common.written_yaml import yaml_of
from plannercheck.coverings.primitives import Primitives
from plannercheck.coverings.regions import posed

SUFFIXES = (".yml", ".yaml", ".xrdf")


def read(path: Path, link_names: Sequence[str]) -> dict[str, Primitives]:
    """Reads a model: the spheres of the robot's links that have any.

    Raises:
        PlannercheckError: If the file is no such model, names unknown links, or has numbers that are none.
    """
    document = parse_yaml(read_bytes(path))
    kinematics = _of_xrdf(document) if document.get("format") == "xrdf" else _kinematics(document)
    given = kinematics.get("collision_spheres")
    if isinstance(given, str):
        with error_context(f"collision_spheres {given!r}"):
            given = required(parse_yaml(read_bytes(path.parent / given)), "collision_spheres")
    if given is None:
        raise PlannercheckError("no 'collision_spheres': it is no sphere model of cuRobo")
    spheres = dict(mapping(given, "collision_spheres"))
    attached = mapping(kinematics.get("extra_collision_spheres"), "extra_collision_spheres")
    spheres.update({link: [] for link in attached})
    listed = kinematics.get("collision_link_names")
    names = list(spheres) if listed is None else [text(n, "collision_link_names") for n in sequence(listed, "names")]
    found: dict[str, Primitives] = {}
    for name in names:
        if name not in spheres:
            raise unknown_name("link with spheres in collision_link_names", name, spheres)
        with error_context(f"link {name!r}"):
            rows = _rows(spheres[name], _buffer(kinematics, name))
            link, pose = _carrier(name, mapping(kinematics.get("extra_links"), "extra_links"), link_names)
        if rows:
            moved = [(posed(np.array(centre), pose).tolist(), radius) for centre, radius in rows]
            found[link] = found.get(link, Primitives.of()) + Primitives.of(spheres=moved)
    return found


def _kinematics(document: Node) -> Node:
    """The part of a robot's configuration that has the spheres."""
    inner = mapping(document.get("robot_cfg", document), "robot_cfg")
    return mapping(inner.get("kinematics", inner), "kinematics")


def _of_xrdf(document: Node) -> Node:
    """What cuRobo makes of an XRDF: all links of its collision geometry count."""
    collision = mapping(required(document, "collision"), "collision")
    name = text(required(collision, "geometry"), "geometry")
    geometries = mapping(required(document, "geometry"), "geometry")
    if name not in geometries:
        raise unknown_name("collision geometry", name, geometries)
    spheres = required(mapping(geometries[name], name), "spheres")
    buffer = collision.get("buffer_distance")
    return {"collision_spheres": spheres, "collision_sphere_buffer": 0.0 if buffer is None else buffer}


def _buffer(kinematics: Node, link: str) -> float:
    given = kinematics.get("collision_sphere_buffer", 0.0)
    if isinstance(given, dict):
        return number(given[link], f"collision_sphere_buffer of {link}") if link in given else 0.0
    return number(given, "collision_sphere_buffer")


def _rows(given: Any, buffer: float) -> list[tuple[list[float], float]]:
    """Centres and radii with the buffer; those that are off are left out."""
    found, off = [], 0
    for index, entry in enumerate(sequence(given, "spheres")):
        with error_context(f"sphere {index}"):
            node = mapping(entry, "a sphere")
            centre = numbers(required(node, "center"), "center", 3)
            radius = number(required(node, "radius"), "radius") + buffer
        if radius < 0:
            off += 1
            continue
        found.append((np.array(centre, dtype=np.float32).astype(np.float64).tolist(), float(np.float32(radius))))
    if off:
        warn(f"{off} spheres have a negative radius, buffer included: cuRobo leaves them out, and so does the audit")
    return found


def _carrier(name: str, extra: Mapping[str, Any], link_names: Sequence[str]) -> tuple[str, Floats]:
    """The robot's link that carries a link, and the link's pose (4, 4) on it."""
    pose, at = np.eye(4), name
    for _ in range(len(extra) + 1):
        if at in link_names:
            return at, pose
        node = mapping(extra.get(at), f"extra link {at!r}")
        if str(node.get("joint_type", "")).upper() != "FIXED":
            break
        x, y, z, w, i, j, k = numbers(required(node, "fixed_transform"), "fixed_transform", 7)
        pose, at = _pose((x, y, z), (w, i, j, k)) @ pose, text(required(node, "parent_link_name"), "parent_link_name")
    raise unknown_name("link", name, link_names)


def _pose(place: Sequence[float], quaternion: Sequence[float]) -> Floats:
    """A pose from a place, m, and a quaternion w, x, y, z."""
    length = float(np.linalg.norm(quaternion))
    if not length:
        raise PlannercheckError("'fixed_transform' has a quaternion of length 0")
    w, x, y, z = (each / length for each in quaternion)
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = place
    return pose


def model_text(covers: Mapping[str, Primitives], source: Path | None) -> str:
    """The YAML of a model of spheres by link, with the other entries of a robot's configuration, if one is the source.

    Raises:
        PlannercheckError: If there are other primitives than spheres.
    """
    for link, cover in covers.items():
        if not cover.are_spheres:
            raise PlannercheckError(f"link {link!r} has capsules or boxes, which cuRobo's format lacks: save as .json")
    spheres = {
        link: [
            {"center": centre, "radius": radius}
            for centre, radius in zip(cover.ends[:, 0].tolist(), cover.radii.tolist(), strict=True)
        ]
        for link, cover in covers.items()
        if len(cover)
    }
    document: Node = {"robot_cfg": {"kinematics": {}}}
    if source is not None:
        document = copy.deepcopy(parse_yaml(read_bytes(source)))
    kinematics = _kinematics(document)
    attached = [name for name in mapping(kinematics.get("extra_collision_spheres"), "spheres") if name not in spheres]
    if source is None or "collision_link_names" in kinematics:
        kinematics["collision_link_names"] = [*spheres, *attached]
    kinematics["collision_sphere_buffer"] = 0.0
    kinematics["collision_spheres"] = spheres
    return yaml_of(document, width=120)
