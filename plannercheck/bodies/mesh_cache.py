"""The objects of large mesh files, cached by the files' content.

In: a file's content and its reader. Out: the reader's result, from the cache if it has read the same content before. A
reader takes about 0.1 s for each MB of text, the cache about 1 ms.
"""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Callable
from typing import Any

import numpy as np

from plannercheck.bodies.mesh_objects import RawObject
from plannercheck.common.cache import cache_folder, read_cached, write_to_cache

# The version of what is cached: another one wherever a reader reads a content otherwise than before.
_VERSION = b"plannercheck mesh 3\n"

# Smaller files are read as fast as they are looked up, in bytes.
_LARGE = 1 << 19

# What a reader gives: objects, and plain numbers and words about the file.
Read = tuple[list[RawObject], list[Any]]


def known_objects(ending: str, content: bytes, read: Callable[[bytes], Read]) -> Read:
    """What a reader, known by the ending of the file's name, gives for a content, on which alone it depends."""
    folder = cache_folder() if len(content) >= _LARGE else None
    if folder is None:
        return read(content)
    path = folder / f"{hashlib.sha256(_VERSION + ending.encode() + content).hexdigest()}.mesh"
    known = read_cached(path)
    if known is not None:
        return _unpacked(known)
    found = read(content)
    write_to_cache(path, _packed(*found))
    return found


def _packed(objects: list[RawObject], about: list[Any]) -> bytes:
    arrays = {f"{kind}{k}": getattr(each, kind) for k, each in enumerate(objects) for kind in ("points", "triangles")}
    words = json.dumps([[each.name for each in objects], about])
    content = io.BytesIO()
    np.savez(content, words=np.array(words), **arrays)
    return content.getvalue()


def _unpacked(content: bytes) -> Read:
    with np.load(io.BytesIO(content), allow_pickle=False) as found:
        names, about = json.loads(str(found["words"]))
        return [RawObject(name, found[f"points{k}"], found[f"triangles{k}"]) for k, name in enumerate(names)], about
