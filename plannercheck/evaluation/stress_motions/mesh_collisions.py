"""Checks answers to motions of solids by coal's meshes: free motions meet nothing, refused ones come near something.

In: a draw with the answers to its motions. Out: faults.
"""

from __future__ import annotations

import numpy as np

from plannercheck.bodies.solid_certificates import Enclosure
from plannercheck.common.array_types import Floats
from plannercheck.evaluation.stress_motions.draws import Draw
from plannercheck.evaluation.stress_motions.mesh_states import MeshStates
from plannercheck.evaluation.stress_motions.outcomes import (
    COLLISION,
    FREE,
    REFUSED,
    UNREASONED,
    Answers,
    Judged,
    states_on,
)
from plannercheck.evaluation.stress_motions.subjects import Subject

# States of an accepted motion: evenly spread with a random start, and so far off at both sides of the contact.
_SPREAD = 48
_ASIDE = np.concatenate([-(10.0 ** -np.arange(1.5, 10.0)), [0.0], 10.0 ** -np.arange(1.5, 10.0)])
# Refused motions of a draw that coal is asked about.
_REFUSED = 12
# What coal's distances and Pinocchio's poses may differ by, m.
_SLACK = 1e-6


def by_meshes(draw: Draw, used: Subject, answers: Answers, judged: Judged, rng: np.random.Generator) -> None:
    """Judges all accepted motions, and some refused ones."""
    meshes = MeshStates(used.checker)
    for row in np.flatnonzero(answers == FREE).tolist():
        _accepted(draw, meshes, row, judged, rng)
    for row in rng.permutation(np.flatnonzero(answers == REFUSED))[:_REFUSED].tolist():
        _refused(draw, used, meshes, row, judged)


def _accepted(draw: Draw, meshes: MeshStates, row: int, judged: Judged, rng: np.random.Generator) -> None:
    motions, recipe = draw.motions, draw.recipe
    assert recipe["kind"] == "space"
    t = _parameters(motions.at[row], rng)
    colliding = meshes.collide(meshes.between(motions.q0[row], motions.q1[row], t, recipe["path"]))
    judged.counts["mesh states"] += len(t)
    if colliding.any():
        judged.add(COLLISION, row, f"coal's surfaces meet at {t[colliding][0]!r} of it")


def _parameters(at: float, rng: np.random.Generator) -> Floats:
    spread = (np.arange(_SPREAD) + rng.random()) / _SPREAD
    return np.asarray(np.clip(np.concatenate([spread, at + _ASIDE, [0.0, 1.0]]), 0, 1))


def _refused(draw: Draw, used: Subject, meshes: MeshStates, row: int, judged: Judged) -> None:
    """The state that is named, if it is within the tolerance by distances of ours, has to be by coal's."""
    q0, q1 = draw.motions.q0[row], draw.motions.q1[row]
    near = used.motion_result(q0, q1, draw.tolerance).near
    state = states_on(draw, used, row, np.array([min(max(near, 0.0), 1.0)]))
    if used.clearances(state)[0] > draw.tolerance:  # reasons.py looks for another one
        return
    judged.counts["refused by meshes"] += 1
    if meshes.come_near(used.robot.expand(state)[0], draw.tolerance + _SLACK):
        return
    certificates = [pair.certificate for pair in used.checker.explain(state[0]).collisions]
    if not any(isinstance(each, Enclosure) and each.verify() for each in certificates):
        judged.add(UNREASONED, row, "by coal no surfaces are within the tolerance at the state that is named")
