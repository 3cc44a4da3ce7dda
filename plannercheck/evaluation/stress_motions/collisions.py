"""Checks that accepted motions collide nowhere: at their ends, in contacts by construction, at sampled states.

In: a draw with the answers to its motions. Out: faults.
"""

from __future__ import annotations

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct, grouped
from plannercheck.evaluation.stress_motions.draws import Draw
from plannercheck.evaluation.stress_motions.outcomes import COLLISION, FREE, Answers, Judged, said, states_on, valid
from plannercheck.evaluation.stress_motions.recipes import is_of_solids
from plannercheck.evaluation.stress_motions.subjects import Subject

# States of an accepted motion: evenly spread with a random start, and at both sides of the contact so far off.
_SPREAD = 16
_ASIDE = np.concatenate([-(10.0 ** -np.arange(1.0, 10.0, 2)), [0.0], 10.0 ** -np.arange(1.0, 10.0, 2)])
_BEYOND = 1e3  # any tube, rad and m
# Of so many accepted motions of a draw the least clearance is searched for: states at first, then rounds of so many
# within the two steps around the least.
_SEARCHED_OF_SOLIDS = 1
_SEARCHED, _FIRST_STATES, _ROUNDS, _STATES = 8, 17, 4, 9


def ends_and_contacts(draw: Draw, used: Subject, answers: Answers, judged: Judged, rng: np.random.Generator) -> None:
    """Both ends as they were given, and the state of the contact, alone and in company."""
    motions, free = draw.motions, np.flatnonzero(answers == FREE)
    for row in free[motions.touching[free]].tolist():
        judged.add(COLLISION, row, f"it touches by construction at {motions.at[row]!r}")
    for name, q in zip(("start", "end"), used.ends(motions.q0, motions.q1), strict=True):
        for row in free[~valid(used, q[free])].tolist() if len(free) else []:
            judged.add(COLLISION, row, f"its {name} collides")
    first = grouped(motions.through).first
    known = first[motions.touching[first]]
    if not len(known):
        return
    in_a_batch = said(used, motions.through[known])
    for row, answer in zip(known.tolist(), in_a_batch.tolist(), strict=True):
        if answer == 1 or said(used, motions.through[row][None])[0] == 1:
            judged.add(COLLISION, row, "a state in contact by construction is called valid")


def sampled(draw: Draw, used: Subject, answers: Answers, judged: Judged, rng: np.random.Generator) -> None:
    """States all along, and close to the contact; of a curve with a tube corners of it."""
    free, motions = np.flatnonzero(answers == FREE), draw.motions
    states = [states_on(draw, used, row, _parameters(motions.at[row], rng)) for row in free.tolist()]
    ways = [rng.choice([-_BEYOND, _BEYOND], q.shape) for q in states]
    tubes = motions.q1[free]
    states = [used.nearest(q, q + way, q1) for q, way, q1 in zip(states, ways, tubes, strict=True)]
    if not states:
        return
    judged.counts["sampled states"] += sum(len(part) for part in states)
    owners = np.repeat(free, [len(part) for part in states])
    colliding = ~valid(used, np.vstack(states))
    for row in distinct(owners[colliding]).tolist():
        judged.add(COLLISION, row, "a state on it collides")


def _parameters(at: float, rng: np.random.Generator) -> Floats:
    spread = (np.arange(_SPREAD) + rng.random()) / _SPREAD
    return np.asarray(np.clip(np.concatenate([spread, at + _ASIDE, [0.0, 1.0]]), 0, 1))


def least_clearances(draw: Draw, used: Subject, answers: Answers, judged: Judged, rng: np.random.Generator) -> None:
    """A search for the state of least clearance, which must not collide."""
    free = np.flatnonzero(answers == FREE)
    chosen = rng.permutation(free)[: _SEARCHED_OF_SOLIDS if is_of_solids(draw.recipe) else _SEARCHED]
    low, high = np.zeros(len(chosen)), np.ones(len(chosen))
    for step in range(_ROUNDS if len(chosen) else 0):
        k = _STATES if step else _FIRST_STATES
        parameters = low[:, None] + (high - low)[:, None] * np.linspace(0, 1, k)
        states = [states_on(draw, used, row, t) for row, t in zip(chosen.tolist(), parameters, strict=True)]
        judged.counts["sampled states"] += len(chosen) * k
        clearances = used.clearances(np.vstack(states)).reshape(len(chosen), k)
        found = np.argmin(clearances, axis=1)
        for row in chosen[(clearances <= used.padding).any(axis=1)].tolist():
            judged.add(COLLISION, row, "the state of least clearance collides")
        rows = np.arange(len(chosen))
        low, high = parameters[rows, np.maximum(found - 1, 0)], parameters[rows, np.minimum(found + 1, k - 1)]
