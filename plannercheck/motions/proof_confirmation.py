"""Compares the model in a proof with a robot's and a scene's files.

In: a proof, a robot, a scene. Out: nothing, or an `UnprovedError` that names the first difference.

The joints, their placements, axes and who follows whom are compared by `urdf_trees.py` with the exact numbers of the
URDF, or of what a xacro expands to, and the links' bodies by `urdf_shapes.py` with its elements and meshes. The robots
of a cell are compared one by one, each at the pose that `cell_places.py` reads. Bodies, the pair table, and the joint
of each column are compared bit for bit with what plannercheck itself loads, since SRDFs, groups and scenes have many
rules; so are the joints of an MJCF file, of which there is no second reader. So plannercheck's loader is trusted for
these; its kinematics and its verdicts are not. The values of joints outside the group are part of the claim: they are
in the proof, not in the URDF.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from plannercheck.bodies.mesh_files import MeshUnits
from plannercheck.common.package_files import folders_above, package_file
from plannercheck.motions.checker import Checker
from plannercheck.motions.pair_decisions import PairDecider
from plannercheck.motions.pair_proof_builder import LinkPairs
from plannercheck.motions.proof_model import space_model
from plannercheck.proofs.cell_places import base_placements
from plannercheck.proofs.data import WORLD, Joint, Model, Motion, PosedBody
from plannercheck.proofs.exact_placements import enough_digits
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.link_pairs import PairProofs
from plannercheck.proofs.urdf_shapes import MeshFiles, confirm_shapes
from plannercheck.proofs.urdf_trees import ALONE, RobotPlace, confirm_limits, confirm_tree
from plannercheck.robots.description import RobotDescription, description_of
from plannercheck.robots.link_geometry import Geometry
from plannercheck.robots.robot import Robot
from plannercheck.robots.urdf_file import MJCF_ROOT
from plannercheck.scenes.scene import Scene
from plannercheck.scenes.scene_paths import MeshKind


def confirm_model(
    model: Model,
    robot: str | RobotDescription,
    scene: str | None,
    meshes: MeshKind = "hull",
    geometry: Geometry | None = None,
    mesh_units: MeshUnits | None = None,
    motions: Sequence[Motion] = (),
) -> tuple[str, ...]:
    """Compares a model with files.

    Args:
        model: The well-formed model of a proof in space.
        robot: Name of a shipped robot, or a robot YAML or URDF file, or a description.
        scene: Name of a shipped scene, or a scene file; None for the empty one.
        meshes: What meshes of the scene are.
        geometry: What meshes of the robot are; None for what its description says.
        mesh_units: How mesh files are read; None for what the robot's description says, and the scene's default.
        motions: Those that the proofs are about: their times are compared where something in the scene moves.

    Returns:
        What was compared with which file.

    Raises:
        UnprovedError: If they differ.
        PlannercheckError: If a file can't be read.
    """
    description = _described(robot, geometry, mesh_units)
    loaded = Robot.from_description(description)
    robots = tuple(_placed_robots(description))
    folders = tuple(folder for each, _ in robots for folder in each.package_dirs)
    obstacles = Scene("empty") if scene is None else Scene.load(scene, folders, meshes=meshes, mesh_units=mesh_units)
    checker = Checker(loaded, obstacles)
    known = space_model(checker.with_all_columns)
    own = _without_carriers(model, known, loaded)
    _check_all_are_of(own, tuple(place.prefix for _, place in robots))
    compared, of_mjcf = list[str](), list[str]()
    for each, place in robots:
        if each.file.kind == MJCF_ROOT:
            of_mjcf.append(place.prefix)
        else:
            compared += _confirm_urdf(own, each, place, whole=loaded.group is None)
    for prefix in of_mjcf:
        _compare_trees(model, known, prefix)
    _compare_columns(model, known)
    _compare_bodies(model, known)
    where = "the empty scene" if scene is None else f"the scene {scene!r}"
    loaded_from = f"{str(description.urdf)!r} and {where}"
    compared += [f"bodies, pairs and columns, bit for bit, with what plannercheck loads of {loaded_from}"]
    return (*compared, *_compare_clocks(checker, motions))


def confirm_pairs(
    proofs: PairProofs,
    robot: str | RobotDescription,
    scene: str | None,
    meshes: MeshKind | None,
    geometry: Geometry | None = None,
    mesh_units: MeshUnits | None = None,
) -> tuple[str, ...]:
    """Compares the model and the limits of well-formed proofs about pairs of links with a robot's files.

    Arguments and errors are as of `confirm_model`; there is no scene.
    """
    description, model = _described(robot, geometry, mesh_units), proofs.model
    decider = PairDecider(Robot.from_description(description))
    robots = tuple(_placed_robots(description))
    _check_all_are_of(model, tuple(place.prefix for _, place in robots))
    compared, columns, limits = list[str](), set[int](), (proofs.lower, proofs.upper)
    for each, place in robots:
        if each.file.kind == MJCF_ROOT:
            raise UnprovedError("limits of an MJCF have no second reader")
        compared += _confirm_urdf(model, each, place, whole=False)
        columns |= confirm_limits(model, limits, each.urdf, each.file.mended, place)
    if columns != set(range(model.columns)):
        raise UnprovedError(f"columns {sorted(columns ^ set(range(model.columns)))} are of no joint with limits")
    ends = ((model.bodies[a].link, model.bodies[b].link) for a, b in model.pairs)
    links = {(model.links[a].name, model.links[b].name) for a, b in ends}  # more than are proved where none was found
    known = space_model(LinkPairs(decider, sorted(links | {(pair.link_a, pair.link_b) for pair in proofs.pairs})))
    _compare_columns(model, known)
    _compare_bodies(model, known)
    loaded_from = str(description.urdf)
    return (*compared, f"limits with {loaded_from!r}, bodies bit for bit with what plannercheck loads of it")


def _described(
    robot: str | RobotDescription, geometry: Geometry | None, mesh_units: MeshUnits | None
) -> RobotDescription:
    description = description_of(robot)
    if geometry is not None:
        description = dataclasses.replace(description, geometry=geometry)
    return description if mesh_units is None else dataclasses.replace(description, mesh_units=mesh_units)


def _without_carriers(model: Model, loaded: Model, robot: Robot) -> Model:
    """The model without the joints and links by which a scene moves objects; these are compared bit for bit."""
    links, joints = len(robot.link_names), robot.model.njoints - 1
    if len(loaded.links) == links:
        return model
    if (model.links[links:], model.joints[joints:]) != (loaded.links[links:], loaded.joints[joints:]):
        raise UnprovedError("what moves in the scene is on other joints in the proof than in the files")
    bodies = tuple(body for body in model.bodies if body.link < links)
    return dataclasses.replace(model, links=model.links[:links], joints=model.joints[:joints], bodies=bodies, pairs=())


def _compare_clocks(checker: Checker, motions: Sequence[Motion]) -> Iterator[str]:
    """Compares where objects that move are at the motions' times with the scene."""
    if checker.clock is None or not motions:
        return
    from plannercheck.proofs.scene_clocks import Course, check_clocks  # needs python-flint

    courses, column = list[Course](), checker.robot.nq
    for course in checker.clock.courses:
        names = ", ".join(repr(name) for name in course.objects)
        curve = course.curve
        rows = [curve.ends[0, 0].tolist(), *curve.ends[:, 1].tolist()]
        courses.append(Course(names, column, course.knots.tolist(), rows, curve.units, course.stands))
        column += curve.nq
    off = check_clocks(motions, courses)
    names = ", ".join(repr(item.name) for item in checker.scene.moving)
    yield f"where {names} is at the proof's times, with the scene: places within the tube, turns within {off:.2g}"


def _placed_robots(
    description: RobotDescription, place: RobotPlace = ALONE
) -> Iterator[tuple[RobotDescription, RobotPlace]]:
    """The robots of a description, one unless it is of a cell, whose poses the verifier reads by itself."""
    if not description.robots:
        yield description, place
        return
    bases = base_placements(description.urdf)
    if bases.keys() != description.robots.keys():
        raise UnprovedError(f"the cell {str(description.urdf)!r} has other robots for the verifier: {list(bases)}")
    for name, base in bases.items():
        with enough_digits():
            whole = base if place.base is None else place.base.times(base)
        yield from _placed_robots(description.of_robot(name), RobotPlace(f"{place.prefix}{name}/", whole))


def _check_all_are_of(model: Model, prefixes: tuple[str, ...]) -> None:
    """Raises for a link or joint of a robot that the files do not have."""
    for name in (*(link.name for link in model.links), *(joint.name for joint in model.joints)):
        if not name.startswith(prefixes):
            raise UnprovedError(f"{name!r} is of no robot of the files, which have {', '.join(prefixes)}")


def _confirm_urdf(model: Model, description: RobotDescription, place: RobotPlace, whole: bool) -> Iterator[str]:
    """Compares one robot with its URDF."""
    file = description.file
    yield confirm_tree(model, description.urdf, file.mended, description.floating, whole, place)
    find = partial(package_file, folders=description.package_dirs, above=folders_above(file.path))
    meshes = MeshFiles(str(description.urdf), find, description.mesh_units != "file")
    yield from confirm_shapes(model, file.mended, meshes, place.prefix)


def _compare_trees(model: Model, loaded: Model, prefix: str) -> None:
    """Checks that links and joints of a robot are those of the checker, but for the values at which joints are held."""
    proved, there = ([link for link in each.links if link.name.startswith(prefix)] for each in (model, loaded))
    if proved != there:
        names = sorted({link.name for link in proved} ^ {link.name for link in there})[:3]
        raise UnprovedError(f"links of the proof and of the MJCF differ: {names or 'in place'}")
    for joint, other in zip(model.joints, loaded.joints, strict=False):  # their number is compared with the columns
        if joint.name.startswith(prefix) and _as_moved(joint) != _as_moved(other):
            raise UnprovedError(f"joint {joint.name!r} is not as the MJCF has it")


def _as_moved(joint: Joint) -> Joint:
    """A joint, with no values where it is held: these are part of the claim."""
    offsets = (0.0 if column < 0 else offset for column, offset in zip(joint.columns, joint.offsets, strict=True))
    return dataclasses.replace(joint, offsets=tuple(offsets))


def _compare_columns(model: Model, loaded: Model) -> None:
    """Checks that each number of a configuration moves the same joints as in the checker."""
    for joint, other in zip(model.joints, loaded.joints, strict=False):  # as many as in the URDF
        given, known = ((each.name, each.kind, each.columns) for each in (joint, other))
        if given != known:
            raise UnprovedError(
                f"joint {joint.name!r} takes the columns {joint.columns}, in the files {known} is in its place"
            )
    if len(model.joints) != len(loaded.joints):
        raise UnprovedError(f"the proof has {len(model.joints)} joints, in the files there are {len(loaded.joints)}")
    if (model.columns, model.whole_turns) != (loaded.columns, loaded.whole_turns):
        raise UnprovedError(
            f"configurations have {model.columns} numbers, whole turns at {model.whole_turns}; in the files "
            f"{loaded.columns}, and at {loaded.whole_turns}"
        )


def _solids(model: Model) -> str:
    """The labels of bodies that are solids, in words."""
    return ", ".join(dict.fromkeys(body.label for body in model.bodies if body.triangles)) or "none"


def _compare_bodies(model: Model, loaded: Model) -> None:
    known = {_key(loaded, body): index for index, body in enumerate(loaded.bodies)}
    found = []
    for body in model.bodies:
        index = known.get(_key(model, body))
        if index is None:
            raise UnprovedError(f"body {body.name!r} ({body.label!r}) is not in the files, or stands elsewhere")
        found.append(index)
        other = loaded.bodies[index]
        same = np.array_equal(body.vertices, other.vertices) and body.triangles == other.triangles
        same = same and body.half_space == other.half_space and _same_parts(body, other)
        if not same or not abs(body.radius - body.padding - other.radius + other.padding) <= 1e-15 * body.radius:
            given, there = _solids(model), _solids(loaded)
            why = "" if given == there else f": solids are {given} in the proof, and {there} in the files"
            raise UnprovedError(f"body {body.name!r} ({body.label!r}) has another shape than in the files{why}")
    # Compared by index: a part of an obstacle may have the name of a link's geometry.
    proved = {frozenset((found[a], found[b])) for a, b in model.pairs}
    missing = [pair for pair in loaded.pairs if frozenset(pair) not in proved]
    if missing:
        names = tuple(f"{loaded.bodies[k].name!r} ({loaded.bodies[k].label!r})" for k in missing[0])
        raise UnprovedError(f"{len(missing)} pairs of the checker's table are not in the proof: {names}")


def _same_parts(body: PosedBody, other: PosedBody) -> bool:
    first, second = (np.zeros(0) if each.radii is None else each.radii for each in (body, other))
    return (body.parts, body.base) == (other.parts, other.base) and np.array_equal(first, second)


def _key(model: Model, body: PosedBody) -> tuple[str, str, str, tuple[float, ...]]:
    return body.name, body.label, "" if body.link == WORLD else model.links[body.link].name, body.pose
