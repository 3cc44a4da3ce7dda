"""The files that go into a compiled MJCF model, and where the compiled model is cached: by the content of all of them.

In: the path of an MJCF file. Out: a file of the cache, or None if the files are not known for sure. MuJoCo takes a name
in an attribute `file` from the model's folder or the including file's, from `meshdir`, `texturedir` or `assetdir`, with
the name's own folder or without it (`strippath`). This module does not decide between them: every place where a file
may be is part of the key, with its content or as empty, so that a model is compiled again if any of them changes.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import os
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from xml.etree import ElementTree

from plannercheck.common.cache import cache_folder

# The version of what is cached; a new one makes all that was cached before unknown.
_VERSION = b"plannercheck compiled MJCF 1\n"

# The attributes that name files and folders (MuJoCo's XML reference): a cube map has a file for each side, and URDFs,
# which <model> takes as well, have another word.
_FILES = ("file", "filename", "fileback", "filedown", "filefront", "fileleft", "fileright", "fileup")
_FOLDERS = ("meshdir", "texturedir", "assetdir")

# What can hold what this reader does not see: other files, or other texts for names.
_UNSEEN = (b"<!DOCTYPE", b"<!ENTITY", b"<extension", b"<plugin")

# More places are not looked at; MuJoCo's models have some hundred.
_MOST_PLACES = 100_000

# Files that name others.
_MODELS = (".xml", ".mjcf", ".urdf")


def compiled_file(path: Path, fields: str) -> Path | None:
    """Where a file's compiled model is cached; None if the cache is off, or if it is not sure which files go in.

    `fields` says what is taken of the model.
    """
    folder = cache_folder()
    if folder is None:
        return None
    try:
        key = _key(path.absolute(), fields)
    except (OSError, ElementTree.ParseError, UnicodeError, ValueError, RecursionError):
        return None  # MuJoCo says what is wrong
    return None if key is None else folder / f"{key}.mjcf"


def _key(path: Path, fields: str) -> str | None:
    """A digest of MuJoCo's version and of all places where files may be, with their contents."""
    places = _places(path)
    if places is None:
        return None
    digest = hashlib.sha256(_VERSION + f"{importlib.metadata.version('mujoco')}\n{fields}\n".encode())
    for place in sorted(places):
        name = os.fsencode(os.path.relpath(place, path.parent))
        content = place.read_bytes() if place.is_file() else None
        state = b"none" if content is None else hashlib.sha256(content).digest()
        digest.update(len(name).to_bytes(8, "little") + name + state)
    return digest.hexdigest()


def _places(path: Path) -> set[Path] | None:
    """All places where a file of the model may be; None if one of the names leads nowhere, or may lead elsewhere."""
    models, read = {path}, set[Path]()
    names, folders = set[str](), {""}
    while models - read:
        for model in models - read:
            content = model.read_bytes()
            if any(unseen in content for unseen in _UNSEEN):
                return None
            for key, value in _attributes(content):
                (folders if key in _FOLDERS else names).add(value)
            read.add(model)
        places = {name: set(_candidates(name, {each.parent for each in read}, folders)) for name in names}
        if sum(map(len, places.values())) > _MOST_PLACES:
            return None
        models |= {p for of in places.values() for p in of if p.suffix.lower() in _MODELS and p.is_file()}
    if not all(any(place.is_file() for place in of) for of in places.values()):
        return None
    return models.union(*places.values())


def _attributes(content: bytes) -> Iterator[tuple[str, str]]:
    """The attributes of a text of XML that name files or folders."""
    for element in ElementTree.fromstring(content).iter():
        for key, value in element.attrib.items():
            if value and key in (*_FILES, *_FOLDERS):
                yield key, value


def _candidates(name: str, bases: set[Path], folders: set[str]) -> Iterator[Path]:
    """Where a file of this name may be."""
    base_name = name.replace("\\", "/").rpartition("/")[2]
    for base, folder, own in product(bases, folders, {name, base_name}):
        yield base / folder / own  # an absolute part stands for all before it
