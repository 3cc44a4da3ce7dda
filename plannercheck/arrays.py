"""Arrays as the core reads them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def contiguous(values: ArrayLike) -> NDArray[np.float64]:
    """Numbers as float64 in C order, the given array itself if it is so.

    Those at odd addresses, as in messages and in records of files, are copied: the core reads whole doubles.

    Raises:
        TypeError, ValueError: For what holds no numbers.
    """
    array = np.ascontiguousarray(values, dtype=np.float64)
    return array if array.flags.aligned else array.copy()
