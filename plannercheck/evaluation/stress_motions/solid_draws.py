"""Random draws of motions of solids: arms with their meshes as they are, and free bodies in concave puzzles.

In: a family's name, a random generator. Out: a `Draw`. No body is added: the robot touches itself and its scene.
Between a valid state and a colliding state, a search finds a state that has just begun to collide, and motions pass
through it, across the contact and along it. The others are random motions from valid states.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np

from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.motion_paths import MotionPath
from plannercheck.evaluation.stress_motions.aims import Aim, Motions, joined, lengths, through
from plannercheck.evaluation.stress_motions.draws import Draw, sharpest, shipped_robot
from plannercheck.evaluation.stress_motions.mesh_states import MeshStates
from plannercheck.evaluation.stress_motions.recipes import SpaceRecipe, space_checker, tree_recipe
from plannercheck.evaluation.stress_motions.tangents import Tangents, tangents_of
from plannercheck.evaluation.stress_motions.trees import random_states
from plannercheck.motions.certifier import MotionCertifier
from plannercheck.motions.checker import Checker

# Motions of a draw: a checker of solids takes longer to build than others.
SOLID_MOTIONS = 400
TOLERANCES = (1e-4, 1e-4, 1e-3)
# Contacts of a draw, and the tries to find one; motions made through each, of which the sharpest are taken.
_AIMS, _TRIES, _CANDIDATES = 12, 40, 50
# Of a draw so many motions are random ones.
_PLAIN = 0.4
# States of which the valid ones are starts.
_STARTS = 400
# Rounds of a search for the first state that collides, and the steps of each.
_ROUNDS, _STEPS = 4, 65
# A state that has just begun to collide is so far behind the last free one, as a part of the motion between them.
_BEHIND = 1e-10
# So far ahead of it coal's distances still tell where the bodies will meet.
_AHEAD = 1e-5
# Where a free body starts: about its puzzle's ends, m and rad.
_NEAR_ENDS = (0.3, 1.0)


@dataclass(frozen=True)
class Setting:
    """A robot in a scene.

    Attributes:
        robot: A shipped robot, or a file of the shipped scenes' folder.
        scene: A file of that folder; empty for none.
        paths: How it may move.
    """

    robot: str
    scene: str = ""
    paths: tuple[MotionPath, ...] = ("screw",)


SETTINGS = {
    "ur10": Setting("ur10"),
    "ur3": Setting("ur3"),
    "ur5": Setting("ur5"),
    "pr2": Setting("pr2"),
    "panda in pipe": Setting("panda", "puzzles/pipe.yaml"),
    "key in lock": Setting("puzzles/key.yaml", "puzzles/lock.yaml", ("screw", "slerp")),
    "hook in ring": Setting("puzzles/hook.yaml", "puzzles/ring.yaml", ("screw", "slerp")),
}


@dataclass(frozen=True, eq=False)
class SolidStage:
    """A setting with its checker and its tangents."""

    recipe: SpaceRecipe
    checker: Checker
    tangents: Tangents

    @property
    def near(self) -> Floats:
        """The ends (k, nq) of the scene's own problem; none for no scene."""
        robot, scene = self.checker.robot, self.checker.scene
        return np.stack([scene.start(robot.name), scene.goal(robot.name)]) if self.recipe["scene"] else np.empty(0)


@lru_cache
def stage_of(setting: str, path: MotionPath) -> SolidStage:
    """A setting, built once."""
    recipe = tree_recipe()
    recipe["shipped"], recipe["scene"] = SETTINGS[setting].robot, SETTINGS[setting].scene
    recipe["geometry"], recipe["path"] = "solid", path
    robot = shipped_robot(recipe["shipped"], False, "solid")
    return SolidStage(recipe, space_checker(recipe, robot), tangents_of(robot, path))


def solid_draw(family: str, rng: np.random.Generator) -> Draw:
    """Motions of solids in a setting, the family's name."""
    stage = stage_of(family, rng.choice(np.array(SETTINGS[family].paths)).item())
    meshes = MeshStates(stage.checker)
    aims = [aim for aim in (_aim(stage, meshes, rng) for _ in range(_AIMS)) if aim is not None]
    plain = int(_PLAIN * SOLID_MOTIONS) if aims else SOLID_MOTIONS
    made = [through(stage.checker.robot, stage.tangents, aim, _CANDIDATES, rng) for aim in aims]
    parts = [_plain(stage, plain, rng)]
    parts += [sharpest(stage.checker, joined(made), SOLID_MOTIONS - plain, rng)] if aims else []
    return Draw(family, stage.recipe, joined(parts), float(rng.choice(TOLERANCES)))


def free_states(stage: SolidStage, rng: np.random.Generator) -> Floats:
    """Some valid states (k, nq), with a scene mostly near the ends of its problem."""
    q = _states(stage, _STARTS, rng)
    return q[stage.checker.check_states(q)]


def _states(stage: SolidStage, n: int, rng: np.random.Generator) -> Floats:
    if not len(stage.near):
        return random_states(stage.checker.robot, n, rng)
    turns, slides = _NEAR_ENDS[1], _NEAR_ENDS[0]
    way = rng.normal(size=(n, stage.tangents.dimension)) * np.where(stage.tangents.slides, slides, turns)
    way *= rng.random((n, 1))
    rows = rng.integers(0, len(stage.near), n)
    return np.concatenate([stage.tangents.moved(stage.near[k], way[rows == k]) for k in range(len(stage.near))])


def _plain(stage: SolidStage, n: int, rng: np.random.Generator) -> Motions:
    """Random motions from valid states."""
    states = free_states(stage, rng)
    starts = states[rng.integers(0, len(states), n)]
    way = rng.normal(size=(n, stage.tangents.dimension))
    way *= (np.minimum(lengths(n, rng), 1.0) / np.linalg.norm(way, axis=1))[:, None]
    ends = np.concatenate([stage.tangents.moved(q, step[None]) for q, step in zip(starts, way, strict=True)])
    return Motions(starts, ends, np.zeros(n), starts, np.zeros(n, dtype=bool))


def _aim(stage: SolidStage, meshes: MeshStates, rng: np.random.Generator) -> Aim | None:
    """A state that has just begun to collide, and where; None if no try finds one."""
    checker = stage.checker
    certifier = checker.certifier_of(stage.tangents.path)
    for _ in range(_TRIES):
        q = _states(stage, _STEPS, rng)
        valid = checker.check_states(q)
        if valid.all() or not valid.any():
            continue
        (start,), (end,), _ = checker._motion_ends(q[valid][:1], q[~valid][:1])
        free, hit = _first_collision(partial(_valid_at, checker, certifier, start, end))
        before, state = certifier.states(start, end, np.array([max(0.0, free - _AHEAD), hit]))
        if checker.is_valid(state):  # judged by itself, rounding may say otherwise
            continue
        found = meshes.contact(state, before)
        if found is not None:
            return Aim(state, *found, touches=True)
    return None


def _valid_at(checker: Checker, certifier: MotionCertifier, start: Floats, end: Floats, t: Floats) -> Bools:
    return checker.check_states(certifier.states(start, end, t))


def _first_collision(valid: Callable[[Floats], Bools]) -> tuple[float, float]:
    """The last parameter found free, and one behind it that collides."""
    low, high = 0.0, 1.0
    for _ in range(_ROUNDS):
        t = np.linspace(low, high, _STEPS)
        first = int(np.argmax(~valid(t)))
        low, high = (t[first - 1], t[first]) if first else (t[0], t[0])
    return float(low), min(1.0, float(high) + _BEHIND)
