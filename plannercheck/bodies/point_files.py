"""Files of points: ply, pcd, npy, npz, and text.

In: a path, whose suffix names the format. Out: points (n, 3), with the file's NaN. A file with missing or surplus data
gives an error, never a part of its points. Only a text without a count that is cut within its last number can't be
recognised.
"""

from __future__ import annotations

import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.array_files import whole_array
from plannercheck.bodies.pcd_files import is_moved, read_pcd
from plannercheck.bodies.ply_files import points_of_ply
from plannercheck.bodies.point_texts import points_of_text
from plannercheck.common.array_types import Floats
from plannercheck.common.checked_yaml import BROKEN_FILE
from plannercheck.common.errors import PlannercheckError, shortened, unknown_name
from plannercheck.common.input_limits import INPUT_LIMITS
from plannercheck.common.package_data import is_file, why_no_file

_AXES = ("x", "y", "z")


def points_of_file(path: Path) -> Floats:
    """The points (n, 3) of a file; organised clouds (h, w, 3) row by row.

    Raises:
        PlannercheckError: If the file is missing, of another kind, broken or cut short.
    """
    if not is_file(path):
        raise PlannercheckError(f"cloud file {str(path)!r} {why_no_file(path)}")
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise unknown_name("suffix of a cloud file", path.suffix or str(path), _READERS)
    try:
        return reader(path)
    except PlannercheckError as error:
        raise PlannercheckError(f"cloud file {str(path)!r}: {error}") from None
    except BROKEN_FILE as error:
        raise PlannercheckError(f"cloud file {str(path)!r} can't be read: {error!s:.200}") from None


def _of_pcd(path: Path) -> Floats:
    read = read_pcd(path.read_bytes())
    if is_moved(read.viewpoint):
        warnings.warn(
            f"cloud file {str(path)!r} has a VIEWPOINT {list(read.viewpoint)} (x, y, z, qw, qx, qy, qz), which is not "
            "applied: give the cloud's pose, if its points are in the sensor's frame",
            RuntimeWarning,
            stacklevel=4,
        )
    return read.points


def _of_npy(path: Path) -> Floats:
    return _points_of_array(whole_array(path))


def _of_npz(path: Path) -> Floats:
    with zipfile.ZipFile(path) as archive:
        size = sum(member.file_size for member in archive.infolist())
    if size > INPUT_LIMITS.archive_bytes:
        raise PlannercheckError(f"unpacks to {size} bytes, more than INPUT_LIMITS.archive_bytes")
    with np.load(path, allow_pickle=False) as arrays:
        names = list(arrays)
        if "points" not in names and len(names) != 1:
            raise PlannercheckError(f"needs one array, or one named 'points', of {', '.join(map(shortened, names))}")
        return _points_of_array(arrays["points" if "points" in names else names[0]])


def _points_of_array(array: NDArray[Any]) -> Floats:
    """Points of rows (n, 3), of an organised cloud (h, w, 3), or of records with x, y and z."""
    if array.dtype.names and set(_AXES) <= set(array.dtype.names):
        array = np.stack([np.asarray(array[axis], dtype=np.float64) for axis in _AXES], axis=-1)
    if array.dtype.kind not in "fiu" or array.ndim not in (2, 3) or array.shape[-1] != len(_AXES):
        more = array.dtype.kind in "fiu" and array.ndim in (2, 3) and array.shape[-1] > len(_AXES)
        hint = ": save array[..., :3] if x, y and z are its first columns" if more else ""
        raise PlannercheckError(
            f"must have numbers of shape (n, 3) or (h, w, 3), or records with x, y and z, not {array.shape} of "
            f"{shortened(array.dtype)}{hint}"
        )
    return np.asarray(array, dtype=np.float64).reshape(-1, 3)


def _of_text(path: Path) -> Floats:
    return points_of_text(path.read_bytes())


_READERS: dict[str, Callable[[Path], Floats]] = {
    ".ply": points_of_ply,
    ".pcd": _of_pcd,
    ".npy": _of_npy,
    ".npz": _of_npz,
    ".xyz": _of_text,
    ".pts": _of_text,
    ".txt": _of_text,
    ".csv": _of_text,
}
