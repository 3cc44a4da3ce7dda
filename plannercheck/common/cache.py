"""The disk cache: results of earlier runs by content hashes, trusted only if this user wrote them.

In: names made of hashes of everything that a content depends on, so that no content is ever outdated; contents. Out:
the same contents, or nothing. It is in the platform's cache folder, or where `PLANNERCHECK_CACHE` says.

The idea. Contents are trusted, so nobody else may have written them. Folder and files have to be the user's or root's,
and others must not be able to write or rename them. The opened file is examined, not its name, which may lead elsewhere
a moment later; links are not followed, and no pipe is waited for. Each file begins with a digest of its name and
content under a secret key, a file of the same folder, so that others can't make a valid file, wherever they may put
one.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import hmac
import os
import secrets
import stat
import warnings
from collections.abc import Iterator
from pathlib import Path

import platformdirs

from plannercheck.common.atomic_files import replace_atomically
from plannercheck.common.errors import PlannercheckError

# Names the cache's folder, or 0 for none.
_SETTING = "PLANNERCHECK_CACHE"

# The file of the key, and bytes of key and digests: none of 2^256 keys is guessed.
_KEY_NAME, _BYTES = "key", 32

_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
_OPENED = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC


def cache_folder() -> Path | None:
    """The cache's folder; None if `PLANNERCHECK_CACHE` is 0, or if there is no home to have it in."""
    setting = os.environ.get(_SETTING, "")
    if setting == "0":
        return None
    if setting:
        return Path(setting)
    try:
        folder = Path(platformdirs.user_cache_dir("plannercheck"))
    except RuntimeError:  # earlier versions of platformdirs give a folder named "~"
        return None
    return folder if folder.is_absolute() else None


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


def read_cached(path: Path) -> bytes | None:
    """The content of a file of the cache; None if there is none that can be believed."""
    with _own_folder(path.parent) as folder:
        if folder is None or (key := _read_key(folder)) is None or (found := _read_own(folder, path.name)) is None:
            return None
    content = found[_BYTES:]
    return content if hmac.compare_digest(found[:_BYTES], _digest(key, path.name, content)) else None


def write_to_cache(path: Path, content: bytes) -> None:
    """Writes a file of the cache; a cache that can't be written is no error."""
    with contextlib.suppress(PlannercheckError, OSError):
        path.parent.mkdir(0o700, parents=True, exist_ok=True)
        with _own_folder(path.parent) as folder:
            key = None if folder is None else _read_key(folder) or _make_key(folder, path.parent)
        if key is not None:
            _write_own(path, _digest(key, path.name, content) + content)


@contextlib.contextmanager
def _own_folder(path: Path) -> Iterator[int | None]:
    """The folder's descriptor; None if it is missing, or if others may rename what is in it, with a warning."""
    try:
        folder = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    except OSError:
        yield None
        return
    try:
        found = os.fstat(folder)
        is_shared = found.st_mode & _OTHERS_WRITE and not found.st_mode & stat.S_ISVTX
        is_own = _is_own(found) and not is_shared
        if not is_own:
            _warn_of(path)
        yield folder if is_own else None
    finally:
        os.close(folder)


@functools.cache
def _warn_of(folder: Path) -> None:
    """Says once that a folder is not used."""
    warnings.warn(
        f"cache folder {str(folder)!r} is not used, since others may change what is in it: its owner must be the user "
        "or root, and others must have no right to write (chmod go-w)",
        RuntimeWarning,
        stacklevel=2,
    )


def _is_own(found: os.stat_result) -> bool:
    return found.st_uid in (os.geteuid(), 0)


def _read_own(folder: int, name: str, others: int = _OTHERS_WRITE) -> bytes | None:
    """The content of a plain file that is the user's or root's and gives others none of some rights; else None."""
    try:
        with os.fdopen(os.open(name, _OPENED, dir_fd=folder), "rb") as file:
            found = os.fstat(file.fileno())
            is_plain = stat.S_ISREG(found.st_mode) and _is_own(found) and not found.st_mode & others
            return file.read() if is_plain else None
    except OSError:
        return None


def _read_key(folder: int) -> bytes | None:
    """The key; None if there is none that only the user has seen."""
    key = _read_own(folder, _KEY_NAME, others=stat.S_IRWXG | stat.S_IRWXO)
    return key if key is not None and len(key) == _BYTES else None


def _make_key(folder: int, path: Path) -> bytes | None:
    """A new key; of several processes that make one at once, all take the last."""
    _write_own(path / _KEY_NAME, secrets.token_bytes(_BYTES))
    return _read_key(folder)


def _write_own(path: Path, content: bytes) -> None:
    replace_atomically(path, lambda aside: aside.write_bytes(content), mode=0o600)


def _digest(key: bytes, name: str, content: bytes) -> bytes:
    made = hashlib.blake2b(os.fsencode(name) + b"\0", key=key, digest_size=_BYTES)
    made.update(content)
    return made.digest()
