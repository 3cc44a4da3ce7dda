"""Outputs: files that appear whole or not at all, and streams.

In: a path and a function that writes. Out: the file, written under another name in the same folder, then renamed. Where
the system has files without a name (Linux), such a file is used: a process that is killed leaves nothing behind. Links
are followed to the file that they name. Devices, pipes and open descriptors are streams: they get a copy of what was
written in a temporary folder.
"""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import shutil
import stat
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO, cast

from plannercheck.common.errors import PlannercheckError

# Files without a name are reached here until they get one.
_DESCRIPTORS = Path("/proc/self/fd")

# s: how long a named pipe waits for a reader, which may be about to start; without an end nobody would learn of it.
_PATIENCE = 10.0

# Links that the system follows for one name; more are a circle.
_MOST_LINKS = 40


def write_atomically(path: Path, write: Callable[[Path], object]) -> None:
    """Lets a function write what a user wants at a path.

    Args:
        path: A new file in a folder that exists; a file, which keeps its mode; a stream; or a link to any of these.
        write: Called with the path to write to, which may lack the suffix.

    Raises:
        PlannercheckError: If it can't be written; then a file at `path` is as it was.
    """
    with _naming_errors(path):
        before = _found(path)
        if is_stream(path):
            _copy(write, path)
        else:
            _replace(Path(os.path.realpath(path)), write, before)


def replace_atomically(path: Path, write: Callable[[Path], object], mode: int) -> None:
    """Lets a function write a file in place of whatever is there: a link, a device or a file goes.

    Args:
        path: A path in a folder that exists.
        write: As of `write_atomically`.
        mode: The file's mode, less the process's umask.

    Raises:
        PlannercheckError: If the file can't be written; then `path` is as it was.
    """
    with _naming_errors(path):
        _replace(path, write, None, mode)


def is_stream(path: Path) -> bool:
    """Whether a path leads to a device, a pipe or an open descriptor, where nothing can be replaced."""
    if _own_descriptor(path) is not None:
        return True
    try:
        found = _found(path)
    except OSError:
        return False
    return found is not None and not stat.S_ISREG(found.st_mode)


@contextlib.contextmanager
def _naming_errors(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise PlannercheckError(f"file {str(path)!r} can't be written: {error.strerror or error}") from None


def _found(path: Path) -> os.stat_result | None:
    """The file that a path leads to; None if there is none.

    Links that the system does not follow, as those of others in /tmp, are errors here and never read by hand.
    """
    try:
        found = path.stat()
    except FileNotFoundError:
        return None
    except ValueError as error:
        raise OSError(errno.EINVAL, str(error)) from None
    if stat.S_ISDIR(found.st_mode):
        raise IsADirectoryError(errno.EISDIR, "there is a folder of this name")
    return found


def _own_descriptor(path: Path) -> int | None:
    """The number of this process's descriptor that a path leads to, as /dev/stdout and /dev/fd/3 do."""
    folders = {os.path.realpath(folder) for folder in ("/dev/fd", _DESCRIPTORS)}
    try:
        for _ in range(_MOST_LINKS):
            if path.name.isdecimal() and os.path.realpath(path.parent) in folders:
                return int(path.name)
            path = path.parent / path.readlink()
    except (OSError, ValueError):  # no link, or no name of a file
        pass
    return None


def _copy(write: Callable[[Path], object], path: Path) -> None:
    """Writes a file elsewhere and copies it into a stream: writers may go back, which streams can't."""
    with tempfile.TemporaryDirectory(prefix="plannercheck-") as folder:
        aside = Path(folder) / "output"
        write(aside)
        with aside.open("rb") as whole, _opened_stream(path) as stream:
            shutil.copyfileobj(whole, stream)


def _opened_stream(path: Path) -> BinaryIO:
    """A stream for writing; of a descriptor a copy, which goes on where the descriptor is."""
    own = _own_descriptor(path)
    return cast(BinaryIO, os.fdopen(os.dup(own) if own is not None else _opened_pipe(path), "wb"))


def _opened_pipe(path: Path) -> int:
    """The descriptor of a pipe or device, once somebody reads it."""
    end = time.monotonic() + _PATIENCE
    while True:
        try:
            descriptor = os.open(path, os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY)
            os.set_blocking(descriptor, True)
            return descriptor
        except OSError as error:
            if error.errno != errno.ENXIO or not path.is_fifo():
                raise
        if time.monotonic() > end:
            raise OSError(errno.ENXIO, f"nobody has read this pipe for {_PATIENCE:g} s")
        time.sleep(0.01)


def _replace(path: Path, write: Callable[[Path], object], before: os.stat_result | None, mode: int = 0o666) -> None:
    """Writes a file; one that was there before gives it its rights, and until then only its owner may read it."""
    mode = mode if before is None else stat.S_IRUSR | stat.S_IWUSR
    with _unnamed(path.parent, mode) as descriptor:
        if descriptor is None:
            _by_name(path, write, before, mode)
        else:
            file = _DESCRIPTORS / str(descriptor)
            write(file)
            _take_rights(file, before)
            _named(file, path)


def _take_rights(file: Path, before: os.stat_result | None) -> None:
    if before is None:
        return
    with contextlib.suppress(OSError):  # only root can give files away
        os.chown(file, before.st_uid, before.st_gid)
    file.chmod(stat.S_IMODE(before.st_mode))


@contextlib.contextmanager
def _unnamed(folder: Path, mode: int) -> Iterator[int | None]:
    """A new file without a name; None where there are none."""
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
    _rename(aside, path)


def _by_name(path: Path, write: Callable[[Path], object], before: os.stat_result | None, mode: int) -> None:
    aside = _other_name(path)
    os.close(os.open(aside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode))
    try:
        write(aside)
        _take_rights(aside, before)
    except BaseException:
        aside.unlink(missing_ok=True)
        raise
    _rename(aside, path)


def _rename(aside: Path, path: Path) -> None:
    try:
        aside.replace(path)
    except BaseException:
        aside.unlink(missing_ok=True)
        raise


def _other_name(path: Path) -> Path:
    return path.with_name(f".{path.stem}{secrets.token_hex(8)}{path.suffix}")
