"""Arrays in npy files, from which bodies are made.

In: a path and what it is, for errors. Out: the array, or an error.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.checked_yaml import BROKEN_FILE
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.package_data import is_file, why_no_file


def array_of_file(path: Path, what: str) -> NDArray[Any]:
    """The array of an npy file; `what` it should be, e.g. "voxel file", is for errors.

    Raises:
        PlannercheckError: If it is missing, broken, cut short, or holds objects of Python or several arrays.
    """
    if not is_file(path):
        raise PlannercheckError(f"{what} {str(path)!r} {why_no_file(path)}")
    try:
        return whole_array(path)
    except PlannercheckError as error:
        raise PlannercheckError(f"{what} {str(path)!r} {error}") from None


def whole_array(path: Path) -> NDArray[Any]:
    """The same of a file that exists, with errors that do not name it."""
    try:
        found = np.load(path, allow_pickle=False)
    except BROKEN_FILE as error:
        raise PlannercheckError(f"can't be read as npy: {error!s:.200}") from None
    if not isinstance(found, np.ndarray):
        found.close()
        raise PlannercheckError("holds several arrays: give an npy file of one")
    return found
