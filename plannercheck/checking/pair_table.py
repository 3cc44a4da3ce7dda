"""The pair table: which bodies are tested against which.

In: a robot and a scene. Out: indices into the robot's bodies followed by the scene's. Left out are pairs that the SRDF
or the robot's YAML disables (they are no self pairs of the robot), pairs that an allowed collision matrix allows, pairs
of an obstacle or a carried object with a link that the SRDF leaves out by default, unless the scene says otherwise of
the pair, and pairs of an obstacle with a body that is fixed to the world, unless the obstacle moves: such pairs never
change, so they are judged once (`static`). `left_out_pairs` lists all places where a pair may be left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Bools
from plannercheck.common.arrays import read_only
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.user_warnings import warn
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene

Acm: TypeAlias = Literal["robot", "scene"]


@dataclass(frozen=True)
class PairTable:
    """Pairs of bodies, as indices into the robot's bodies followed by the scene's.

    Attributes:
        pairs: (k, 2) pairs that are tested at every configuration: self pairs, then pairs with obstacles.
        static: (m, 2) pairs of a body that is fixed to the world with an obstacle: the same at every configuration.
        self_count: How many of `pairs` are self pairs.
    """

    pairs: NDArray[np.int32]
    static: NDArray[np.int32]
    self_count: int


def pair_table(robot: Robot, scene: Scene, self_collision: bool, acm: Acm) -> PairTable:
    """Builds the table.

    Args:
        robot: The robot; its `self_pairs` are taken as they are.
        scene: The scene; its allowed collisions act on pairs with obstacles and carried objects, and on other self
            pairs only with acm="scene".
        self_collision: Whether self pairs are tested at all.
        acm: "robot" or "scene".

    Returns:
        The table.
    """
    if acm not in ("robot", "scene"):
        raise PlannercheckError(f"acm must be 'robot' or 'scene', not {acm!r}")
    own = robot.self_pairs.astype(np.int32) if self_collision else _rows([])
    labels = [body.label for body in robot.bodies]
    matrix = scene.allowed.with_defaults(robot.default_links)
    if acm == "scene" or robot.carried:
        carried = np.array([body.carried is not None for body in robot.bodies], dtype=bool)
        asked = np.flatnonzero(carried[own[:, 1]] | (acm == "scene"))
        said = [matrix if is_carried else scene.allowed for is_carried in carried[own[asked, 1]].tolist()]
        pairs = zip(said, own[asked].tolist(), strict=True)
        own = np.delete(own, asked[np.array([by(labels[a], labels[b]) for by, (a, b) in pairs], dtype=bool)], axis=0)
    kept = ~matrix.table(labels, scene.body_objects)
    kept &= ~scene.allowed.geometry_table(robot.bodies, scene.body_objects)
    fixed = robot.remembered("fixed", lambda: _on_fixed_links(robot))
    rests = fixed[:, None] & np.array([body.link is None for body in scene.bodies], dtype=bool)
    obstacles, static = _with_obstacles(kept & ~rests), _with_obstacles(kept & rests)
    return PairTable(read_only(np.concatenate([own, obstacles])), read_only(static), len(own))


def warn_of_unknown_names(robot: Robot, scene: Scene) -> None:
    """Warns of pairs that a user allows or forbids to touch by a name that there is not."""
    names = [*robot.link_names, *(item.name for item in (*robot.carried, *scene.objects))]
    unknown = sorted({name for pair in scene.allowed.asked for name in pair}.difference(names))
    if unknown:
        more = f" (and {len(unknown) - 1} more)" if len(unknown) > 1 else ""
        warn(
            f"scene {scene.name!r} says which pairs may touch by an {unknown_name('link or object', unknown[0], names)}"
            f"{more}; such an entry does nothing"
        )


def _with_obstacles(chosen: Bools) -> NDArray[np.int32]:
    """Rows of pairs, given which of them (bodies, obstacles) are chosen; bodies first, then obstacles."""
    body, obstacle = np.nonzero(chosen)
    rows = np.empty((len(body), 2), dtype=np.int32)
    rows[:, 0], rows[:, 1] = body, obstacle + len(chosen)
    return rows


def _on_fixed_links(robot: Robot) -> Bools:
    """(bodies,) whether no joint can move a body's link."""
    fixed = fixed_links(robot)
    return np.array([body.link in fixed for body in robot.bodies], dtype=bool)


def fixed_links(robot: Robot) -> frozenset[str]:
    """Names of the links that no joint can move."""
    model = robot.model
    frames = {name: model.frames[model.getBodyId(name)] for name in robot.link_names}
    return frozenset(name for name, frame in frames.items() if frame.parentJoint == 0)


def _rows(pairs: list[tuple[int, int]]) -> NDArray[np.int32]:
    rows = np.array(pairs, dtype=np.int32).reshape(-1, 2)
    rows.flags.writeable = False
    return rows
