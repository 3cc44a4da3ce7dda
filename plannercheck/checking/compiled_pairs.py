"""Pairs of bodies, compiled into the core's checker.

In: a robot, prepared bodies, some of a checker's pairs. Out: `CompiledPairs`, a core checker that has these pairs and
the bodies in them, and nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.shapes import GeometryObject
from plannercheck.checking.apart_cells import PairsInCells
from plannercheck.checking.prepared_bodies import Preparation
from plannercheck.common.array_types import Floats, Ints
from plannercheck.common.arrays import read_only
from plannercheck.common.core import core
from plannercheck.robots.configurations import LARGEST_VALUE
from plannercheck.robots.robot import Robot

# So many limits of distances are kept compiled.
_MOST_LIMITS = 4


@dataclass(frozen=True, eq=False)
class PairSource:
    """The inputs from which tables of a checker's pairs are compiled.

    Attributes:
        robot: The robot.
        bodies: All bodies.
        preparation: The prepared bodies.
        tuning: The core's record of what saves work.
        kernel: The kinematics that will pose the links: links that it never moves are posed once. None: all links count
            as moving.
    """

    robot: Robot
    bodies: Sequence[GeometryObject]
    preparation: Preparation
    tuning: core.Tuning
    kernel: core.Kinematics | None = None

    @cached_property
    def mounts(self) -> tuple[Ints, Floats]:
        """The links that bodies hang on, and their poses there, see `body_placements`."""
        return body_placements(self.robot, self.bodies, self.kernel)


class CompiledPairs:
    """The core's checker of some pairs.

    Attributes:
        rows: (k,) the rows of the checker's pairs that are compiled here, ascending.
        polytopes: The prepared bodies in them, by index.
        is_still: (k,) whether neither body ever moves, so that the core tests the pair once for all configurations.
        core: The compiled checker of these pairs.
    """

    def __init__(
        self,
        source: PairSource,
        pairs: Ints,
        rows: NDArray[np.int64] | None = None,
        limits: tuple[Floats, Floats] | None = None,
        in_cells: Sequence[PairsInCells] = (),
    ) -> None:
        """Prepares the bodies and compiles.

        Args:
            source: What all tables of the checker have in common.
            pairs: (n, 2) indices of bodies.
            rows: The rows of `pairs` to compile; None for all.
            limits: Least and largest configuration (nq,) that the core may judge with these pairs; None for no limits.
            in_cells: Cells in which some of the compiled pairs, by their index there, are apart within the limits.
        """
        robot = source.robot
        self.rows = np.arange(len(pairs)) if rows is None else rows
        table = pairs[self.rows]
        self._count = len(source.bodies)
        is_used = np.zeros(self._count, dtype=bool)
        is_used[table.ravel()] = True
        self._used = np.flatnonzero(is_used)
        used = self._used.tolist()
        source.preparation.prepare(used)
        self.polytopes = {k: source.preparation.polytope(k) for k in used}
        links, placements = source.mounts[0][self._used], source.mounts[1][self._used]
        places = (np.cumsum(is_used, dtype=np.int32) - 1)[table]
        self.is_still = (links < 0)[places].all(axis=1)
        least, most = limits or (np.full(robot.nq, -LARGEST_VALUE), np.full(robot.nq, LARGEST_VALUE))
        lower, upper = np.maximum(least, -LARGEST_VALUE), np.minimum(most, LARGEST_VALUE)
        self._bodies = [polytope.core for polytope in self.polytopes.values()]
        self._tables = links, placements, places, len(robot.link_names)
        self._sampled = robot.remembered("sampled poses", lambda: core.sampled_poses(robot.sampled_link_poses))
        self._tuning, self._paddings = source.tuning, source.preparation.paddings[self._used]
        self._distances: dict[float, core.Distances] = {}
        cells = [(each.cells, each.pairs) for each in in_cells]
        self.core = core.Checker(self._bodies, *self._tables, lower, upper, self._tuning, self._sampled, cells)

    def distances(self, limit: float) -> core.Distances:
        """Measures pairs that are nearer than a limit, m, which may be infinite; the padding is left out."""
        found = self._distances.get(limit)
        if found is None:
            found = core.Distances(self._bodies, self._paddings, *self._tables, limit, self._tuning, self._sampled)
            recent = list(self._distances.items())[1 - _MOST_LIMITS :]
            self._distances = {**dict(recent), limit: found}  # replaced as one: threads may share it
        return found

    def to_table_rows(self, first: Ints) -> Ints:
        """Indices of these pairs (n,) as indices of the checker's, −1 kept."""
        if not len(self.rows):
            return first
        return np.where(first < 0, first, self.rows[first]).astype(np.int32)

    def colliding(self, link_poses: Floats) -> NDArray[np.bool_]:
        """(n, k) which of these pairs collide at poses of the links (n, links, 4, 4), m."""
        return np.asarray(self.core.all_of_poses(np.ascontiguousarray(link_poses))).astype(bool)

    def body_poses(self, link_poses: Floats) -> Floats:
        """(n, bodies, 4, 4) at poses of the links (n, links, 4, 4), m; NaN for bodies of none of these pairs."""
        poses = np.full((len(link_poses), self._count, 4, 4), np.nan)
        poses[:, self._used] = self.core.body_poses(np.ascontiguousarray(link_poses))
        return poses


def body_placements(
    robot: Robot, bodies: Sequence[GeometryObject], kernel: core.Kinematics | None
) -> tuple[Ints, Floats]:
    """The links that bodies hang on, and their poses there.

    Args:
        robot: The robot.
        bodies: Bodies of the robot or of a scene; those of the robot, which come first, are placed once a robot.
        kernel: The kinematics that will pose the links; links that it never moves count as the world. None: all links
            may move.

    Returns:
        (n,) indices of links, -1 for the world, and (n, 4, 4) poses in these, m: the very doubles that verdicts use.
    """
    count = len(robot.bodies)
    own, others = tuple(bodies[:count]), bodies[count:]
    links, placements = robot.remembered(("placements", own, kernel), lambda: _placed(robot, own, kernel))
    if not others:
        return links, placements
    more_links, more = _placed(robot, others, kernel)
    return np.concatenate([links, more_links]), np.concatenate([placements, more])


def _placed(robot: Robot, bodies: Sequence[GeometryObject], kernel: core.Kinematics | None) -> tuple[Ints, Floats]:
    placements = np.concatenate([np.zeros((0, 4)), *(body.pose for body in bodies)]).reshape(-1, 4, 4)
    if all(body.link is None for body in bodies):
        return np.full(len(bodies), -1, dtype=np.int32), placements
    links = np.array([-1 if b.link is None else robot.link_index(b.link) for b in bodies], dtype=np.int32)
    if kernel is not None:
        still = np.array([link >= 0 and kernel.link_is_constant(link) for link in links.tolist()], dtype=bool)
        poses = np.ascontiguousarray(robot.link_poses(robot.reference)[links[still]])
        placements[still] = core.placed_on_links(poses, placements[still])
        links[still] = -1
    return read_only(links), read_only(placements)
