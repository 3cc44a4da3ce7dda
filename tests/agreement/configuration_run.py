"""Configurations of a robot in a scene held against FCL, with exact arithmetic as the judge.

In: a checker, how many configurations, a seed. Out: the report of the comparison, and FCL's errors on wide
bodies with a clear gap. Half of the configurations are random within the limits; the others lie so close to
the border between free and colliding that halving can't bring them closer.
"""

import numpy as np
from pair_run import is_clear, kept_case

import plannercheck as pc
from plannercheck.evaluation.campaign.pairs import PairCase
from plannercheck.evaluation.stress.contact_poses import Points, Solid
from plannercheck.evaluation.stress.sample_bodies import Specimen
from plannercheck.validation.fcl_agreement import AgreementReport, Disagreement, compare_with_fcl

# Halvings of a segment between two configurations, at most: from radians to the last bits.
_HALVINGS = 50
# Coprime to that, so that few rows have few and many halvings alike.
_STRIDE = 37


def compare(checker: pc.Checker, robot: pc.Robot, count: int, seed: int) -> AgreementReport:
    """Compares a checker with FCL on `count` configurations."""
    q = robot.random_configurations(count, seed)
    half = count // 2
    border = border_configurations(checker, q[:half], q[half : 2 * half])
    return compare_with_fcl(checker, np.concatenate([q[: count - len(border)], border]))


def border_configurations(checker: pc.Checker, start: Points, end: Points) -> Points:
    """Configurations between start and end (n, nq) near to where a pair's verdict changes."""
    before = checker.colliding_pairs(start)
    changes = before != checker.colliding_pairs(end)
    rows = np.flatnonzero(changes.any(axis=1))
    # Another pair for each row, where there is a choice.
    pairs = np.array([np.resize(np.flatnonzero(changes[row]), row + 1)[-1] for row in rows], dtype=np.int64)
    ends = np.stack([start[rows], end[rows]])
    # Some rows stop early, so that the distances to the border are spread from about 1 rad to 1e-15.
    last = np.arange(len(rows)) * _STRIDE % _HALVINGS
    for step in range(_HALVINGS):
        going = np.flatnonzero(last >= step)
        middle = ends[:, going].mean(axis=0)
        verdicts = checker.colliding_pairs(middle)[np.arange(len(going)), pairs[going]]
        changed = verdicts != before[rows[going], pairs[going]]
        ends[changed.astype(np.int64), going] = middle
    # Both sides of the border alike.
    sides: Points = ends[np.arange(len(rows)) % 2, np.arange(len(rows))]
    return sides


def clear_errors(checker: pc.Checker, report: AgreementReport) -> list[str]:
    """Disagreements on bodies that are wide, with a gap that is clear: there should be none."""
    solids: dict[int, Solid] = {}
    errors = []
    for found in report.disagreements:
        p, r = (solid_of(checker, index, solids) for index in found.indices)
        if is_clear(p, r, *found.poses):
            errors.append(f"{p.name} | {r.name} at row {found.row}, collide {found.exact}")
    return errors


def solid_of(checker: pc.Checker, index: int, known: dict[int, Solid]) -> Solid:
    if index not in known:
        polytope = checker.polytopes[index]
        assert polytope is not None
        known[index] = Solid(checker.bodies[index].name, polytope.vertices, polytope.faces.astype(np.int64))
    return known[index]


def case_of(checker: pc.Checker, found: Disagreement) -> PairCase[Specimen]:
    """A disagreement as a case that can be saved."""
    return kept_case(*(solid_of(checker, index, {}) for index in found.indices), *found.poses)
