"""Compiles coal_loop.cpp against the installed coal, and loads it.

In: nothing but what is installed: a C++ compiler, coal's headers and library, Eigen's headers. Out: the library's
functions. The compiled file is kept in the disk cache; its name depends on the source, the compiler's command and
coal's version. A private copy of it is loaded.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import platform
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from plannercheck.common.cache import cache_folder, read_cached, write_to_cache
from plannercheck.common.errors import PlannercheckError

_SOURCE = Path(__file__).with_name("coal_loop.cpp")
_HEADER = Path(__file__).with_name("coal_shapes.hpp")
# EIGEN_MAX_ALIGN_BYTES is what coal's own library was built with: wider instructions would align its types otherwise.
_FLAGS = ("-std=c++17", "-O3", "-DNDEBUG", "-DEIGEN_MAX_ALIGN_BYTES=16", "-DCOAL_HAS_OCTOMAP", "-shared", "-fPIC")
_OCTOMAP = (
    "-DCOAL_HAVE_OCTOMAP",
    "-DOCTOMAP_MAJOR_VERSION=1",
    "-DOCTOMAP_MINOR_VERSION=10",
    "-DOCTOMAP_PATCH_VERSION=0",
)
# Where Eigen's headers may be, beside those of coal's prefix.
_EIGEN = ("/usr/include/eigen3", "/usr/local/include/eigen3", "/opt/homebrew/include/eigen3")
_COMPILERS = ("c++", "g++", "clang++")
# Seconds that compiling may take, far above the ten that it does.
_PATIENCE = 600


@cache
def library() -> ctypes.CDLL:
    """The compiled loop.

    Raises:
        PlannercheckError: If a compiler, coal's headers or Eigen's are missing, or compiling fails.
    """
    prefix = _coal_prefix()
    command = [_compiler(), *_FLAGS, *_OCTOMAP, *_native(), "-isystem", str(prefix / "include")]
    command += ["-isystem", str(_eigen(prefix)), str(_SOURCE), f"-L{prefix / 'lib'}", "-lcoal"]
    command += [f"-Wl,-rpath,{prefix / 'lib'}"]
    texts = (_SOURCE.read_bytes(), _HEADER.read_bytes(), repr(command).encode(), _coal_version().encode())
    key = hashlib.sha256(b"".join(texts)).hexdigest()
    folder, name = cache_folder(), f"coal_loop_{key}.so"
    found = None if folder is None else read_cached(folder / name)
    with tempfile.TemporaryDirectory(prefix="plannercheck-") as private:
        file = Path(private) / name
        if found is None:
            _compile(command, file)
        else:
            file.write_bytes(found)
        if found is None and folder is not None:
            write_to_cache(folder / name, file.read_bytes())
        return _declared(ctypes.CDLL(str(file)))


def _compile(command: list[str], file: Path) -> None:
    try:
        done = subprocess.run([*command, "-o", str(file)], capture_output=True, text=True, timeout=_PATIENCE)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise PlannercheckError(f"the loop around coal can't be compiled: {error}") from error
    if done.returncode:
        first = next((line for line in done.stderr.splitlines() if "error" in line), done.stderr[-200:])
        raise PlannercheckError(f"the loop around coal does not compile: {first.strip()}")


def _coal_prefix() -> Path:
    """The folder with include/coal and lib of the installed coal."""
    try:
        import coal
    except ImportError as error:
        raise PlannercheckError("coal is not installed") from error
    for folder in Path(coal.__file__).resolve().parents:
        if (folder / "include" / "coal" / "collision.h").exists():
            return folder
    raise PlannercheckError(f"coal at {coal.__file__} came without its headers: pip install coal brings them")


def _coal_version() -> str:
    import coal

    return str(coal.__version__)


def _eigen(prefix: Path) -> Path:
    for folder in (prefix / "include" / "eigen3", *map(Path, _EIGEN)):
        if (folder / "Eigen" / "Core").exists():
            return folder
    raise PlannercheckError("Eigen's headers are missing: pip install 'plannercheck[bench]', or cmeel-eigen alone")


def _compiler() -> str:
    wished = os.environ.get("CXX")
    for name in (wished,) if wished else _COMPILERS:
        if (found := shutil.which(name)) is not None:
            return found
    raise PlannercheckError(f"there is no C++ compiler: looked for {wished or ', '.join(_COMPILERS)}")


def _native() -> tuple[str, ...]:
    """All instructions of this machine, where compilers agree on how to say so."""
    return ("-march=native",) if platform.machine() in ("x86_64", "AMD64") else ()


def _declared(found: ctypes.CDLL) -> ctypes.CDLL:
    """The functions of coal_loop.cpp with their types."""
    doubles, ints, longs, flags = (
        np.ctypeslib.ndpointer(kind, flags="C_CONTIGUOUS") for kind in (np.float64, np.int32, np.int64, np.uint8)
    )
    pointer, count, verdicts = ctypes.c_void_p, ctypes.c_int, np.ctypeslib.ndpointer(np.bool_, flags="C_CONTIGUOUS")
    types: dict[str, tuple[Any, list[Any]]] = {
        "new": (pointer, []),
        "delete": (None, [pointer]),
        "error": (ctypes.c_char_p, [pointer]),
        "add_shape": (count, [pointer, count, doubles, doubles, count, ints, count]),
        "set": (count, [pointer, count, ints, flags, doubles, count, ints]),
        "pose": (pointer, [pointer, doubles, ctypes.c_int64]),
        "unpose": (None, [pointer]),
        "check": (count, [pointer, pointer, longs, ctypes.c_int64, count, count, count, verdicts]),
        "check_pairs": (count, [pointer, pointer, count, count, count, verdicts]),
    }
    for name, (result, arguments) in types.items():
        function = getattr(found, f"coal_loop_{name}")
        function.restype, function.argtypes = result, arguments
    return found
