"""Finds the files of addresses: paths, `file:` URIs, and `package://NAME/...` by the package's name.

In: an address, folders to look in. Out: a path. A package is a folder with a package.xml that names it, or a folder of
that name. The search order: the given folders and those above the file; packages within the given folders, and beside
the folders above the file; those on ROS_PACKAGE_PATH; those installed under AMENT_PREFIX_PATH. Symbolic links are
followed, since colcon workspaces are made of them. The package's name is often not its folder's name. URIs are
percent-encoded (RFC 3986), paths are not.
"""

from __future__ import annotations

import itertools
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from urllib.parse import unquote

from plannercheck.common.package_data import is_file, is_folder

PACKAGE_SCHEMES = ("package://", "model://")
_FILE = re.compile(r"file:(//(localhost(?=/))?)?")  # RFC 8089: file:/path, file:///path, file://localhost/path
_OTHER_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+):/")
_NAME = re.compile(rb"<name>\s*([^<\s]+)\s*</name>")
_MANIFEST = "package.xml"

# Workspaces are src/repository/package; some have a folder more. Most folders that are looked into for one workspace.
_DEPTH, _MOST_FOLDERS = 4, 20_000


def folders_above(path: Path) -> list[Path]:
    """The folders above a file, nearest first: as it is named, and where symbolic links lead."""
    return list(dict.fromkeys([*path.absolute().parents, *path.resolve().parents]))


def package_file(address: str, folders: Sequence[Path], above: Sequence[Path] = ()) -> Path | None:
    """The file of an address, None if there is none: package://NAME/..., model://NAME/..., file:..., or a path.

    It is sought in folders that contain packages, or are packages, and in those above the file that names it.
    """
    scheme = next((each for each in PACKAGE_SCHEMES if address.startswith(each)), None)
    if scheme is None:
        paths = file_paths(address)
        return _first(folder / path for folder in (Path(), *folders, *above) for path in paths)
    name, _, encoded = address.removeprefix(scheme).partition("/")
    rests = _decoded(encoded)
    found = _first(folder / name / rest for folder in (*folders, *above) for rest in rests)
    return found or _first(package / rest for package in _packages(name, folders, above) for rest in rests)


def file_paths(address: str) -> tuple[str, ...]:
    """The paths that an address without a package may mean: a path as it stands, a `file:` URI first decoded."""
    found = _FILE.match(address)
    return (address,) if found is None else _decoded(address[found.end() :])


def address_hint(address: str) -> str:
    """What is unusual about an address that leads nowhere, as a clause; empty if nothing is."""
    scheme = _OTHER_SCHEME.match(address)
    if scheme is not None and not address.startswith((*PACKAGE_SCHEMES, "file:")):
        return f", since '{scheme[1]}:' is none of package://, model:// and file:"
    return ", since it has backslashes: write / in their place" if "\\" in address else ""


def package_folder(name: str, folders: Sequence[Path], above: Sequence[Path] = ()) -> Path | None:
    """The folder of a package; arguments as of `package_file`."""
    near = (folder / name for folder in (*folders, *above))
    return next((each for each in itertools.chain(near, _packages(name, folders, above)) if is_folder(each)), None)


def where_sought(folders: Sequence[Path]) -> str:
    """Words for where a package was looked for, and what to do."""
    listed = ", ".join(map(str, folders)) or "none given"
    paths = " and ".join(
        f"{key} ({os.environ.get(key) or 'not set'})" for key in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")
    )
    return (
        f"Searched were the folders above the file, package_dirs ({listed}), {paths}: package://NAME/... needs the "
        "folder that contains NAME, or a folder whose package.xml calls it so, from package_dirs= (--package-dirs) or "
        "the robot YAML's package_dirs"
    )


def _decoded(encoded: str) -> tuple[str, ...]:
    """The path of a URI, then what stands there, for files whose names have a percent sign."""
    return tuple(dict.fromkeys((unquote(encoded, errors="surrogateescape"), encoded)))


def _first(paths: Iterable[Path]) -> Path | None:
    return next((path for path in paths if is_file(path)), None)


def _packages(name: str, folders: Sequence[Path], above: Sequence[Path]) -> Iterator[Path]:
    yield from (folder for folder in above if _is_named(folder, name))
    for folder in folders:
        yield from _within(folder, name)
    for folder in above[:_DEPTH]:
        yield from (each for each in _children(folder) if _is_named(each, name))
    for folder in _listed("ROS_PACKAGE_PATH"):
        yield folder / name
        yield from _within(folder, name)
    for prefix in _listed("AMENT_PREFIX_PATH"):
        yield prefix / "share" / name


def _listed(variable: str) -> list[Path]:
    return [Path(folder) for folder in os.environ.get(variable, "").split(os.pathsep) if folder]


def _within(folder: Path, name: str) -> Iterator[Path]:
    """Packages of that name in a folder; a package holds no others."""
    level, seen = [folder], {os.path.realpath(folder)}
    for _ in range(_DEPTH + 1):
        below: list[Path] = []
        for each in level:
            if is_file(each / _MANIFEST):
                if _is_named(each, name):
                    yield each
                continue
            for child in _children(each):
                real = os.path.realpath(child)
                if real not in seen and len(seen) < _MOST_FOLDERS:
                    seen.add(real)
                    below.append(child)
        level = below


def _children(folder: Path) -> list[Path]:
    """The folders in a folder, hidden ones left out; none if nobody may look."""
    try:
        return sorted(each for each in folder.iterdir() if not each.name.startswith(".") and is_folder(each))
    except OSError:
        return []


def _is_named(folder: Path, name: str) -> bool:
    try:
        found = _NAME.search((folder / _MANIFEST).read_bytes())
    except OSError:
        return False
    return found is not None and found[1].decode("utf-8", "replace") == name
