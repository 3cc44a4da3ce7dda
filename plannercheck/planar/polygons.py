"""The intersection test for convex polygons in the plane (paper, section "Algorithm in the plane").

In: polygons as arrays of vertices (n, 2) in the order of the boundary, either way round, and poses in SE(2) as matrices
(3, 3). Out: exact verdicts, touching included, in O(log n + log m) and with no preparation. The algorithm is in
cpp/planar/polygon_test; every call is a batch call of the core.

Points (n = 1), segments (n = 2) and runs of vertices on a line are allowed. The caller has to ensure convexity. The
test reads only a logarithmic part of the vertices. So a scan of all vertices comes first: it drops repeated vertices,
and refuses numbers that are not finite. `scan=False` skips the scan; `Polygons` are scanned once for many calls.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Bools, Floats, Ints
from plannercheck.common.arrays import axes, named_numbers, read_only, read_only_copy
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.public_names import set_module
from plannercheck.planar.convexity import convexity_fault

Method: TypeAlias = Literal["filtered", "double_double", "exact"]
METHODS: tuple[Method, ...] = ("filtered", "double_double", "exact")

# The largest ||M^T M - 1|| of a pose; beyond it the numbers are a mistake.
LARGEST_DEFECT = 1e-6

# VertexFault in cpp/bindings/bind_polygons.cpp.
_SOUND, _REPEATED, _NOT_FINITE = 0, 1, 2

_IDENTITY = read_only(np.eye(3)[None])


@set_module("plannercheck.planar")
class Polygons:
    """Polygons checked once, for many calls of the batch functions.

    Attributes:
        vertices: Read-only copies (n, 2), in the order given.
    """

    def __init__(self, polygons: Sequence[ArrayLike], *, validate: bool = False) -> None:
        """Takes polygons.

        Args:
            polygons: Vertices (n, 2) each, m.
            validate: Whether to check, exactly and in linear time, that all are convex.
        """
        if not isinstance(polygons, Sequence | np.ndarray):
            raise PlannercheckError(f"polygons must be several (n, 2), not {polygons!r:.80}")
        given = (checked_polygon(polygon, f"polygon {k}", validate) for k, polygon in enumerate(polygons))
        self.vertices = tuple(read_only_copy(polygon) for polygon in given)
        self.core = core.PolygonList(list(self.vertices))

    def __len__(self) -> int:
        return len(self.vertices)


Several: TypeAlias = ArrayLike | Sequence[ArrayLike] | Polygons


@set_module("plannercheck.planar")
@dataclass(frozen=True, eq=False)
class Counts:
    """Verdicts on n pairs, and the work for each.

    Attributes:
        shared: (n,) whether the pair shares a point.
        rounds: (n,) rounds of the algorithm; each but the last drops half of a chain.
        vertices: (n,) vertices read, repetitions counted.
        double_double: (n,) signs that doubles left open.
        exact: (n,) signs that double-double also left open.
    """

    shared: Bools
    rounds: Ints
    vertices: Ints
    double_double: Ints
    exact: Ints


@set_module("plannercheck.planar")
def intersects(
    A: ArrayLike,
    B: ArrayLike,
    pose_a: ArrayLike | None = None,
    pose_b: ArrayLike | None = None,
    *,
    validate: bool = False,
    scan: bool = True,
    method: Method = "filtered",
) -> bool:
    """Whether two posed convex polygons share a point; touching counts.

    Args:
        A: Vertices (n, 2) in order, m.
        B: Vertices (m, 2) in order, m.
        pose_a: Pose (3, 3) of A in the world, m; None is the identity. Used as the affine map that its doubles give.
        pose_b: Pose (3, 3) of B in the world, m.
        validate: Whether to check first, exactly and in linear time, that both are convex.
        scan: Whether to scan all vertices first. False requires that none is repeated and all are finite; else the
            verdict means nothing.
        method: The arithmetic in which signs are first computed: "filtered" (doubles), "double_double" or "exact".
            Verdicts do not depend on it.

    Returns:
        The exact verdict for the given numbers.

    Raises:
        PlannercheckError: If an array is no polygon, a pose is not rigid, or `validate` finds a fault.
    """
    a, b = (core.PolygonList([checked_polygon(P, name, validate, scan)]) for P, name in ((A, "A"), (B, "B")))
    poses = checked_poses(pose_a, "pose_a"), checked_poses(pose_b, "pose_b")
    return bool(_run(a, poses[0], b, poses[1], 1, method, False)[0][0])


@set_module("plannercheck.planar")
def intersects_batch(
    A: Several,
    B: Several,
    poses_a: ArrayLike | None = None,
    poses_b: ArrayLike | None = None,
    *,
    scan: bool = True,
    method: Method = "filtered",
) -> Bools:
    """Whether polygons share a point, for n pairs in one call of the core.

    Args:
        A: One polygon (n, 2) for all pairs, or a sequence of them, or `Polygons`. float64 arrays in C order are not
            copied.
        B: The same for the other side.
        poses_a: One pose (3, 3), or n of them (n, 3, 3); None is the identity.
        poses_b: The same for the other side.
        scan: As for `intersects`; `Polygons` have been scanned.
        method: As for `intersects`.

    Returns:
        (n,) exact verdicts; n is the length of the arguments that are sequences.
    """
    return np.asarray(_run(*_batch(A, B, poses_a, poses_b, scan), method, False)[0]).astype(bool)


@set_module("plannercheck.planar")
def count_batch(
    A: Several,
    B: Several,
    poses_a: ArrayLike | None = None,
    poses_b: ArrayLike | None = None,
    *,
    scan: bool = True,
    method: Method = "filtered",
) -> Counts:
    """Like `intersects_batch`, with counters for each pair."""
    shared, counted = _run(*_batch(A, B, poses_a, poses_b, scan), method, True)
    return Counts(np.asarray(shared).astype(bool), *np.ascontiguousarray(counted.T))


def checked_polygon(vertices: ArrayLike, name: str = "polygon", validate: bool = False, scan: bool = True) -> Floats:
    """A polygon as the core takes it.

    Args:
        vertices: (n, 2), m.
        name: For errors.
        validate: Whether to check finiteness and convexity, exactly.
        scan: Whether to check finiteness, and to drop a vertex equal to the one before; `validate` refuses these.

    Returns:
        The same array if it has float64 in C order; without the last vertex if that repeats the first.
    """
    array = named_numbers(vertices, name)
    if array.ndim != 2 or array.shape[1] != 2 or not len(array):
        raise PlannercheckError(f"{name} must be vertices (n, 2) with n > 0, not of shape {array.shape}")
    fault = core.vertex_fault(array) if scan and not validate else _SOUND
    if fault == _NOT_FINITE:
        row = int(np.argmin(np.isfinite(array).all(axis=1)))
        raise PlannercheckError(f"{name}: vertex {row} is {array[row].tolist()}, it must be finite")
    if fault == _REPEATED:
        array = array[core.repeated_vertices(array) == 0]
    if core.is_closed(array):
        array = array[:-1]
    bent = convexity_fault(array) if validate else None
    if bent is not None:
        raise PlannercheckError(f"{name} is no convex polygon: {bent}")
    return array


def checked_poses(poses: ArrayLike | None, name: str) -> Floats:
    """Poses (n, 3, 3) of SE(2), n = 1 for one pose or None, the identity; m. An error says what is wrong.

    It may be the given array itself, so a caller who keeps it has to copy it.
    """
    if poses is None:
        return _IDENTITY
    array = named_numbers(poses, name)
    if array.ndim == 2:
        array = array[None]
    if array.ndim != 3 or array.shape[1:] != (3, 3):
        raise PlannercheckError(f"{name} must be (3, 3) or (n, 3, 3), not of shape {np.shape(poses)}")
    if not core.are_affine(array):
        raise PlannercheckError(f"{name}: the last row of a pose must be 0, 0, 1")
    bad = core.first_bent_pose(array, LARGEST_DEFECT)
    if bad >= 0:
        raise PlannercheckError(f"{name} must be rigid up to {LARGEST_DEFECT:g} and finite, not {array[bad].tolist()}")
    return array


def _batch(
    A: Several,
    B: Several,
    poses_a: ArrayLike | None,
    poses_b: ArrayLike | None,
    scan: bool,
) -> tuple[Any, Floats, Any, Floats, int]:
    (a, count_a), (b, count_b) = _polygons(A, "A", scan), _polygons(B, "B", scan)
    matrices_a, matrices_b = checked_poses(poses_a, "poses_a"), checked_poses(poses_b, "poses_b")
    n = _pairs(A=count_a, B=count_b, poses_a=len(matrices_a), poses_b=len(matrices_b))
    return a, matrices_a, b, matrices_b, n


def _polygons(given: Several, name: str, scan: bool) -> tuple[Any, int]:
    """The core's list of polygons for one call, without copying arrays; and their number."""
    if isinstance(given, Polygons):
        return given.core, len(given)
    if isinstance(given, list | tuple) and (not given or axes(given[0]) not in (0, 1)):
        several: Sequence[ArrayLike] = given
    else:
        array = named_numbers(given, name)  # type: ignore[arg-type]  # no list of several
        several = list(array) if array.ndim == 3 else [array]
    with error_context(name):
        arrays = [checked_polygon(polygon, f"polygon {k}", scan=scan) for k, polygon in enumerate(several)]
    return core.PolygonList(arrays), len(arrays)


def _pairs(**lengths: int) -> int:
    """The number of pairs; each of the lengths is 1 or that number."""
    several = {length for length in lengths.values() if length != 1}
    if len(several) > 1:
        given = ", ".join(f"{name}: {length}" for name, length in lengths.items())
        raise PlannercheckError(f"polygons and poses must be single or equally many; given are {given}")
    return several.pop() if several else 1


def _run(a: Any, poses_a: Floats, b: Any, poses_b: Floats, n: int, method: Method, count: bool) -> tuple[Ints, Ints]:
    if method not in METHODS:
        raise unknown_name("method", method, METHODS)
    try:
        found: tuple[Ints, Ints] = core.planar_intersect_batch(
            a, poses_a, b, poses_b, n, getattr(core.Precision, method), count
        )
    except ValueError as error:
        raise PlannercheckError(str(error)) from None
    return found
