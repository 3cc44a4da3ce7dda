"""Files of prepared bodies, and their names in the disk cache.

A file is the magic word, the version of the format, the SHA-256 of the data, and the data. The cache has the data
alone, by names that depend on the version and on what the body was made of.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.cache import cache_folder
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError

# Polygons of indices of points, as callers give them.
GivenFaces: TypeAlias = Sequence[ArrayLike] | NDArray[np.integer[Any]]

_MAGIC = b"plannercheck body"
_HASH_BYTES = 32


def _header() -> bytes:
    return _MAGIC + f" {core.body_format} {sys.byteorder}\n".encode()


def write(path: Path, data: bytes) -> None:
    """Writes data with header and hash into a folder that exists; the file appears whole or not at all.

    Raises:
        PlannercheckError: If the folder can't be written to.
    """
    content = _header() + hashlib.sha256(data).digest() + data
    write_atomically(path, lambda aside: aside.write_bytes(content))


def read(path: Path) -> bytes:
    """Reads the data of a file that `write` wrote, and verifies its hash.

    Raises:
        PlannercheckError: If it is missing, of another kind or version, cut short or changed.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise PlannercheckError(f"can't read a body from {path}: {error.strerror or error}") from error
    header = _header()
    if not content.startswith(_MAGIC):
        raise PlannercheckError(f"{path} is no file of a prepared body: it does not start with {_MAGIC.decode()!r}")
    if not content.startswith(header):
        found = content[:80].split(b"\n")[0].decode(errors="replace")
        raise PlannercheckError(
            f"{path} is {found!r}, this version reads {header.decode().strip()!r}: prepare it again"
        )
    digest, data = content[len(header) :][:_HASH_BYTES], content[len(header) + _HASH_BYTES :]
    if hashlib.sha256(data).digest() != digest:
        raise PlannercheckError(f"{path} is cut short or changed: its content does not match its hash")
    return data


def cache_file(points: NDArray[np.float64], faces: GivenFaces | None, inflation_radius: float) -> Path | None:
    """Where the prepared body of these points is cached; None if the cache is off."""
    folder = cache_folder()
    if folder is None:
        return None
    key = hashlib.sha256(_header() + np.float64(inflation_radius).tobytes() + np.ascontiguousarray(points).tobytes())
    for face in faces if faces is not None else ():
        key.update(b"face" + np.asarray(face, dtype=np.int64).tobytes())
    return folder / f"{key.hexdigest()}.body"
