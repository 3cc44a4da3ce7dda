"""coal at its best: a C++ loop over posed states (coal_loop.cpp), compiled when it is first asked for.

In: a checker. Out: a `CoalLoop` over the same hulls and pairs, which judges groups of states whose poses it is given.
The loop is compiled against the headers and the library of the installed coal, and kept in the cache folder. Its name
there depends on its source, the compiler's command and coal's version.

How coal is asked best depends on the states: a guess from the last call helps along a motion, not on random states. So
there are `VARIANTS`, and `fastest` tries them all on the very states that are timed.
"""

from __future__ import annotations

import ctypes
import hashlib
import itertools
import os
import platform
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.polytope_files import cache_folder
from plannercheck.bodies.shapes import Box, Capsule, Cone, Cylinder, Shape, Sphere
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench.timing import seconds_of
from plannercheck.motions.checker import Checker

_SOURCE = Path(__file__).with_name("coal_loop.cpp")
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
# In the order of coal_loop.cpp's `Kind`.
_BOX, _SPHERE, _CAPSULE, _CYLINDER, _CONE, _HULL = range(6)
# In the order of coal's enumerations.
_GJK = ("plain GJK", "Polyak", "Nesterov")
_GUESSES = ("fixed guess", "cached guess", "guess from boxes")
_FILTERS = ("no boxes", "world boxes", "world and body boxes")
# Each variant is tried so often, and the least time counts.
_TRIALS = 3


class Variant(NamedTuple):
    """How the loop asks coal.

    Attributes:
        gjk: 0 plain, 1 with Polyak's acceleration, 2 with Nesterov's.
        guess: Where GJK starts: 0 always alike, 1 where the pair's last call ended, 2 from the bodies' boxes.
        boxes: What is asked first: 0 nothing, 1 boxes along the world's axes, 2 then those in the bodies' frames.
    """

    gjk: int
    guess: int
    boxes: int

    def __str__(self) -> str:
        return f"{_GJK[self.gjk]}, {_GUESSES[self.guess]}, {_FILTERS[self.boxes]}"


# For states of many bodies, most of them far apart.
VARIANTS = tuple(Variant(*choice) for choice in itertools.product((0, 1, 2), (0, 1, 2), (1, 2)))
# For a pair whose last answer says nothing: without the guess that it left.
COLD_VARIANTS = tuple(Variant(*choice) for choice in itertools.product((0, 1, 2), (0, 2), (0, 1)))


@dataclass(frozen=True)
class PosedBodies:
    """Bodies as coal takes them.

    Attributes:
        polytopes: Their hulls, for those that are no simple shape.
        shapes: Their shapes where coal has them as such; else None.
        moves: (k,) which change their poses from state to state.
        pairs: (p, 2) indices; a pair has at least one body that moves.
        names: For errors.
    """

    polytopes: Sequence[Polytope]
    shapes: Sequence[Shape | None]
    moves: Bools
    pairs: NDArray[Any]
    names: Sequence[str]


class CoalStates:
    """States whose poses coal has; freed with the object."""

    def __init__(self, loop: CoalLoop, poses: Floats) -> None:
        """Takes the poses (n, bodies, 4, 4), m."""
        self.count = len(poses)
        self._library = loop.library
        self.handle = ctypes.c_void_p(
            loop.library.coal_loop_pose(loop.handle, np.ascontiguousarray(poses, dtype=np.float64), len(poses))
        )

    def __del__(self) -> None:
        self._library.coal_loop_unpose(self.handle)


class CoalLoop:
    """A loop over posed states in C++."""

    def __init__(self, bodies: PosedBodies, placed: Floats) -> None:
        """Hands bodies and pairs to coal.

        Args:
            bodies: The bodies.
            placed: (k, 4, 4) poses, m, of which those of bodies that stand still are kept.

        Raises:
            PlannercheckError: If there is no compiler, or coal has no shape for a body.
        """
        self.library = library()
        self.handle = ctypes.c_void_p(self.library.coal_loop_new())
        shape_of: dict[int, int] = {}
        indices = [shape_of.setdefault(id(p), len(shape_of)) for p in bodies.polytopes]  # equal shapes are one
        for k in np.unique(indices, return_index=True)[1].tolist():
            self._add(bodies.polytopes[k], bodies.shapes[k], bodies.names[k])
        self._checked(
            self.library.coal_loop_set(
                self.handle,
                len(indices),
                np.array(indices, dtype=np.int32),
                np.ascontiguousarray(bodies.moves, dtype=np.uint8),
                np.ascontiguousarray(placed, dtype=np.float64),
                len(bodies.pairs),
                np.ascontiguousarray(bodies.pairs, dtype=np.int32),
            ),
            "these pairs",
        )

    @classmethod
    def of_checker(cls, checker: Checker) -> CoalLoop:
        """The loop over a checker's pairs; bodies in no pair are left out."""
        used = np.unique(checker.pairs).tolist()
        index = {body: k for k, body in enumerate(used)}
        polytopes = [p for body in used if (p := checker.polytopes[body]) is not None]
        assert len(polytopes) == len(used)
        items = [checker.bodies[body] for body in used]
        pairs = np.array([[index[a], index[b]] for a, b in checker.pairs.tolist()], dtype=np.int32).reshape(-1, 2)
        moves = np.array([item.link is not None for item in items])
        bodies = PosedBodies(polytopes, [item.shape for item in items], moves, pairs, [item.name for item in items])
        loop = cls(bodies, checker.body_poses(checker.robot.random_configurations(1, 0))[0][used])
        loop._checker, loop._used = checker, used
        return loop

    _checker: Checker | None = None
    _used: Sequence[int] = ()

    def posed(self, poses: Floats) -> CoalStates:
        """States for `check`, given the poses (n, bodies, 4, 4) of all bodies, m."""
        return CoalStates(self, poses)

    def states(self, q: Floats) -> CoalStates:
        """States for `check`, given configurations (n, nq) of the checker's robot."""
        assert self._checker is not None
        return self.posed(self._checker.body_poses(q)[:, list(self._used)])

    def check(self, states: CoalStates, variant: Variant, ends: NDArray[np.int64] | None = None) -> Bools:
        """Which groups of states are free.

        Args:
            states: All states, group by group.
            variant: How coal is asked.
            ends: (groups,) where each group ends; None takes each state for itself.

        Returns:
            (groups,) True means free.
        """
        groups = np.arange(1, states.count + 1) if ends is None else np.ascontiguousarray(ends, dtype=np.int64)
        free = np.empty(len(groups), dtype=bool)
        self._checked(
            self.library.coal_loop_check(self.handle, states.handle, groups, len(groups), *variant, free),
            "these states",
        )
        return free

    def fastest(
        self, states: CoalStates, ends: NDArray[np.int64] | None = None, variants: Sequence[Variant] = VARIANTS
    ) -> tuple[Variant, float]:
        """The variant that judges these states fastest, and its seconds; each is tried several times by turns."""
        best = dict.fromkeys(variants, float("inf"))
        for _ in range(_TRIALS):
            for variant in variants:
                spent = seconds_of(lambda variant=variant: self.check(states, variant, ends))  # type: ignore[misc]
                best[variant] = min(best[variant], spent)
        chosen = min(best, key=best.__getitem__)
        return chosen, best[chosen]

    def _add(self, polytope: Polytope, shape: Shape | None, name: str) -> None:
        kind, numbers = _simple(shape)
        if kind == _HULL and polytope.dimension < 3:
            raise PlannercheckError(f"coal has no shape for {name}, which has no volume")
        points = np.ascontiguousarray(polytope.vertices, dtype=np.float64)
        faces = np.ascontiguousarray(polytope.faces if kind == _HULL else np.zeros((0, 3)), dtype=np.int32)
        given = np.array([*numbers, 0.0, 0.0, 0.0])
        done = self.library.coal_loop_add_shape(self.handle, kind, given, points, len(points), faces, len(faces))
        self._checked(done, name)

    def _checked(self, failed: int, what: str) -> None:
        if failed:
            reason = self.library.coal_loop_error(self.handle).decode(errors="replace")
            raise PlannercheckError(f"coal refuses {what}: {reason}")

    def __del__(self) -> None:
        if hasattr(self, "handle"):
            self.library.coal_loop_delete(self.handle)


def _simple(shape: Shape | None) -> tuple[int, tuple[float, ...]]:
    """The kind and the lengths of a shape that coal has without a polytope around it."""
    match shape:
        case Box(size=size):
            return _BOX, size
        case Sphere(radius=radius):
            return _SPHERE, (radius,)
        case Capsule(radius=radius, length=length):
            return _CAPSULE, (radius, length)
        case Cylinder(radius=radius, length=length):
            return _CYLINDER, (radius, length)
        case Cone(radius=radius, length=length):
            return _CONE, (radius, length)
    return _HULL, ()


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
    key = hashlib.sha256(_SOURCE.read_bytes() + repr(command).encode() + _coal_version().encode()).hexdigest()
    folder = cache_folder() or Path(tempfile.mkdtemp(prefix="plannercheck-"))
    file = folder / "bench" / f"coal_loop_{key[:16]}.so"
    if not file.exists():
        _compile(command, file)
    return _declared(ctypes.CDLL(str(file)))


def _compile(command: list[str], file: Path) -> None:
    """Runs the compiler; the file appears whole or not at all."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=file.parent) as folder:
            aside = Path(folder) / file.name
            done = subprocess.run([*command, "-o", str(aside)], capture_output=True, text=True, timeout=_PATIENCE)
            if done.returncode:
                first = next((line for line in done.stderr.splitlines() if "error" in line), done.stderr[-200:])
                raise PlannercheckError(f"the loop around coal does not compile: {first.strip()}")
            aside.replace(file)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise PlannercheckError(f"the loop around coal can't be compiled: {error}") from error


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
    }
    for name, (result, arguments) in types.items():
        function = getattr(found, f"coal_loop_{name}")
        function.restype, function.argtypes = result, arguments
    return found
