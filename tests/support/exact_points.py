"""Points in exact arithmetic, for tests that ask brute force."""

import numpy as np


def integers(points):
    """Points as Python integers in a common unit, exact: signs of homogeneous polynomials are kept."""
    ratios = [x.as_integer_ratio() for x in np.asarray(points, dtype=float).ravel().tolist()]
    unit = max(denominator for _, denominator in ratios)  # a power of two, as all are
    values = [numerator * (unit // denominator) for numerator, denominator in ratios]
    return np.array(values, dtype=object).reshape(-1, 3)
