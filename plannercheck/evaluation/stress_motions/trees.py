"""Random trees of joints: all kinds, in every position, as roots and behind others, with mimics, long arms and slides.

In: a random generator, the properties of the tree. Out: the joints of a `SpaceRecipe`, its group and held values;
random configurations of its robot.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.evaluation.stress.contact_poses import random_directions, turns_onto
from plannercheck.evaluation.stress_motions.curve_numbers import unit_columns
from plannercheck.evaluation.stress_motions.recipes import JointRecipe, Matrix, SpaceRecipe, tree_recipe
from plannercheck.robots.robot import Robot

TURNS = ("revolute x", "revolute y", "revolute z", "revolute")
CONTINUOUS = ("continuous x", "continuous y", "continuous z", "continuous")
SLIDES = ("prismatic x", "prismatic z", "prismatic")
OTHERS = ("planar", "ball", "floating")
# Numbers that joints take, and how they are bounded: None for unit vectors.
_PLACED = {"planar": (2, 2), "ball": (0, 4), "floating": (3, 4)}

# Multipliers of followers: halves, turns the other way, gears, and next to nothing.
MULTIPLIERS = (0.5, -1.0, 2.0, -0.5, 1.0, 1.5, 3.0, 0.1, -7.0)

# Lengths of links, m; one tree in six has long ones.
_USUAL_LENGTH, _LONG_LENGTH = 0.4, 10.0
# Planar and floating joints are displaced by this much, m, slides by as much or, one in six, by the longer way.
SHIFT, _SHORT_SLIDE, _LONG_SLIDE = 5.0, 0.5, 100.0
_RARELY, _OFTEN = 1 / 6, 0.5


@dataclass(frozen=True)
class Wishes:
    """The wanted properties of a tree.

    Attributes:
        kinds: Joints to choose from, the later ones given by weight.
        weights: Weights of the kinds.
        joints: Least and largest number of joints.
        mimics: The part of the joints of one number that follow another.
        branching: The probability that a joint hangs not on the one before but on any.
        whole: The probability of a robot in Pinocchio's own numbers, without a group.
    """

    kinds: tuple[str, ...] = (*TURNS, *CONTINUOUS, *SLIDES, *OTHERS)
    weights: tuple[float, ...] = (*[1.0] * 4, *[1.0] * 4, *[0.7] * 3, *[1.2] * 3)
    joints: tuple[int, int] = (2, 7)
    mimics: float = 0.15
    branching: float = 0.4
    whole: float = 0.25


def random_tree(wishes: Wishes, rng: np.random.Generator) -> SpaceRecipe:
    """A recipe with joints, a group and held values, but no bodies."""
    recipe = tree_recipe()
    count = int(rng.integers(wishes.joints[0], wishes.joints[1] + 1))
    length = _LONG_LENGTH if rng.random() < _RARELY else _USUAL_LENGTH
    weights = np.array(wishes.weights) / sum(wishes.weights)
    for k in range(count):
        parent = k - 1 if rng.random() >= wishes.branching else int(rng.integers(-1, k))
        kind = str(rng.choice(wishes.kinds, p=weights))
        recipe["joints"].append(_joint(f"j{k}", kind, parent, length, rng))
    _let_follow(recipe, wishes.mimics, rng)
    if rng.random() >= wishes.whole or wishes.mimics == 1:
        _choose_group(recipe, rng)
    return recipe


def _joint(name: str, kind: str, parent: int, length: float, rng: np.random.Generator) -> JointRecipe:
    axis = random_directions(1, rng)[0]
    return {
        "name": name,
        "kind": kind,
        "parent": parent,
        "placement": random_pose(length, rng),
        "axis": (axis / np.linalg.norm(axis)).tolist(),
        "pitch": float(rng.uniform(-0.3, 0.3)),
        "limits": _limits(kind, rng),
        "link": random_pose(0.1, rng) if rng.random() < _RARELY else np.eye(4).tolist(),
        "mimic": None,
    }


def random_pose(reach: float, rng: np.random.Generator) -> Matrix:
    """A pose (4, 4) up to `reach` m away: turned at random, or not at all."""
    pose = np.eye(4)
    if rng.random() < _OFTEN:
        pose[:3, :3] = turns_onto(random_directions(1, rng), random_directions(1, rng), rng)[0]
    pose[:3, 3] = random_directions(1, rng)[0] * reach * rng.random()
    return [[float(x) for x in row] for row in pose]


def _limits(kind: str, rng: np.random.Generator) -> list[float]:
    """Least numbers, then largest."""
    if kind in _PLACED:
        lengths, units = _PLACED[kind]
        # Two numbers beyond all doubles that Pinocchio takes for limits mean that there is none.
        most = 1e301 if rng.random() < _OFTEN else SHIFT
        high = [most] * lengths + [1.0] * units
        return [-x for x in high] + high
    if kind in CONTINUOUS:
        return [-1.01, -1.01, 1.01, 1.01]
    if kind in SLIDES:
        most = _LONG_SLIDE if rng.random() < _RARELY else _SHORT_SLIDE
        return [-most, most]
    return [-float(rng.uniform(0.5, 6)), float(rng.uniform(0.5, 6))]


def _let_follow(recipe: SpaceRecipe, part: float, rng: np.random.Generator) -> None:
    """Lets joints of one number follow earlier ones; followers of followers included."""
    single = [joint for joint in recipe["joints"] if joint["kind"] not in _PLACED]
    for k, joint in enumerate(single[1:], 1):
        if rng.random() < part:
            leader = single[int(rng.integers(k))]["name"]
            offset = float(rng.choice([0.0, rng.uniform(-2, 2)]))
            joint["mimic"] = [leader, float(rng.choice(MULTIPLIERS)), offset]


def _choose_group(recipe: SpaceRecipe, rng: np.random.Generator) -> None:
    """A group of most joints that follow none; the others are held somewhere."""
    free = [joint for joint in recipe["joints"] if joint["mimic"] is None]
    held = [joint for joint in free if rng.random() < _RARELY][: len(free) - 1]
    group = [joint["name"] for joint in free if joint not in held]
    recipe["group"] = [str(name) for name in rng.permutation(group)]
    for joint in held:
        recipe["held"][joint["name"]] = _held_value(joint, rng)


def _held_value(joint: JointRecipe, rng: np.random.Generator) -> list[float]:
    kind = joint["kind"]
    if kind in CONTINUOUS:
        return [float(rng.uniform(-np.pi, np.pi))]
    if kind not in _PLACED:
        low, high = joint["limits"]
        return [float(rng.uniform(low, high))]
    lengths, units = _PLACED[kind]
    unit = rng.normal(size=units)
    return [*rng.uniform(-SHIFT, SHIFT, lengths).tolist(), *(unit / np.linalg.norm(unit)).tolist()]


def random_states(robot: Robot, n: int, rng: np.random.Generator) -> Floats:
    """Configurations (n, nq) within the limits; lengths without limits up to SHIFT."""
    q = robot.random_configurations(n, rng)
    unlimited = np.isinf(robot.lower) | np.isinf(robot.upper)
    roles = robot.configuration_map.roles_of_columns()
    lengths = unlimited & ~unit_columns(robot) & (roles == 0)
    q[:, lengths] *= SHIFT
    return q
