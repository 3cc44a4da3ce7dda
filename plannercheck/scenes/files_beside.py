"""Files that a scene's file names, written beside it before the scene itself.

In: contents that are too large for YAML, each with a hash. Out: `FilesBeside`, which names their files and writes them.
A name has a part of the content's hash, so that saving a scene again never changes a file that the old scene names: a
reader gets the old scene or the new scene.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable, Iterator
from pathlib import Path

from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.package_data import is_file

# How much of an object's name and of the hash is in a file's name.
_LONGEST_NAME, _HASH_BYTES = 40, 8


class FilesBeside:
    """The files of one scene."""

    def __init__(self, scene: Path) -> None:
        """Starts without files, for a scene's file."""
        self.folder = scene.resolve().parent
        self._stem = scene.stem
        self._waiting: dict[Path, Callable[[Path], object]] = {}

    def name(self, owner: str, digest: bytes, suffix: str, write: Callable[[Path], object]) -> str:
        """Takes a content that is to be written, and returns the file's name in the scene's folder.

        The name has what files may have of the owner's name, and the suffix with its dot; the digest is a hash of the
        content. `write` writes it to a path, which may lack the suffix.
        """
        plain = re.sub(r"[^\w-]+", "_", owner, flags=re.ASCII).strip("_")[:_LONGEST_NAME]
        name = ".".join(filter(None, (self._stem, plain, digest[:_HASH_BYTES].hex()))) + suffix
        self._waiting[self.folder / name] = write
        return name

    @contextlib.contextmanager
    def written(self) -> Iterator[None]:
        """Writes all files; those that are new go again if this, or what follows in the context, fails."""
        made: list[Path] = []
        try:
            for path, write in self._waiting.items():
                is_new = not is_file(path)
                write_atomically(path, write)
                made += [path] if is_new else []
            yield
        except (PlannercheckError, OSError, KeyboardInterrupt):
            for path in made:
                path.unlink(missing_ok=True)
            raise
