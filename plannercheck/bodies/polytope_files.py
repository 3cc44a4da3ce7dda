"""Files of prepared bodies, and the disk cache of them.

A file is the magic word, the version of the format, the SHA-256 of the data, and the data. The cache is keyed by the
content of bodies, so it needs no invalidation. It is in the platform's cache folder.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import stat
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import platformdirs
from numpy.typing import ArrayLike, NDArray

from plannercheck.common.atomic_files import replace_atomically, write_atomically
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError

# Polygons of indices of points, as callers give them.
GivenFaces: TypeAlias = Sequence[ArrayLike] | NDArray[np.integer[Any]]

# Names the cache's folder, or 0 for none.
_SETTING = "PLANNERCHECK_CACHE"

_MAGIC = b"plannercheck body"
_HASH_BYTES = 32


def _header() -> bytes:
    return _MAGIC + f" {core.body_format} {sys.byteorder}\n".encode()


def write(path: Path, data: bytes) -> None:
    """Writes data with header and hash; the file appears whole or not at all.

    Args:
        path: The file; its folder must exist.
        data: A serialised body.

    Raises:
        PlannercheckError: If the folder can't be written to.
    """
    content = _content(data)
    write_atomically(path, lambda aside: aside.write_bytes(content))


def _content(data: bytes) -> bytes:
    return _header() + hashlib.sha256(data).digest() + data


def read(path: Path) -> bytes:
    """Reads the data of a file and verifies its hash.

    Args:
        path: A file written by `write`.

    Returns:
        The serialised body.

    Raises:
        PlannercheckError: If it is missing, of another kind or version, cut short or changed.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise PlannercheckError(f"can't read a body from {path}: {error}") from error
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


def read_cached(path: Path) -> bytes | None:
    """The data of a cached file; None if there is none that can be trusted.

    The file has to be complete, of this version and name, and a plain file that only the user (or root) owns and can
    write to. So users of a shared folder get no bodies from each other.
    """
    key = bytes.fromhex(path.stem)
    try:
        if not is_own_file(path):
            return None
        data = read(path)
    except (PlannercheckError, OSError):
        return None
    return data[len(key) :] if data.startswith(key) else None


def is_own_file(path: Path) -> bool:
    """Whether only the user and root could have written a file; it is not opened, since that may block."""
    return is_own(path.lstat())


def is_own(found: os.stat_result) -> bool:
    """The same of what is known of a file."""
    if not stat.S_ISREG(found.st_mode):
        return False
    own = not hasattr(os, "geteuid") or found.st_uid in (os.geteuid(), 0)
    return own and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def write_to_cache(path: Path, data: bytes) -> None:
    """Writes to the cache; a cache that can't be written is no error."""
    with contextlib.suppress(PlannercheckError, OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        content = _content(bytes.fromhex(path.stem) + data)
        replace_atomically(path, lambda aside: aside.write_bytes(content), mode=0o644)


def cache_folder() -> Path | None:
    """The cache's folder; None if `PLANNERCHECK_CACHE` is 0."""
    setting = os.environ.get(_SETTING, "")
    if setting == "0":
        return None
    return Path(setting) if setting else Path(platformdirs.user_cache_dir("plannercheck"))


@contextlib.contextmanager
def uncached() -> Iterator[None]:
    """Turns the cache off for this process and those that it starts, until the end."""
    before = os.environ.get(_SETTING)
    os.environ[_SETTING] = "0"
    try:
        yield
    finally:
        if before is None:
            del os.environ[_SETTING]
        else:
            os.environ[_SETTING] = before


def cache_file(points: NDArray[np.float64], faces: GivenFaces | None, inflation_radius: float) -> Path | None:
    """Where the prepared body of these points is cached; None if the cache is off."""
    folder = cache_folder()
    if folder is None:
        return None
    key = hashlib.sha256(_header() + np.float64(inflation_radius).tobytes() + np.ascontiguousarray(points).tobytes())
    for face in faces if faces is not None else ():
        key.update(b"face" + np.asarray(face, dtype=np.int64).tobytes())
    return folder / f"{key.hexdigest()}.body"
