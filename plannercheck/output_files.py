"""Output files that appear whole or not at all.

In: a path and a function that writes. Out: the file, written aside in the same folder, then renamed.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from plannercheck.errors import PlannercheckError


def written_aside(path: Path, write: Callable[[Path], object]) -> None:
    """Lets a function write a file beside `path`, then renames it.

    Args:
        path: Where the file shall be; its folder must exist.
        write: Called with the path to write to.

    Raises:
        PlannercheckError: If the file can't be written; then `path` is as it was.
    """
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}", suffix=path.suffix)
        os.close(handle)
        aside = Path(name)
        try:
            write(aside)
            aside.chmod(0o666 & ~_umask())
            aside.replace(path)
        except BaseException:
            aside.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise PlannercheckError(f"file {str(path)!r} can't be written: {error.strerror or error}") from None


def _umask() -> int:
    """The mask of new files' rights, which a temporary file does not follow by itself."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
