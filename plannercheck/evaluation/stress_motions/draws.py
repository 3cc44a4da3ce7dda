"""Random draws of the motion stress in space: a robot in a scene, with contacts by construction; motions through them.

In: a family's name, a random generator. Out: a `Draw`. The robot is drawn first, then states. At each state a body is
put where it touches the robot: an obstacle, or a probe on another branch of the robot itself. Motions through these
states that are free at both ends come first, because only their states between show the contact.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from plannercheck.common.array_types import Bools, Floats, Ints64
from plannercheck.evaluation.stress_motions.aims import Aim, Motions, joined
from plannercheck.evaluation.stress_motions.contacts import (
    SHARP,
    USUAL,
    Contact,
    extent_of,
    random_contact,
    random_shape,
)
from plannercheck.evaluation.stress_motions.ends import Stage, moved, state_of
from plannercheck.evaluation.stress_motions.recipes import (
    BodyRecipe,
    Matrix,
    Recipe,
    SpaceRecipe,
    robot_of,
    shape_of,
    space_checker,
    tree_recipe,
)
from plannercheck.evaluation.stress_motions.tangents import tangents_of
from plannercheck.evaluation.stress_motions.trees import (
    CONTINUOUS,
    TURNS,
    Wishes,
    random_pose,
    random_states,
    random_tree,
)
from plannercheck.motions.checker import Checker
from plannercheck.robots.link_geometry import GeometryKind
from plannercheck.robots.robot import Robot

# Motions of a draw: so many that building robot and checkers takes no more time than judging them.
MOTIONS = 100
# Of chains that are off unit many motions are declined, and a fault shows in few contacts: fewer motions, more draws.
OFF_UNIT_MOTIONS = 25
# So many times as many motions are made as are taken, those first that are free at both ends.
_CANDIDATES = 3
# At least this part of a draw is taken as it comes.
_AS_THEY_COME = 0.25
# Obstacles and probes of a draw.
_OBSTACLES, _PROBES = (3, 9), (0, 5)
# Pairs that collide in more than this part of random states are left out: they would hide all others.
_MOSTLY_TOUCHING = 0.2
_PROBED_STATES, _NEAR_STATES = 60, 10
_BASE_HAS_A_BODY, _LINK_HAS_A_BODY, _SECOND_BODY = 0.5, 0.8, 0.25
_BODY_OFFSETS = ((0.8, 0.2), (1.0, 10.0))  # up to this probability, so far off its link's origin, m
_PADDED, _SWAPPED = 0.1, 0.5
# Tolerances, m. Where much is rounded, only coarse ones can be kept.
_USUAL_TOLERANCES = (1e-4, 1e-4, 1e-4, 1e-3)
_TOLERANCES = {"off unit": (1e-2, 1e-3), "far ends": (1e-2, 1e-3, 1e-4)}


@dataclass(frozen=True, eq=False)
class Draw:
    """A checker's recipe, and motions for it.

    Attributes:
        family: The row of the table.
        recipe: Robot and scene.
        motions: See `Motions`.
        tolerance: Asked for, m.
    """

    family: str
    recipe: Recipe
    motions: Motions
    tolerance: float


# The family of motions whose planar and floating joints go straight and turn by slerp, as OMPL moves them.
STRAIGHT = "straight"

FAMILIES: dict[str, Wishes] = {
    "tree": Wishes(),
    "chain": Wishes(branching=0.0, joints=(3, 8)),
    "turns": Wishes((*TURNS, *CONTINUOUS), (1.0,) * 8, (1, 7), 0.1),
    "placed": Wishes(("planar", "floating", "ball", "revolute"), (1.0, 1.0, 0.5, 1.0), (2, 5), 0.0, 0.3),
    "mimic": Wishes(
        (*CONTINUOUS, "revolute", "prismatic", "prismatic z"), (1.0,) * 4 + (1.0,) * 3, (3, 6), 0.6, 0.5, 0.0
    ),
    STRAIGHT: Wishes(
        ("planar", "floating", "ball", "revolute", "prismatic"), (1.5, 2.0, 0.5, 1.0, 0.5), (1, 4), 0.0, 0.3
    ),
    "off unit": Wishes(
        ("floating", "ball", "planar", *CONTINUOUS), (9.0, 1.0, 1.0, *[0.2] * 4), (3, 25), 0.0, 0.05, 0.8
    ),
    "far ends": Wishes((*CONTINUOUS, "revolute"), (1.0,) * 5, (1, 4), 0.1, 0.3, 0.0),
}
SHIPPED = ("panda", "ur5", "kinova", "xarm7", "ur10", "ur3", "go2", "tiago", "pr2", "talos", "baxter", "g1")
SCENES = ("", "", "bookshelf", "cage", "table", "bin", "kitchen")


def tree_draw(family: str, rng: np.random.Generator) -> Draw:
    """A random tree among contacts."""
    while True:
        recipe = random_tree(FAMILIES[family], rng)
        recipe["path"] = "slerp" if family == STRAIGHT else "screw"
        robot = robot_of(recipe)
        if robot.nq > 0:
            break
    add_bodies(recipe, rng, family == "off unit")
    stage = Stage(recipe, robot, tangents_of(robot, recipe["path"]), SHARP if family == "off unit" else USUAL)
    probes = [_probe(stage, state_of(stage, family, rng), rng) for _ in range(int(rng.integers(*_PROBES)))]
    obstacles = [_obstacle(stage, state_of(stage, family, rng), rng) for _ in range(int(rng.integers(*_OBSTACLES)))]
    choose_pairs(stage, [*probes, *obstacles], rng)
    probes = [aim for aim, pair in zip(probes, recipe["pairs"], strict=False) if pair]
    obstacles = [aim for aim, body in zip(obstacles, recipe["obstacles"], strict=True) if body["shape"]]
    tidy(recipe, rng)
    if rng.random() < _PADDED:
        recipe["padding"] = float(10.0 ** rng.uniform(-4, -2))
    return _with_motions(family, Stage(recipe, robot_of(recipe), stage.tangents), [*probes, *obstacles], rng)


def _with_motions(family: str, stage: Stage, aims: list[Aim], rng: np.random.Generator) -> Draw:
    size = OFF_UNIT_MOTIONS if family == "off unit" else MOTIONS
    each = size * _CANDIDATES // max(len(aims), 1) + 1
    if not aims:  # nothing that would not hide everything else: motions of an idle robot
        state = state_of(stage, family, rng)
        aims = [Aim(state, 0, -1, np.zeros(3), np.array([0.0, 0.0, 1.0]), False)]
    motions = joined([moved(family, stage, aim, each, rng) for aim in aims])
    checker = space_checker(stage.recipe, stage.robot)
    tolerance = float(rng.choice(_TOLERANCES.get(family, _USUAL_TOLERANCES)))
    return Draw(family, stage.recipe, sharpest(checker, motions, size, rng), tolerance)


def shipped_draw(family: str, rng: np.random.Generator) -> Draw:
    """A shipped robot in a shipped scene, or alone, among contacts."""
    recipe = tree_recipe()
    recipe["shipped"], recipe["scene"] = str(rng.choice(SHIPPED)), str(rng.choice(SCENES))
    recipe["whole"] = recipe["shipped"] == "go2"
    if recipe["whole"]:
        recipe["scene"] = ""
    robot = shipped_robot(recipe["shipped"], recipe["whole"])
    stage = Stage(recipe, robot, tangents_of(robot))
    valid = _valid_states(stage, rng)
    aims = [_obstacle(stage, q, rng) for q in valid]
    checker = space_checker(recipe, robot)
    hiding = {max(checker.pairs[row]) - len(robot.bodies) for row in _mostly_touching(stage, checker, aims, rng)}
    first = len(checker.scene.bodies) - len(aims)
    kept = [k for k in range(len(aims)) if first + k not in hiding]
    recipe["obstacles"] = [recipe["obstacles"][k] for k in kept]
    return _with_motions(family, stage, [aims[k] for k in kept], rng)


@lru_cache
def shipped_robot(name: str, whole: bool, geometry: GeometryKind = "hull") -> Robot:
    """A shipped robot, built once."""
    recipe = tree_recipe()
    recipe["shipped"], recipe["whole"], recipe["geometry"] = name, whole, geometry
    return robot_of(recipe)


def _valid_states(stage: Stage, rng: np.random.Generator) -> Floats:
    """States that collide with nothing yet, or any if there is none: a few."""
    q = random_states(stage.robot, _PROBED_STATES, rng)
    free = q[space_checker(stage.recipe, stage.robot).check_states(q)]
    return (free if len(free) else q)[: int(rng.integers(*_OBSTACLES))]


def add_bodies(recipe: SpaceRecipe, rng: np.random.Generator, sparse: bool) -> None:
    """Bodies of the base and the links; the last link has one, and alone if they are to be sparse: a large one."""
    if sparse:
        body = _body(recipe["joints"][-1]["name"] + " link", rng)
        recipe["bodies"].append({**body, "shape": random_shape(rng, large=True)})
        return
    links = [joint["name"] + " link" for joint in recipe["joints"]]
    if rng.random() < _BASE_HAS_A_BODY:
        recipe["bodies"].append(_body("base", rng))
    for link in links:
        if rng.random() < _LINK_HAS_A_BODY or link == links[-1]:
            recipe["bodies"].append(_body(link, rng))
            if rng.random() < _SECOND_BODY:
                recipe["bodies"].append(_body(link, rng))


def _body(link: str, rng: np.random.Generator) -> BodyRecipe:
    chance = rng.random()
    reach = next(reach for most, reach in _BODY_OFFSETS if chance <= most)
    return {"link": link, "shape": random_shape(rng), "pose": random_pose(reach, rng)}


def _moving_bodies(stage: Stage) -> list[int]:
    """Bodies on links that some joint of the group moves."""
    q = random_states(stage.robot, 2, np.random.default_rng(0))
    poses = stage.robot.link_poses(q)
    moves = np.abs(poses[0] - poses[1]).max(axis=(1, 2)) > 0
    return [k for k, body in enumerate(_bodies(stage)) if moves[stage.robot.link_index(body["link"])]]


def _bodies(stage: Stage) -> list[BodyRecipe]:
    if not stage.recipe["shipped"]:
        return stage.recipe["bodies"]
    return [
        {"link": str(body.link), "shape": [], "pose": body.pose.tolist()}
        for body in stage.robot.bodies
        if body.link is not None
    ]


def _touched(stage: Stage, k: int, poses: Floats, shape: list[object], rng: np.random.Generator) -> tuple[int, Contact]:
    """The link of a body, and a shape laid upon it."""
    body = _bodies(stage)[k]
    link = stage.robot.link_index(body["link"])
    shipped = stage.recipe["shipped"]
    extent = extent_of(stage.robot.bodies[k].shape if shipped else shape_of(body["shape"]))
    return link, random_contact(extent, poses[link] @ np.array(body["pose"]), shape, rng, stage.closeness)


def _obstacle(stage: Stage, state: Floats, rng: np.random.Generator) -> Aim:
    """Adds an obstacle in contact at a state with a body that moves, if one does."""
    moving = _moving_bodies(stage)
    body = moving[int(rng.integers(len(moving)))] if moving else 0
    shape = random_shape(rng)
    poses = stage.robot.link_poses(state)
    link, contact = _touched(stage, body, poses, shape, rng)
    stage.recipe["obstacles"].append({"link": "", "shape": shape, "pose": _matrix(contact.pose)})
    return Aim(state, link, -1, contact.point, contact.normal, contact.touches and bool(moving))


def _probe(stage: Stage, state: Floats, rng: np.random.Generator) -> Aim:
    """Adds a body to a link, in contact with a body of another link at a state."""
    k = int(rng.integers(len(stage.recipe["bodies"])))
    links = [name for name in stage.robot.link_names if name != stage.recipe["bodies"][k]["link"]]
    carrier = str(rng.choice(links))
    shape = random_shape(rng)
    poses = stage.robot.link_poses(state)
    link, contact = _touched(stage, k, poses, shape, rng)
    other = stage.robot.link_index(carrier)
    pose = contact.pose_on(poses[other])
    stage.recipe["pairs"].append([k, len(stage.recipe["bodies"])])
    stage.recipe["bodies"].append({"link": carrier, "shape": shape, "pose": _matrix(pose)})
    return Aim(state, link, other, contact.point, contact.normal, contact.touches)


def _matrix(pose: Floats) -> Matrix:
    return [[float(x) for x in row] for row in pose]


def choose_pairs(stage: Stage, aims: list[Aim], rng: np.random.Generator) -> None:
    """Self pairs: those of the probes, and all others.

    What mostly touches, at random states and near those of the aims, would hide everything else: such pairs become
    empty, and the shapes of such obstacles.
    """
    recipe = stage.recipe
    bodies, probed = recipe["bodies"], {tuple(pair) for pair in recipe["pairs"]}
    recipe["pairs"] += [
        [a, b]
        for b in range(len(bodies))
        for a in range(b)
        if bodies[a]["link"] != bodies[b]["link"] and (a, b) not in probed
    ]
    checker = space_checker(recipe)
    for row in _mostly_touching(stage, checker, aims, rng):
        a, b = checker.pairs[row].tolist()
        if max(a, b) >= len(bodies):
            recipe["obstacles"][max(a, b) - len(bodies)]["shape"] = []
        else:
            recipe["pairs"] = [[] if sorted(pair) == sorted((a, b)) else pair for pair in recipe["pairs"]]


def _mostly_touching(stage: Stage, checker: Checker, aims: list[Aim], rng: np.random.Generator) -> list[int]:
    """Rows of the checker's pairs that mostly collide, at random states and near those of the aims."""
    near = [stage.tangents.moved(aim.state, rng.normal(size=(_NEAR_STATES, stage.tangents.dimension))) for aim in aims]
    states = np.vstack([random_states(stage.robot, _PROBED_STATES, rng), *near])
    return np.flatnonzero(checker.colliding_pairs(states).mean(axis=0) > _MOSTLY_TOUCHING).tolist()


def tidy(recipe: SpaceRecipe, rng: np.random.Generator) -> None:
    """Drops what became empty; either body of a pair may come first."""
    recipe["pairs"] = [pair[::-1] if rng.random() < _SWAPPED else pair for pair in recipe["pairs"] if pair]
    recipe["obstacles"] = [body for body in recipe["obstacles"] if body["shape"]]


def sharpest(checker: Any, motions: Motions, n: int, rng: np.random.Generator) -> Motions:
    """So many of the motions: first those whose ends are free, but some as they come."""
    return motions.of(sharpest_rows(checker.check_states(motions.q0) & checker.check_states(motions.q1), n, rng))


def sharpest_rows(ends_free: Bools, n: int, rng: np.random.Generator) -> Ints64:
    """So many rows (n,): first those whose ends are free, but some as they come."""
    rank = rng.random(len(ends_free))
    rank[~ends_free] += 1
    some = rng.random(len(rank)) < _AS_THEY_COME
    rank[some] = rng.random(int(some.sum()))
    return rng.permutation(np.argsort(rank, kind="stable")[:n])
