"""States and ends of families of the motion stress: far ends of continuous joints, unit vectors of inexact length.

In: a robot among contacts, an aim. Out: states, and motions through them by the rules of the family.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.stress_motions.aims import Aim, Motions, through
from plannercheck.evaluation.stress_motions.contacts import USUAL, Closeness
from plannercheck.evaluation.stress_motions.recipes import SpaceRecipe
from plannercheck.evaluation.stress_motions.tangents import Tangents
from plannercheck.evaluation.stress_motions.trees import random_states
from plannercheck.robots.robot import Robot

# Off-unit lengths go to this part of what is accepted.
_OFF_UNIT, _ONE_WAY = 1.99e-7, 0.8
# A chain of many such joints shares what one may be off: the largest of these parts is taken that is accepted.
_OFF_PARTS = (*np.geomspace(1.0, 1e-3, 40).tolist(), 0.0)
# Far ends of continuous joints: whole turns of up to this power of ten.
# No number of a configuration may be larger than 1e15 (`configurations.LARGEST_VALUE`); motions go a little on.
_LARGEST = 9e14
_FARTHEST, _NEAR_ZERO, _LAST = 15.0, 0.7, 0.5


@dataclass(frozen=True, eq=False)
class Stage:
    """A robot without contacts yet."""

    recipe: SpaceRecipe
    robot: Robot
    tangents: Tangents
    closeness: Closeness = USUAL


def state_of(stage: Stage, family: str, rng: np.random.Generator) -> Floats:
    """A random state; with continuous joints far away in the family that is about them."""
    (q,) = random_states(stage.robot, 1, rng)
    if family == "far ends":
        turns = np.isinf(stage.robot.lower) & np.isinf(stage.robot.upper)
        q[turns] += 2 * np.pi * np.round(rng.choice([-1, 1]) * 10.0 ** rng.uniform(0, _FARTHEST, turns.sum()))
        q[turns] = np.clip(q[turns], -_LARGEST, _LARGEST)
    state: Floats = _off_unit(stage, q[None], rng)[0] if family == "off unit" else q
    return state


def moved(family: str, stage: Stage, aim: Aim, n: int, rng: np.random.Generator) -> Motions:
    """Motions through an aim, as the family has them."""
    motions = through(stage.robot, stage.tangents, aim, n, rng)
    change = _CHANGES.get(family)
    return motions if change is None else change(stage, motions, rng)


def _with_far_ends(stage: Stage, motions: Motions, rng: np.random.Generator) -> Motions:
    """The aim's far state is one end to the bit; the other is near it, or near zero, whole turns away."""
    other, last = _one_end(motions, rng)
    turns = np.isinf(stage.robot.lower) & np.isinf(stage.robot.upper)
    near_zero = (rng.random(len(other)) < _NEAR_ZERO)[:, None] & turns
    other = np.where(near_zero, other - 2 * np.pi * np.round(other / (2 * np.pi)), other)
    return _ending(motions, other, last)


def _with_off_unit_ends(stage: Stage, motions: Motions, rng: np.random.Generator) -> Motions:
    """The aim's state, as far off as is accepted, is one end to the bit; the other is off as well."""
    other, last = _one_end(motions, rng)
    return _ending(motions, _off_unit(stage, other, rng), last)


def _one_end(motions: Motions, rng: np.random.Generator) -> tuple[Floats, Bools]:
    """One end (n, nq) of each motion, and whether (n,) the other one is the last."""
    last = rng.random(len(motions.at)) < _LAST
    return np.where(last[:, None], motions.q0, motions.q1), last


def _ending(motions: Motions, other: Floats, last: Bools) -> Motions:
    """Motions between other ends (n, nq) and the states that they pass, which come last or first."""
    q0 = np.where(last[:, None], other, motions.through)
    q1 = np.where(last[:, None], motions.through, other)
    return Motions(q0, q1, np.where(last, 1.0, 0.0), motions.through, motions.touching)


def _off_unit(stage: Stage, q: Floats, rng: np.random.Generator) -> Floats:
    """Configurations (n, nq) whose quaternions, cosines and sines are as far off length 1 as is accepted."""
    out, sign = q.copy(), rng.choice([-1.0, 1.0], len(q))
    units = stage.robot.configuration_map.units
    offs = [
        _OFF_UNIT * np.where(rng.random(len(q)) < _ONE_WAY, sign, rng.choice([-1.0, 1.0, 0.0], len(q))) for _ in units
    ]
    for row in range(len(q)):
        for part in _OFF_PARTS:
            for (start, stop), off in zip(units, offs, strict=True):
                own = q[row, start:stop]
                out[row, start:stop] = own * ((1 + part * off[row]) / np.linalg.norm(own))
            if _is_accepted(stage.robot, out[row]):
                break
    return out


def _is_accepted(robot: Robot, q: Floats) -> bool:
    try:
        robot.check_configurations(q)
    except PlannercheckError:
        return False
    return True


_CHANGES: dict[str, Callable[[Stage, Motions, np.random.Generator], Motions]] = {
    "far ends": _with_far_ends,
    "off unit": _with_off_unit_ends,
}
