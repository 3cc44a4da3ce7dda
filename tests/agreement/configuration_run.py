"""Configurations of a robot in a scene held against FCL, with exact arithmetic as the judge.

In: a checker, how many configurations, a seed. Out: the report of the comparison, and FCL's errors on wide
bodies with a clear gap. Half of the configurations are random within the limits; the others lie so close to
the border between free and colliding that halving can't bring them closer.
"""

from __future__ import annotations

import contacts
import numpy as np
from cases import Case
from contacts import Points, Solid
from pair_run import CLEAR, WIDE

import plannercheck as pc
from plannercheck.agreement import AgreementReport, Disagreement, compare_with_fcl

# Halvings of a segment between a free and a colliding configuration: from radians to the last bits.
_HALVINGS = 50


def compare(checker: pc.Checker, robot: pc.Robot, count: int, seed: int) -> AgreementReport:
    """Compares a checker with FCL on `count` configurations."""
    q = robot.random_configurations(count, seed)
    border = border_configurations(checker, q[: count // 2], q[count // 2 : 2 * (count // 2)])
    return compare_with_fcl(checker, np.concatenate([q[: count - len(border)], border]))


def border_configurations(checker: pc.Checker, start: Points, end: Points) -> Points:
    """Configurations between start and end (n, nq) where the verdict changes, as near as doubles allow."""
    start_valid = checker.check_states(start)
    changes = start_valid != checker.check_states(end)
    start, end, start_valid = start[changes], end[changes], start_valid[changes]
    for _ in range(_HALVINGS if len(start) else 0):
        middle = (start + end) / 2
        same = (checker.check_states(middle) == start_valid)[:, None]
        start, end = np.where(same, middle, start), np.where(same, end, middle)
    # Each side of the border alike.
    sides: Points = np.where((np.arange(len(start)) % 2)[:, None] == 0, start, end)
    return sides


def clear_errors(checker: pc.Checker, report: AgreementReport) -> list[str]:
    """Disagreements on bodies that are wide, with a gap that is clear: there should be none."""
    solids: dict[int, Solid] = {}
    return [
        f"{' | '.join(found.bodies)} at row {found.row}, collide {found.exact}"
        for found in report.disagreements
        if is_clear(found, *(solid_of(checker, index, solids) for index in found.indices))
    ]


def is_clear(found: Disagreement, p: Solid, r: Solid) -> bool:
    width = min(p.width, r.width)
    gap = found.distance or contacts.depth_along_facets(p, r, *found.poses)
    return width > WIDE and gap > CLEAR * width


def solid_of(checker: pc.Checker, index: int, known: dict[int, Solid]) -> Solid:
    if index not in known:
        polytope = checker.polytopes[index]
        known[index] = Solid(checker.bodies[index].name, polytope.vertices, polytope.faces)
    return known[index]


def case_of(checker: pc.Checker, found: Disagreement) -> Case:
    """A disagreement as a case that can be saved."""
    p, r = (checker.polytopes[index].vertices for index in found.indices)
    return Case(" | ".join(found.bodies), (p, r, *found.poses))
