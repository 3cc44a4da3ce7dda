"""Types of arrays, for annotations: what the elements are; shapes and units are said where an array is named."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Bools: TypeAlias = NDArray[np.bool_]
Ints: TypeAlias = NDArray[np.int32]  # indices, as the core takes them
Ints64: TypeAlias = NDArray[np.int64]  # indices, as NumPy gives them
Faces: TypeAlias = list[Ints64]  # polygons of indices, of any number of corners
