"""The truth about a pair: proofs in compiled whole numbers, independent of the core (cpp/oracle).

In: a draw. Out: proved verdicts, and the verdicts that the core's own certificates prove.

The idea: a separation or a common point is hard to find and easy to check. The oracle searches for one by itself, in
whole numbers of any size, and gives a verdict only if its proof holds by definition. Where it finds none, Python's
integers decide (`plannercheck.bodies.exact_reference`).
"""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import Any

import numpy as np

from plannercheck.bodies import exact_reference as exact
from plannercheck.bodies.tuning import METHODS, pair_options
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.campaign.pairs import Truth
from plannercheck.evaluation.stress.contact_poses import Points
from plannercheck.evaluation.stress.random_cases import Draw

BY_INTEGERS = "by integers"
# The answer of `_oracle.decide` where it found no proof.
_UNPROVED = 2
# Of the core's numbers that are doubles: digits of whole numbers take the mantissa's bits.
_MANTISSA_BITS = 53


class Oracle:
    """The oracle on one draw."""

    def __init__(self, drawn: Draw) -> None:
        """Takes the vertices as they are."""
        self._drawn = drawn
        self._compiled = compiled_oracle()
        self._p, self._r = (self._compiled.Points(body.vertices, body.inflation_radius) for body in (drawn.p, drawn.r))

    def truth(self, thorough: bool) -> Truth:
        """Whether each pair shares a point, proved.

        Args:
            thorough: Whether planes are held against every vertex in whole numbers, not only against those that
                doubles, with a proved bound, leave in doubt; and Python's integers have to agree on the first pair.

        Returns:
            Verdicts, and BY_INTEGERS of those that Python's integers had to find.
        """
        drawn = self._drawn
        found = self._compiled.decide(self._p, drawn.poses_p, self._r, drawn.poses_r, thorough)
        verdicts = (found == 1).tolist()
        notes = [""] * len(verdicts)
        for k in np.flatnonzero(found == _UNPROVED).tolist():
            verdicts[k], notes[k] = _by_integers(drawn, k), BY_INTEGERS
        if thorough and _by_integers(drawn, 0) != verdicts[0]:
            raise AssertionError(f"two exact oracles disagree: {drawn.label}")
        return Truth(verdicts, notes)

    def certified(self, k: int) -> bool | None:
        """What the core's certificate of the k-th pair proves: True a shared point, False a separation, else None."""
        pose_p, pose_r = self._drawn.poses_p[k], self._drawn.poses_r[k]
        for method in (METHODS[0], METHODS[-1]):
            found = core.certify_pair(
                self._drawn.p.polytope.core, pose_p, self._drawn.r.polytope.core, pose_r, pair_options(method), True
            )
            if self._proves(found, pose_p, pose_r):
                return bool(found["shared"])
        return None

    def _proves(self, found: dict[str, Any], pose_p: Points, pose_r: Points) -> bool:
        question = self._p, pose_p, self._r, pose_r
        if found["shared"]:
            mixed = [*found["vertices_a"].tolist()], [*found["vertices_b"].tolist()], list(found["exact_weights"])
            return bool(self._compiled.shares(*question, *mixed))
        normal = found["normal"].ravel()
        rounded = [_digits(x) for x in normal.tolist()] if np.isfinite(normal).all() else []
        if rounded and self._compiled.separates(*question, rounded, False):
            return True
        return "exact_normal" in found and bool(self._compiled.separates(*question, list(found["exact_normal"]), False))


def _by_integers(drawn: Draw, k: int) -> bool:
    return exact.intersects(
        drawn.p.vertices,
        drawn.r.vertices,
        drawn.poses_p[k],
        drawn.poses_r[k],
        drawn.p.inflation_radius,
        drawn.r.inflation_radius,
    )


def _digits(number: float) -> tuple[str, int]:
    """A double as hexadecimal digits of a whole number and the power of two that it is times."""
    mantissa, exponent = np.frexp(number)
    return f"{int(mantissa * 2.0**_MANTISSA_BITS):x}", int(exponent) - _MANTISSA_BITS


def compiled_oracle() -> ModuleType:
    """The module of cpp/oracle; PlannercheckError if it is not built."""
    try:
        return importlib.import_module("plannercheck._oracle")
    except ImportError:
        raise PlannercheckError("plannercheck._oracle is not built: reinstall, or build the target _oracle") from None
