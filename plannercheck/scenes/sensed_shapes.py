"""Sensed shapes of scene files: the keys `cloud`, `octree`, `voxels` and `height_field`.

In: the mapping of such a key, or the name of its file alone; and shapes that are to be saved. Out: shapes with their
files, and mappings that give the same shapes. Further numbers (a cloud's radius, a grid's resolution and so on) are
keys of the mapping, or arrays of an npz file, so that one file can hold all of a shape. A shape that was made in memory
is saved as such a file, an octree as a .bt file.
"""

from __future__ import annotations

import difflib
import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.height_fields import HeightField
from plannercheck.bodies.octomap_files import binary_file
from plannercheck.bodies.octrees import Octree
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.point_clouds import PointCloud
from plannercheck.bodies.voxel_grids import VoxelGrid
from plannercheck.common.checked_yaml import BROKEN_FILE, Node, check_keys, mapping, number, numbers, required, text
from plannercheck.common.errors import PlannercheckError, shortened, unknown_name
from plannercheck.common.package_data import is_file
from plannercheck.scenes.files_beside import FilesBeside
from plannercheck.scenes.scene_paths import FindFile

# The file of a shape, and the keys that a scene's file gives besides it.
SensedSource: TypeAlias = tuple[Path, Mapping[str, Any]]

# Keys besides `file`.
_KEYS = {
    "cloud": ("radius", "invalid"),
    "octree": ("unknown", "threshold"),
    "voxels": ("resolution", "origin"),
    "height_field": ("resolution", "base", "origin"),
}
_WORDS, _LISTS = ("invalid", "unknown"), ("radius", "resolution", "origin")

# Arrays of an npz file: the shape itself, and what may be keys as well.
_ARRAYS = {
    "cloud": ("points", "radius"),
    "voxels": ("occupied", *_KEYS["voxels"]),
    "height_field": ("heights", *_KEYS["height_field"]),
}

SENSED_KEYS = tuple(_KEYS)

# From this ratio of difflib on, an array's name is taken for a misspelt one; others may be anything.
_ALIKE = 0.8


def read_sensed(kind: str, given: Any, find_file: FindFile) -> tuple[PartSet, SensedSource]:
    """The shape of one of `SENSED_KEYS`, and its file with the other keys.

    `given` is a file's name, or a mapping of `file` and further keys.
    """
    values = {"file": given} if isinstance(given, str) else mapping(given, "it")
    check_keys(values, ("file", *_KEYS[kind]))
    path = find_file(text(required(values, "file"), "file"))
    options = {key: _option(key, value) for key, value in values.items() if key != "file"}
    return _shape(kind, path, options), (path, options)


def _option(key: str, value: Any) -> Any:
    """A word, a number, or a list of numbers."""
    if key in _WORDS:
        return text(value, key)
    return numbers(value, key) if key in _LISTS and isinstance(value, list) else number(value, key)


def _shape(kind: str, path: Path, options: Node) -> PartSet:
    if kind == "octree":
        return Octree.load(path, **options)
    arrays = _arrays_of(kind, path)
    twice = sorted(set(arrays) & set(options))
    if twice:
        raise PlannercheckError(f"file {str(path)!r} has an array {twice[0]!r} itself: leave the key out")
    values = {"file": str(path), **arrays, **options}
    if kind == "cloud":
        return PointCloud.load(path, required(values, "radius"), values.get("invalid", "error"))
    make: Any = VoxelGrid if kind == "voxels" else HeightField
    further = {key: required(values, key) for key in _KEYS[kind] if key != "origin" or key in values}
    main = _ARRAYS[kind][0]
    return make(values[main], **further) if main in values else make.load(path, **further)  # type: ignore[no-any-return]


def _arrays_of(kind: str, path: Path) -> Node:
    """The arrays of an npz file that belong to a shape, without a cloud's points; none of other files."""
    if path.suffix.lower() != ".npz" or not is_file(path):
        return {}
    main, *further = _ARRAYS[kind]
    try:
        with np.load(path, allow_pickle=False) as file:
            if kind != "cloud" and main not in file:
                names = ", ".join(map(shortened, file)) or "none"
                raise PlannercheckError(f"file {str(path)!r} needs an array {main!r}; its arrays are {names}")
            for name in file:
                if name not in further and difflib.get_close_matches(name.lower(), further, 1, _ALIKE):
                    raise unknown_name(f"array of file {str(path)!r}", name, (main, *further))
            wanted = further if kind == "cloud" else (main, *further)
            return {key: file[key] for key in wanted if key in file}
    except BROKEN_FILE as error:
        raise PlannercheckError(f"file {str(path)!r} can't be read as npz: {error!s:.200}") from None


def sensed_node(shape: PartSet, owner: str, beside: FilesBeside) -> Node:
    """The mapping of an object's shape that no file gave; `beside` takes the file that the mapping names."""
    kind = sensed_kind(shape)
    if isinstance(shape, Octree):
        keys, sizes = shape.keys.astype(np.int64), shape.sizes.astype(np.int64)
        content = binary_file(keys, sizes, shape.occupied, shape.resolution)
        digest = hashlib.sha256(content).digest()
        name = beside.name(owner, digest, ".bt", lambda path: path.write_bytes(content))
        return {kind: {"file": name, "unknown": shape.unknown}}
    arrays = _cloud_arrays(shape) if isinstance(shape, PointCloud) else _named_arrays(shape, _ARRAYS[kind])
    node = {"file": beside.name(owner, _digest(arrays), ".npz", lambda path: _write_arrays(path, arrays))}
    is_dropping = isinstance(shape, PointCloud) and (shape.invalid == "drop" or shape.source is not None)
    return {kind: node | {"invalid": "drop"} if is_dropping else node}


def sensed_kind(shape: PartSet) -> str:
    """The key of a shape in a scene's file."""
    kinds = {PointCloud: "cloud", Octree: "octree", VoxelGrid: "voxels", HeightField: "height_field"}
    return next(key for kind, key in kinds.items() if isinstance(shape, kind))


def _named_arrays(shape: PartSet, names: tuple[str, ...]) -> dict[str, NDArray[Any]]:
    return {name: np.asarray(getattr(shape, name)) for name in names}


def _cloud_arrays(cloud: PointCloud) -> dict[str, NDArray[Any]]:
    """Points and radius; points that were left out are NaN, so that the others keep their names."""
    if cloud.source is None:
        return {"points": cloud.points, "radius": cloud.radius}
    rows = int(cloud.source.max(initial=-1)) + 1
    points, radius = np.full((rows, 3), np.nan), cloud.radius
    points[cloud.source] = cloud.points
    if len(radius) > 1:
        radius = np.full(rows, cloud.radius.max())
        radius[cloud.source] = cloud.radius
    return {"points": points, "radius": radius}


def _digest(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    made = hashlib.sha256()
    for name, array in arrays.items():
        made.update(repr((name, array.shape, array.dtype.str)).encode())
        made.update(np.ascontiguousarray(array).data)
    return made.digest()


def _write_arrays(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    with path.open("wb") as file:  # an open file, since NumPy adds suffixes to paths
        np.savez(file, **arrays)  # type: ignore[arg-type]  # its stub has a switch among the names
