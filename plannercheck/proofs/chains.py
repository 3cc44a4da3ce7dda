"""Poses of links on a motion, in ball arithmetic: maps between joints of the tree, at points and over intervals.

In: a model, a motion. Out: `Chains.jet(span, above, joint)`, the jet of the map from a joint's frame to that of a joint
above it, over a span of the parameter, and bounds for every map of the tree.
"""

from __future__ import annotations

from copy import copy
from typing import Any

from flint import arb, arb_mat

from plannercheck.proofs.data import JOINTS, Joint, Model, Motion
from plannercheck.proofs.jets import Jet, affine, ball_between, product
from plannercheck.proofs.joint_motions import held_map, joint_motion

# An interval of the parameter; both ends are equal for a point.
Span = tuple[float, float]

IDENTITY = Jet(arb_mat(4, 4, [int(k % 5 == 0) for k in range(16)]))

# Chains are kept for at most this many spans, so that memory stays bounded.
_MOST_SPANS = 3000


class Chains:
    """The maps of one robot on one motion; each is computed once."""

    def __init__(self, model: Model, motion: Motion) -> None:
        """Reads the joints.

        Raises:
            UnprovedError: If the motion has no definite short way.
        """
        self._joints, self._parents = model.joints, [joint.parent for joint in model.joints]
        self.defect = _defect(model)
        self._begin(motion)

    def _begin(self, motion: Motion) -> None:
        self._motions = [joint_motion(joint, motion.control, motion.path) for joint in self._joints]
        self._spans: dict[Span, dict[tuple[int, int], Jet]] = {}
        self._points: dict[float, dict[tuple[int, int], Any]] = {}

    def on(self, motion: Motion) -> Chains:
        """The same robot's on another motion; errors as of the constructor."""
        made = copy(self)
        made._begin(motion)
        return made

    def is_above(self, above: int, joint: int) -> bool:
        """Whether a joint is another one or its ancestor; the world is above all joints."""
        while joint > above:
            joint = self._parents[joint]
        return joint == above

    def meeting(self, first: int, second: int) -> int:
        """The lowest joint that is above both."""
        while first != second:
            first, second = (self._parents[first], second) if first > second else (first, self._parents[second])
        return first

    def jet(self, span: Span, above: int, joint: int) -> Jet:
        """The map from a joint's frame to that of one above it, over a span."""
        return self._jet(span, _remembered(self._spans, span), above, joint)

    def at(self, t: float, above: int, joint: int) -> Any:
        """The same map at a parameter, 4 x 4."""
        return self._at(t, _remembered(self._points, t), above, joint)

    def _jet(self, span: Span, known: dict[tuple[int, int], Jet], above: int, joint: int) -> Jet:
        missing = self._missing(known, above, joint)
        if not missing:
            return IDENTITY if joint == above else known[above, joint]
        ball = ball_between(*span)
        for k in missing:
            parent = self._parents[k]
            if (parent, k) not in known:
                known[parent, k] = self._motions[k](ball)
            if parent != above:
                known[above, k] = product(known[above, parent], known[parent, k])
        return known[above, joint]

    def _missing(self, known: dict[tuple[int, int], Any], above: int, joint: int) -> list[int]:
        """The joints between two joints whose maps are not known yet, from above."""
        found = []
        while joint != above and (above, joint) not in known:
            found.append(joint)
            joint = self._parents[joint]
        return found[::-1]

    def _at(self, t: float, known: dict[tuple[int, int], Any], above: int, joint: int) -> Any:
        for k in self._missing(known, above, joint):
            parent = self._parents[k]
            if (parent, k) not in known:
                known[parent, k] = self._motions[k](arb(t)).value
            if parent != above:
                known[above, k] = known[above, parent] * known[parent, k]
        return IDENTITY.value if joint == above else known[above, joint]


def _remembered(known: dict[Any, dict[tuple[int, int], Any]], key: Any) -> dict[tuple[int, int], Any]:
    """What is known at a parameter or over a span."""
    if key not in known:
        if len(known) >= _MOST_SPANS:
            known.clear()
        known[key] = {}
    return known[key]


def _defect(model: Model) -> float:
    """An upper bound of |M^T M - 1| of the rotation part of every chain, placements of links included.

    For a product of parts with |M_i^T M_i - 1| <= e_i it is at most the product of all 1 + e_i, less 1. A turn by
    Rodrigues' formula about an axis with |a|^2 = 1 + e has (c^2 + s^2 |a|^2 - 1) I + (2 c (1 - c) + (1 - c)^2 |a|^2 -
    s^2) a a^T = s^2 e I + (1 - c)^2 e a a^T, at most |e| (1 + 4 |a|^2). A joint that moves with unit numbers is rigid.
    """
    out = arb(1)
    for joint in model.joints:
        out *= (1 + off_rigid(affine(joint.placement))) * (1 + _motion_defect(joint))
    for link in model.links:
        out *= 1 + off_rigid(affine(link.placement))
    return float((out - 1).abs_upper()) * (1 + 1e-12)


def _motion_defect(joint: Joint) -> Any:
    if max(joint.columns) < 0:
        return off_rigid(held_map(joint))
    form, square = JOINTS[joint.kind], sum((arb(part) ** 2 for part in joint.axis), arb(0))
    return (square - 1).abs_upper() * (1 + 4 * square) if form.has_axis and not form.lengths else arb(0)


def off_rigid(matrix: Any) -> Any:
    """An upper bound of |M^T M - 1| of the 3 x 3 part (Frobenius norm); exact numbers give a tiny ball."""
    m = arb_mat(3, 3, [matrix[i, j] for i in range(3) for j in range(3)])
    rest = m.transpose() * m - arb_mat(3, 3, [int(k % 4 == 0) for k in range(9)])
    return sum((entry * entry for entry in rest.entries()), arb(0)).nonnegative_part().sqrt().abs_upper()
