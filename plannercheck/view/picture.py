"""Makes the picture of a checker's robot and scene at configurations.

In: a checker in space or in the plane, configurations. Out: a `Picture` whose poses are those that verdicts use, with
colliding bodies in red. Planar bodies are drawn as flat prisms.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.checking.named_configurations import given_configurations, named_configuration
from plannercheck.checking.protocols import AnyChecker
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.arrays import Configuration, contiguous
from plannercheck.common.errors import PlannercheckError, with_article
from plannercheck.motions.checker import Checker
from plannercheck.planar.checker import Checker as PlanarChecker
from plannercheck.view.drawn_parts import DrawnParts, has_many_parts, parts_of
from plannercheck.view.evidence import Evidence
from plannercheck.view.floors import with_floor
from plannercheck.view.model import OBSTACLE_OPACITY, VEIL_OPACITY, Mesh, Plane, Witness
from plannercheck.view.page import Picture
from plannercheck.view.planar_bodies import planar_meshes, planar_witnesses
from plannercheck.view.surfaces import Surface, Visual, surface_of

# Planes a frame: several for a state that is looked at, one where frames pass by.
_PLANES_OF_ONE, _PLANES_OF_MANY = 3, 1
# More frames than these make pages that are slow to load.
MOST_FRAMES = 2000
# What to look at reaches so much further than the robot.
_MARGIN = 1.15


def picture(
    checker: AnyChecker,
    q: Configuration,
    *,
    labels: Sequence[str] | None = None,
    animated: bool = False,
    times: ArrayLike | None = None,
    time: float | None = None,
    planes: int | None = None,
    meshes: Mapping[str, Surface] | None = None,
    visuals: Sequence[Visual] = (),
) -> Picture:
    """Makes a picture.

    Args:
        checker: A checker in space, or a planar one.
        q: (nq,) or (n, nq) a configuration a frame; or each joint's value of one by its name.
        labels: What the frames are called; default: their numbers.
        animated: Whether the frames follow each other in time, as those of `along_path` do.
        times: (n,) s, growing: frames are played in real time, with the least clearance over time as a plot. What
            moves in the scene is where it is then.
        time: In place of `times`, one time of the scene's clock for all frames, s.
        planes: Separating planes a frame, of the nearest pairs; default: 3 for one frame, 1 for several; in the plane
            none are drawn.
        meshes: Meshes that `delivered_meshes` gives, to be drawn inside their hulls.
        visuals: Visual meshes of the links, as `visual_meshes` gives them, to be drawn inside the hulls, too.

    Returns:
        The picture.

    Raises:
        PlannercheckError: If it is no checker, if there are no configurations or more than `MOST_FRAMES`, or if labels
            do not fit them.
    """
    if not isinstance(checker, (Checker, PlanarChecker)):
        raise PlannercheckError(f"a picture is of a checker, not of {with_article(type(checker).__name__)}")
    numbers = named_configuration(checker.robot, q) if isinstance(q, Mapping) else q
    rows = given_configurations(checker.robot, numbers)
    names = [f"configuration {k}" for k in range(len(rows))] if labels is None else list(labels)
    if not 0 < len(rows) <= MOST_FRAMES or len(names) != len(rows):
        raise PlannercheckError(
            f"a picture takes 1 to {MOST_FRAMES} configurations, each with a label: not {len(rows)}"
        )
    instants = None if times is None else _checked_times(times, len(rows))
    if isinstance(checker, Checker):
        checker, rows = checker.in_time(rows, time if times is None else instants)
    colliding = checker.colliding_pairs(rows)
    if isinstance(checker, PlanarChecker):
        drawn = planar_meshes(checker, rows, _bodies_hit(checker, colliding))
        sensed: tuple[DrawnParts, ...] = ()
        points, found = planar_witnesses(checker, rows, colliding), list[Plane]()
    else:
        hit = _bodies_hit(checker, colliding)
        drawn = with_floor(space_meshes(checker, rows, hit, meshes or {}, veiled=bool(visuals)))
        drawn += visual_layer(checker, rows, hit, visuals)
        sensed = sensed_layer(checker, rows, hit)
        count = planes if planes is not None else _PLANES_OF_ONE if len(rows) == 1 else _PLANES_OF_MANY
        points, found = _evidence(checker, rows, colliding, count)
    centre, radius = _focus([mesh for mesh in drawn if mesh.layer not in ("obstacle", "floor")] or drawn)
    return Picture(
        title=f"{checker.robot.name} in {checker.scene.name}",
        labels=tuple(names),
        animated=animated or instants is not None,
        meshes=tuple(drawn),
        collisions=tuple(_names_hit(checker, row) for row in colliding),
        planes=tuple(found),
        witnesses=tuple(points),
        centre=centre,
        radius=radius,
        parts=sensed,
        times=instants,
        clearances=checker.clearances(rows) if instants is not None and isinstance(checker, Checker) else None,
    )


def _checked_times(times: ArrayLike, count: int) -> Floats:
    found = contiguous(times)
    if found.shape != (count,) or not np.isfinite(found).all() or not (np.diff(found) > 0).all():
        raise PlannercheckError(f"times must be {count} numbers that grow, one a configuration")
    return found


def space_meshes(
    checker: Checker, rows: Floats, hit: Bools, delivered: Mapping[str, Surface], veiled: bool = False
) -> list[Mesh]:
    """A mesh for each body at configurations (n, nq), where `hit` (n, bodies) collide, and for each delivered mesh.

    `veiled`: all hulls are to be seen through.
    """
    poses = drawn_poses(checker, rows)
    owners = (*(body.link or body.name for body in checker.robot.bodies), *checker.scene.body_objects)
    drawn: list[Mesh] = []
    moving = range(len(checker.robot.bodies), len(checker.bodies))
    for k, (body, owner) in enumerate(zip(checker.bodies, owners, strict=True)):
        at = poses[:, k] if (poses[:, k] != poses[0, k]).any() else poses[:1, k]
        if has_many_parts(body.shape):
            continue
        surface = surface_of(body.shape, body.name)
        if body.link is None or k in moving:
            drawn.append(Mesh(body.name, owner, "obstacle", *surface, at, hit[:, k], OBSTACLE_OPACITY))
            continue
        inside = delivered.get(body.name)
        drawn.append(Mesh(body.name, owner, "hull", *surface, at, hit[:, k], VEIL_OPACITY if inside or veiled else 1.0))
        if inside is not None:
            drawn.append(Mesh(body.name, owner, "mesh", *inside, at, hit[:, k]))
    return drawn


def sensed_layer(checker: Checker, rows: Floats, hit: Bools) -> tuple[DrawnParts, ...]:
    """The bodies of very many parts; arguments as for `space_meshes`."""
    bodies = [k for k, body in enumerate(checker.bodies) if has_many_parts(body.shape)]
    poses = drawn_poses(checker, rows) if bodies else np.zeros(0)
    owners = (*(body.link or body.name for body in checker.robot.bodies), *checker.scene.body_objects)
    found = []
    for k in bodies:
        at = poses[:, k] if (poses[:, k] != poses[0, k]).any() else poses[:1, k]
        where = {"name": checker.bodies[k].name, "owner": owners[k], "poses": at, "colliding": hit[:, k]}
        found.append(parts_of(checker.bodies[k].shape, where))
    return tuple(each for each in found if each is not None)


def visual_layer(checker: Checker, rows: Floats, hit: Bools, visuals: Sequence[Visual]) -> list[Mesh]:
    """What the links look like: a link is red where any of its bodies collides; arguments as for `space_meshes`."""
    if not visuals:
        return []
    links, drawn = checker.robot.link_poses(rows), list[Mesh]()
    for each in visuals:
        poses = links[:, checker.robot.link_index(each.link)] @ each.pose
        of_link = [k for k, body in enumerate(checker.bodies) if body.link == each.link]
        at = poses if (poses != poses[0]).any() else poses[:1]
        drawn.append(Mesh(each.name, each.link, "visual", *each.surface, at, np.any(hit[:, of_link], axis=1)))
    return drawn


def drawn_poses(checker: Checker, rows: Floats) -> Floats:
    """(n, bodies, 4, 4) in the world, those of bodies that no pair needs, too, m."""
    poses = checker.body_poses(rows).copy()
    missing = np.flatnonzero(np.isnan(poses).any(axis=(0, 2, 3)))
    links = checker.robot.link_poses(rows) if len(missing) else None
    for k in missing.tolist():
        body = checker.bodies[k]
        assert links is not None
        poses[:, k] = body.pose if body.link is None else links[:, checker.robot.link_index(body.link)] @ body.pose
    return poses


def _bodies_hit(checker: AnyChecker, colliding: Bools) -> Bools:
    """(n, bodies) which bodies are in a colliding pair."""
    bodies = len(checker.bodies) if isinstance(checker, Checker | PlanarChecker) else 0
    hit = np.zeros((len(colliding), bodies), dtype=bool)
    for row, pair in np.argwhere(colliding).tolist():
        hit[row, checker.pairs[pair]] = True
    return hit


def _names_hit(checker: AnyChecker, colliding: Bools) -> tuple[tuple[str, str], ...]:
    """Names of colliding pairs, each once: links may have several bodies."""
    return tuple(dict.fromkeys(checker.pair_names(int(k)) for k in np.flatnonzero(colliding)))


def _evidence(checker: Checker, rows: Floats, colliding: Bools, count: int) -> tuple[list[Witness], list[Plane]]:
    points: list[Witness] = []
    planes: list[Plane] = []
    evidence = Evidence(checker)
    for frame, poses in enumerate(checker.body_poses(rows)):
        points += evidence.witnesses(frame, poses, colliding[frame])
        planes += evidence.planes(frame, poses, colliding[frame], count)
    return points, planes


def _focus(meshes: Sequence[Mesh]) -> tuple[Floats, float]:
    """Centre (3,) and radius of the box around meshes at all frames, m."""
    if not meshes:
        return np.zeros(3), 1.0
    corners = [mesh.vertices @ pose[:3, :3].T + pose[:3, 3] for mesh in meshes for pose in mesh.poses]
    low, high = np.min([c.min(axis=0) for c in corners], axis=0), np.max([c.max(axis=0) for c in corners], axis=0)
    return (low + high) / 2, _MARGIN * float(np.linalg.norm(high - low)) / 2
