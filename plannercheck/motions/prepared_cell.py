"""Prepared cells: a checker as a file for C++, which reads it without URDF, meshes or Pinocchio.

In: a checker. Out: the sections that cpp/library/prepared_cell.cpp, cell_bodies.cpp and cell_motions.cpp read, in this
order: what the compiled kinematics, checkers and certifiers of both tables are made of. Prepared hulls are in the file
as they are; solids, sets of parts and half-spaces by the arrays that make them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from plannercheck.bodies.kinds import Kind
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import GeometryObject, checked_pose
from plannercheck.checking.compiled_tables import CompiledTables
from plannercheck.common.array_types import Bools, Floats, Ints
from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.section_files import Section, file_of, text, texts
from plannercheck.common.version import __version__
from plannercheck.motions.added_obstacles import AddedObstacles
from plannercheck.motions.certifier import MotionCertifier
from plannercheck.motions.certifier_pairs import ChainedPairs
from plannercheck.robots.configurations import LARGEST_VALUE
from plannercheck.robots.robot import Robot
from plannercheck.robots.unit_lengths import UNIT_TOLERANCE
from plannercheck.scenes.scene import Scene

# kCellFormat in cpp/library/cell_file.hpp.
CELL_FORMAT = 6

# BodyKind in cpp/library/cell_bodies.cpp.
_HULL, _SOLID, _HALF_SPACE = 0, 1, 5
_PART_SETS = {"balls": 2, "cells": 3, "columns": 4}


class CellInputs(NamedTuple):
    """What a checker's prepared cell is made of.

    Attributes:
        robot: The robot.
        kernel: The kinematics that pose it.
        scene: The scene, which stands still.
        bodies: The bodies.
        labels: The link or obstacle of each.
        polytopes: The prepared bodies, None where no pair needs it; then those of `added.copies`.
        pairs: (k, 2) indices of bodies.
        paddings: (bodies,) each body's part of the padding, m.
        unreachable: (k,) which pairs can't meet within the limits.
        added: How obstacles that are added are tested.
        tables: The pairs, compiled.
        certifier: Proves motions along screws free.
    """

    robot: Robot
    kernel: core.Kinematics
    scene: Scene
    bodies: Sequence[GeometryObject]
    labels: Sequence[str]
    polytopes: Sequence[Polytope | None]
    pairs: Ints
    paddings: Floats
    unreachable: Bools
    added: AddedObstacles
    tables: CompiledTables
    certifier: MotionCertifier


def check_can_be_saved(robot: Robot, scene: Scene, kernel: core.Kinematics | None) -> core.Kinematics:
    """The kinematics of a checker that can be a prepared cell, or an error that says why it can't."""
    what = f"the checker of {robot.name!r} in {scene.name!r} can't be saved as a prepared cell"
    if scene.moving:
        raise PlannercheckError(
            f"{what}: {', '.join(item.name for item in scene.moving)} moves, and a cell's scene stands still"
        )
    if kernel is None:
        raise PlannercheckError(f"{what}: Pinocchio itself poses the robot, and C++ has the compiled kinematics only")
    return kernel


def write_cell(cell: CellInputs, path: Path) -> None:
    """Writes a prepared cell; the file appears whole or not at all.

    Raises:
        PlannercheckError: If it can't be written, or a name has a zero character.
    """
    content = file_of(_sections(cell), CELL_FORMAT, core.body_format)
    write_atomically(path, lambda aside: aside.write_bytes(content))


def _sections(cell: CellInputs) -> Iterator[Section]:
    yield text("about", f"plannercheck {__version__}")
    yield text("robot", cell.robot.name)
    yield text("scene", cell.scene.name)
    yield texts("joint names", cell.robot.joint_names)
    yield texts("link names", cell.robot.link_names)
    yield text("described columns", cell.robot.configuration_map.described_columns())
    copies = [cell.labels[base] for base, _ in cell.added.copies]
    yield texts("body names", (*cell.labels, *copies))
    yield texts("part names", [*map(_part_name, cell.bodies, cell.labels), *("" for _ in copies)])
    yield from _configurations(cell.robot, cell.certifier)
    yield from _kinematics(cell.robot)
    yield from _bodies(cell)
    yield from _added(cell)
    yield from _pairs(cell)
    yield from _motions(cell)


def _configurations(robot: Robot, certifier: MotionCertifier) -> Iterator[Section]:
    lengths, bounds = robot.configuration_map.lengths, certifier.rounding()
    yield Section("lower", robot.lower)
    yield Section("upper", robot.upper)
    yield Section("largest value", LARGEST_VALUE)
    yield Section("unit columns", _rows(lengths.columns, 2))
    yield Section("unit tolerance", min(UNIT_TOLERANCE, float(lengths.harmless)))
    yield Section("turning columns", np.array(bounds.turning, dtype=np.int32))
    yield Section("usual low", bounds.low)
    yield Section("usual high", bounds.high)
    yield Section("kinematic error", float(bounds.usual))


def _kinematics(robot: Robot) -> Iterator[Section]:
    table = robot.joint_table
    assert table is not None
    for name in table._fields[1:]:  # all but the width
        yield Section(name.replace("_", " "), getattr(table, name))
    yield Section("sampled poses", robot.sampled_link_poses.reshape(-1, 16))


def _bodies(cell: CellInputs) -> Iterator[Section]:
    shapes: dict[int, int] = {}  # the place of each prepared body
    distinct: list[Polytope] = []
    of_bodies = []
    for polytope in cell.polytopes:
        if polytope is not None and id(polytope.core) not in shapes:
            shapes[id(polytope.core)] = len(distinct)
            distinct.append(polytope)
        of_bodies.append(-1 if polytope is None else shapes[id(polytope.core)])
    described = [_SHAPES[polytope.kind](polytope.core, polytope.core.shape) for polytope in distinct]
    yield Section("shape kinds", np.array([kind for kind, _ in described], dtype=np.int32))
    for _, sections in described:
        yield from sections
    links, placements = cell.tables.mounts(cell.kernel)
    copied, shares = ([copy[k] for copy in cell.added.copies] for k in (0, 1))
    rows = [*range(len(cell.bodies)), *map(int, copied)]
    yield Section("shapes", np.array(of_bodies, dtype=np.int32))
    yield Section("links", links[rows])
    yield Section("body placements", placements[rows, :3].reshape(-1, 12))
    yield Section("own poses", _own_poses(cell)[rows])
    yield Section("paddings", np.array([*cell.paddings, *shares], dtype=np.float64))
    yield Section("robot bodies", np.array([len(cell.robot.bodies)], dtype=np.int32))


def _part_name(body: GeometryObject, label: str) -> str:
    """The name of an object's body, which no other object may have, where that is not the object's; else ""."""
    return body.name if body.name != label and (body.link is None or body.carried is not None) else ""


def _added(cell: CellInputs) -> Iterator[Section]:
    """Names of obstacles; by their places, the name and the padding of each of their bodies, and what these meet."""
    numbers, paddings, pairs = list[int](), list[float](), list[tuple[int, int]]()
    for number, (shares, met) in enumerate(cell.added.treatments.values()):
        pairs += [(own, len(numbers) + k) for own, k in met]
        numbers += [number] * len(shares)
        paddings += shares
    yield texts("names of added", [*cell.added.treatments])
    yield Section("added", np.array(numbers, dtype=np.int32))
    yield Section("added paddings", np.array(paddings, dtype=np.float64))
    yield Section("added pairs", _rows(pairs, 2))


def _own_poses(cell: CellInputs) -> Floats:
    """(bodies, 12) the pose of each shape in its obstacle; the identity of robots' bodies and of stand-ins."""
    own = {
        id(body): part.pose for item in cell.scene.objects for body, part in zip(item.bodies, item.parts, strict=True)
    }
    poses = [checked_pose(own.get(id(body)), f"body {body.name!r}")[:3] for body in cell.bodies]
    return np.array(poses, dtype=np.float64).reshape(-1, 12)


def _hull(body: core.Polytope, _: None) -> tuple[int, list[Section]]:
    return _HULL, [Section("hull", np.frombuffer(body.serialise(), dtype=np.uint8))]


def _solid(body: core.Polytope, solid: core.Solid) -> tuple[int, list[Section]]:
    _, hull = _hull(body, None)
    return _SOLID, [*hull, Section("points", solid.points()), Section("triangles", solid.triangles())]


def _parts(body: core.Polytope, parts: core.PartSet) -> tuple[int, list[Section]]:
    maker, given = parts.state()
    return _PART_SETS[maker], [Section("inflation radius", body.inflation_radius), *_part_set(maker, *given)]


def _half_space(body: core.Polytope, half_space: tuple[Any, float]) -> tuple[int, list[Section]]:
    normal, offset = half_space
    plane = Section("half-space", np.array([[*normal, offset]]))
    return _HALF_SPACE, [Section("inflation radius", body.inflation_radius), plane]


_SHAPES: dict[Kind, Callable[[core.Polytope, Any], tuple[int, list[Section]]]] = {
    "hull": _hull,
    "solid": _solid,
    "part_set": _parts,
    "half_space": _half_space,
}


def _part_set(maker: str, *given: Any) -> list[Section]:
    """Sections of the arguments of one of the core's makers of part sets."""
    if maker == "balls":
        points, radii = given
        return [Section("points", points), Section("radii", radii)]
    if maker == "cells":
        keys, sizes, resolution, origin = given
        return [Section("keys", keys), Section("sizes", sizes), Section("lattice", np.array([[resolution, *origin]]))]
    heights, step, origin, base = given
    return [Section("heights", heights), Section("lattice", np.array([[*step, *origin, base]]))]


def _pairs(cell: CellInputs) -> Iterator[Section]:
    tables = cell.tables
    yield Section("pairs", _rows(cell.pairs, 2))
    yield Section("unreachable", cell.unreachable)
    yield Section("has limits", np.array([tables.limits is not None], dtype=np.int32))
    yield Section("cell tables", np.array([len(tables.in_cells)], dtype=np.int32))
    for each in tables.in_cells:
        yield Section("cell columns", np.array(each.made_of.columns, dtype=np.int32))
        yield Section("cell lows", np.array(each.made_of.lows))
        yield Section("cells per unit", np.array(each.made_of.per_unit))
        yield Section("may meet", each.made_of.may_meet)
        yield Section("cell pairs", each.pairs)


def _motions(cell: CellInputs) -> Iterator[Section]:
    by_table = cell.certifier.pairs_by_table()
    links, bases = cell.tables.mounts(cell.kernel)[0], cell.added.bases
    movers = [body for body in sorted(bases) if links[bases[body]] >= 0]
    joints = by_table[0].of_robot
    drives, factors, parts = joints.drives
    yield Section("drives", drives)
    yield Section("factors", factors)
    yield Section("parts", _rows(parts, 2))
    for name in ("defect", "leverage", "depth"):
        yield Section(name, float(getattr(joints, name)))
    yield Section("extent", float(joints.spread.extent))
    yield Section("most joints", float(joints.spread.joints))
    yield Section("travel", joints.spread.travel)
    for pairs in by_table:
        yield from _chained(pairs, movers, [bases[body] for body in movers])


def _chained(pairs: ChainedPairs, movers: list[int], bases: list[int]) -> Iterator[Section]:
    """A table's pairs, and the chains from the world to bodies that meet added obstacles, which copy the bases."""
    obstacle = pairs.of_robot.own_count
    asked = np.array([(base, obstacle) for base in bases], dtype=np.int64).reshape(-1, 2)
    chains = pairs.of_robot.of(np.concatenate([pairs.table, asked]))
    yield Section("chained pairs", _rows(chains.pairs[: len(pairs.table)], 5))
    yield Section("from world", _rows([*zip(movers, chains.pairs[len(pairs.table) :, 3], strict=True)], 2))
    yield Section("first entry", chains.first_entry)
    yield Section("entries", _rows(chains.entries, 3))
    yield Section("arms", chains.arms)
    yield Section("slides", chains.slides)
    yield Section("touching", np.array(pairs.touching, dtype=np.int32))


def _rows(values: Any, columns: int) -> Any:
    return np.array(values, dtype=np.int32).reshape(-1, columns)
