"""Bounds of the rounding of the verifier's sums and bounds in doubles."""

from __future__ import annotations

# A sum of four products in doubles errs by 4 u of their sizes to first order, what is rounded to doubles before by 1 u.
ROUNDING = 8 * 2.0**-53

# Covers some roundings of a bound that is computed in doubles.
UP = 1 + 2.0**-48

# Covers products below the range of doubles; far below any length that is looked at, m.
UNDERFLOW = 1e-290
