"""The solver's small games: what rows can hold payoffs down to is what columns can hold them up to."""

import numpy as np
import pytest

from plannercheck.common.core import core


@pytest.mark.parametrize("at_once", [0, 1, 4, 8])
@pytest.mark.parametrize("kind", ["random", "ties", "nearly equal"])
@pytest.mark.parametrize(("rows", "columns"), [(1, 1), (1, 5), (4, 1), (2, 2), (3, 4), (4, 4), (8, 3), (8, 8)])
def test_both_sides_prove_each_other_right(rows, columns, kind, at_once):
    """By duality: mixtures of rows bound the value from above, of columns from below. Games grow or begin whole."""
    rng = np.random.default_rng(10 * rows + columns)
    payoffs = rng.uniform(-1, 1, (500, rows, columns))
    if kind == "ties":
        payoffs = np.round(2 * payoffs) / 2
    spread = 1e-4 if kind == "nearly equal" else 1.0
    payoffs, bulk = spread * payoffs, 1.0 if kind == "nearly equal" else 0.0
    of_rows, of_columns = (np.asarray(weights) for weights in core.solve_games(bulk + payoffs, 2.0, at_once))
    for weights, count in ((of_rows, rows), (of_columns, columns)):
        assert (weights >= 0).all()
        assert (weights[:, count:] == 0).all()
        np.testing.assert_allclose(weights.sum(axis=1), 1, rtol=1e-12)
    above = np.einsum("ni,nij->nj", of_rows[:, :rows], payoffs).max(axis=1)
    below = np.einsum("nj,nij->ni", of_columns[:, :columns], payoffs).min(axis=1)
    # What is nearly equal is told apart up to rounding through bases that are nearly singular.
    np.testing.assert_allclose(above, below, rtol=0, atol=1e-12 if kind != "nearly equal" else 1e-4 * spread)


@pytest.mark.parametrize("number", [1e308, np.inf, np.nan])
def test_numbers_beyond_reason_do_no_harm(number):
    """Found by a review: a column was looked for among what is no number, and written beyond the tableau."""
    rng = np.random.default_rng(0)
    payoffs = rng.uniform(-1, 1, (20_000, 8, 8))
    payoffs[rng.random(payoffs.shape) < 0.03] = number
    for at_once in (0, 3, 8):
        for weights in map(np.asarray, core.solve_games(payoffs, 2.0, at_once)):
            assert (weights >= 0).all()
            np.testing.assert_allclose(weights.sum(axis=1), 1, rtol=1e-12)


@pytest.mark.parametrize("shape", [(1, 0, 3), (1, 3, 0), (1, 9, 2), (1, 2, 9)])
def test_other_sizes_are_refused(shape):
    with pytest.raises(ValueError, match="1 to 8 rows and columns"):
        core.solve_games(np.zeros(shape), 1.0)
