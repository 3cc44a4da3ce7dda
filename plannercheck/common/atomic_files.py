"""Output files that appear whole or not at all.

In: a path and a function that writes. Out: the file, written under another name in the same folder, then renamed. Where
the system has files without a name (Linux), such a file is used: a process that is killed leaves nothing behind.
"""

from __future__ import annotations

import contextlib
import os
import secrets
from collections.abc import Callable, Iterator
from pathlib import Path

from plannercheck.common.errors import PlannercheckError
from plannercheck.common.package_data import is_folder

# Files without a name are reached here until they get one.
_DESCRIPTORS = Path("/proc/self/fd")


def write_atomically(path: Path, write: Callable[[Path], object], mode: int = 0o666) -> None:
    """Lets a function write a file beside `path`, then renames it.

    Args:
        path: Where the file shall be; its folder must exist.
        write: Called with the path to write to, which may lack the suffix.
        mode: The file's mode, less the process's umask.

    Raises:
        PlannercheckError: If the file can't be written; then `path` is as it was.
    """
    try:
        if is_folder(path):
            raise IsADirectoryError(0, "there is a folder of this name")
        with _unnamed(path.parent, mode) as descriptor:
            if descriptor is None:
                _by_name(path, write, mode)
            else:
                file = _DESCRIPTORS / str(descriptor)
                write(file)
                _named(file, path)
    except OSError as error:
        raise PlannercheckError(f"file {str(path)!r} can't be written: {error.strerror or error}") from None


@contextlib.contextmanager
def _unnamed(folder: Path, mode: int) -> Iterator[int | None]:
    """A new file without a name, with the rights of any new file; None where there are none."""
    flag, descriptor = getattr(os, "O_TMPFILE", None), None
    if flag is not None and _DESCRIPTORS.is_dir():
        with contextlib.suppress(OSError):  # of file systems that have none; a folder that can't be written fails below
            descriptor = os.open(folder, flag | os.O_RDWR, mode)
    try:
        yield descriptor
    finally:
        if descriptor is not None:
            os.close(descriptor)


def _named(file: Path, path: Path) -> None:
    """Gives an unnamed file its name; where there is a file already, by way of another name.

    A process that is killed between the two steps leaves the other name behind, so that they are taken only then.
    """
    aside, folder = _other_name(path), os.open(path.parent, os.O_RDONLY)
    try:  # with a folder's descriptor Python calls linkat, else link, which does not follow
        with contextlib.suppress(FileExistsError):
            return os.link(file, path.name, dst_dir_fd=folder, follow_symlinks=True)
        os.link(file, aside.name, dst_dir_fd=folder, follow_symlinks=True)
    finally:
        os.close(folder)
    _replace(aside, path)


def _by_name(path: Path, write: Callable[[Path], object], mode: int) -> None:
    aside = _other_name(path)
    os.close(os.open(aside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode))
    try:
        write(aside)
    except BaseException:
        aside.unlink(missing_ok=True)
        raise
    _replace(aside, path)


def _replace(aside: Path, path: Path) -> None:
    try:
        aside.replace(path)
    except BaseException:
        aside.unlink(missing_ok=True)
        raise


def _other_name(path: Path) -> Path:
    return path.with_name(f".{path.stem}{secrets.token_hex(8)}{path.suffix}")
