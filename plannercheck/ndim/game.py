"""The game of points against halfspaces, in doubles: a guide, not a proof.

In: points P (k, d) and polar points Q (l, d) of halfspaces q·x ≤ 1. Out: either q in the hull of Q with q·p > 1 for
every p, a hyperplane that keeps P off all halfspaces' intersection; or x in the hull of P with q·x ≤ 1 for every q.

The idea: v = min over x of max over q of q·x is the value of a zero-sum game. A double oracle plays it on few active
points of both sides: it solves their matrix game by the simplex method, then asks each side for its best answer by a
scan.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.ndim.rounding import FLAT

_MOST_ROUNDS = 100
_MOST_PIVOTS = 200
# Reduced costs above this are optimal up to rounding; entries are scaled to about 1.
_OPTIMAL = 1e-12


@dataclass(frozen=True)
class Played:
    """How a game ended.

    Attributes:
        separates: Whether the value is above 1.
        x: A point of the first hull (d,).
        q: A point of the second hull (d,).
        weights_p: Weights of the active points of the first body, by index.
        weights_q: The same for the other side.
        lowest: Index of the point of P with the least q·p.
        highest: Index of the point of Q with the largest q·x.
        rounds: Rounds of the double oracle.
    """

    separates: bool
    x: Floats
    q: Floats
    weights_p: dict[int, float]
    weights_q: dict[int, float]
    lowest: int
    highest: int
    rounds: int


def play(points: Floats, polars: Floats) -> Played:
    """Decides whether the hull of points (k, d) meets all halfspaces of polars (l, d), by the first certificate."""
    highest = int((polars @ points.mean(axis=0)).argmax())
    active_p, active_q = [int((points @ polars[highest]).argmin())], [highest]
    for rounds in range(1, _MOST_ROUNDS + 1):
        x_weights, q_weights = matrix_game(points[active_p] @ polars[active_q].T)
        x, q = x_weights @ points[active_p], q_weights @ polars[active_q]
        under, over = points @ q, polars @ x
        lowest, highest = int(under.argmin()), int(over.argmax())
        separates, meets = under[lowest] > 1.0, over[highest] <= 1.0
        stalled = lowest in active_p and highest in active_q
        if separates or meets or stalled or rounds == _MOST_ROUNDS:
            # Where rounding leaves it open, the middle of both bounds of the value decides; it only guides.
            is_apart = bool(separates or (not meets and under[lowest] + over[highest] > 2.0))
            first = {k: float(w) for k, w in zip(active_p, x_weights, strict=True) if w > 0}
            second = {k: float(w) for k, w in zip(active_q, q_weights, strict=True) if w > 0}
            return Played(is_apart, x, q, first, second, lowest, highest, rounds)
        active_p += [] if lowest in active_p else [lowest]
        active_q += [] if highest in active_q else [highest]
    raise AssertionError("the last round returns")


def matrix_game(payoffs: Floats) -> tuple[Floats, Floats]:
    """Solves the zero-sum game (k, l) in which rows minimise and columns maximise.

    Mixed strategies of the rows (k,) and columns (l,), clipped and normalised: rounding costs progress, never that they
    are mixtures.
    """
    rows, columns = payoffs.shape
    if rows == 1 or columns == 1:
        return _pure(payoffs)
    spread = float(np.ptp(payoffs))
    if spread < FLAT * float(np.abs(payoffs).max()) or spread == 0.0:
        return np.full(rows, 1.0 / rows), np.full(columns, 1.0 / columns)
    # Positive entries in 1 … 2; then maximise Σ y with Aᵀ y ≤ 1, whose slacks price the columns' strategy.
    scaled = (payoffs - payoffs.min()) / spread + 1.0
    return _simplex(scaled.T)


def _pure(payoffs: Floats) -> tuple[Floats, Floats]:
    rows, columns = np.zeros(payoffs.shape[0]), np.zeros(payoffs.shape[1])
    if payoffs.shape[0] == 1:
        rows[0] = columns[payoffs[0].argmax()] = 1.0
    else:
        columns[0] = rows[payoffs[:, 0].argmin()] = 1.0
    return rows, columns


def _simplex(matrix: Floats) -> tuple[Floats, Floats]:
    """Maximises Σ y with matrix y ≤ 1, y ≥ 0; returns y and the prices, both of sum 1."""
    height, width = matrix.shape
    tableau = np.zeros((height + 1, width + height + 1))
    tableau[:-1, :width] = matrix
    tableau[:-1, width:-1] = np.eye(height)
    tableau[:-1, -1] = 1.0
    tableau[-1, :width] = -1.0
    basis = np.arange(width, width + height)
    for step in range(_MOST_PIVOTS):
        costs = tableau[-1, :-1]
        # Bland's rule in the second half can't cycle.
        column = int(costs.argmin()) if step < _MOST_PIVOTS // 2 else int((costs < -_OPTIMAL).argmax())
        if costs[column] >= -_OPTIMAL:
            break
        entries = tableau[:-1, column]
        ratios = np.full(height, np.inf)
        np.divide(tableau[:-1, -1], entries, out=ratios, where=entries > _OPTIMAL)
        row = int(ratios.argmin())
        if not np.isfinite(ratios[row]):
            break
        source = tableau[row] / tableau[row, column]
        tableau -= np.outer(tableau[:, column], source)
        tableau[row] = source
        basis[row] = column
    solution = np.zeros(width + height)
    solution[basis] = tableau[:-1, -1]
    return _mixture(solution[:width]), _mixture(tableau[-1, width:-1])


def _mixture(weights: Floats) -> Floats:
    weights = np.maximum(weights, 0.0)
    total = float(weights.sum())
    return weights / total if total > 0 else np.full(len(weights), 1.0 / len(weights))
