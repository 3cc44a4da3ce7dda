"""Convex bodies prepared for queries: the exact hull, its hierarchy, and the hierarchy of its polar.

In: vertices in m, with or without faces. Out: `Polytope`, immutable, which can be saved, loaded and pickled; and
`prepared`, which makes one through a disk cache keyed by content. Both are the core's bodies (core_polytopes.py) with
the public names.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.bodies import polytope_files as body_files
from plannercheck.bodies.circumscribed import BOX_SIGNS, prism_faces
from plannercheck.bodies.core_polytopes import LARGEST_COORDINATE, core_polytope, fans, parsed_polytope
from plannercheck.bodies.half_spaces import HalfSpace
from plannercheck.bodies.kinds import Kind, KindTraits, kind_of_shape, traits_of
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.polytope_files import GivenFaces
from plannercheck.bodies.solids import Solid
from plannercheck.common.array_types import Floats, Ints
from plannercheck.common.arrays import read_only
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError, with_article
from plannercheck.common.public_names import set_module

_NO_ARRAYS: dict[str, NDArray[Any]] = {}


@set_module("plannercheck")
class Polytope:
    """The convex hull of points, preprocessed for logarithmic queries (paper, section "Polyhedra in 3D space").

    Hulls without volume (a polygon, a segment, a point) are bodies as well. With an inflation radius, the body is the
    set of points within that distance of the hull: a ball of a point, a capsule of a segment.

    Attributes:
        vertices: The extreme points (n, 3) in m, read-only.
        faces: Triangles (m, 3) of the hull, counter-clockwise seen from outside: indices into `vertices`, read-only;
            none without volume.
        source: Index of each vertex among the points given (n,), read-only.
    """

    __slots__ = ("__weakref__", "_arrays", "_core")

    _arrays: dict[str, NDArray[Any]]
    _core: Any

    def __init__(
        self,
        vertices: ArrayLike,
        faces: GivenFaces | None = None,
        inflation_radius: float = 0.0,
        name: str = "polytope",
    ) -> None:
        """Computes the exact hull, or verifies given faces exactly; then builds both hierarchies.

        Args:
            vertices: Points (n, 3) in m; or one of our shapes, a trimesh.Trimesh, or a geometry of coal or python-fcl,
                whose convex hull is taken (of a `Solid`, a set of parts or a half-space, that body), without `faces`
                and `inflation_radius`.
            faces: The hull's faces, if they are known: polygons of indices into `vertices`, counter-clockwise seen
                from outside; corners of a face must be exactly coplanar or convex in the order of a fan.
            inflation_radius: The inflation radius, measured in the world, m.
            name: Its name in errors.

        Raises:
            PlannercheckError: If there are no points, they are not finite, the faces do not bound their hull, or the
                inflation radius is negative.
        """
        # Here, since points alone need no readers of meshes and YAML.
        from plannercheck.bodies.given_shapes import is_geometry, points_of_geometry

        if not isinstance(vertices, np.ndarray | list | tuple) and is_geometry(vertices):
            if faces is not None or inflation_radius:
                kind = with_article(type(vertices).__name__)
                raise PlannercheckError(f"{name} is {kind}, which has its own faces and radius")

            def hull() -> Polytope:
                points, radius = points_of_geometry(vertices, name)
                return self._from_core(core_polytope(points, None, radius, name))

            self._adopt(self.of_shape(vertices, 0.0, hull).core)
        else:
            self._adopt(core_polytope(vertices, faces, inflation_radius, name))

    def _adopt(self, body: Any) -> None:
        self._core = body
        self._arrays = _NO_ARRAYS

    def _array(self, name: str) -> NDArray[Any]:
        """An array of the core's, made when first asked for: scenes have bodies that nobody looks at."""
        found = self._arrays.get(name)
        if found is None:
            found = read_only(getattr(self._core, name)())
            self._arrays = self._arrays | {name: found}
        return found

    @property
    def vertices(self) -> Floats:
        """The extreme points (n, 3) in m, read-only."""
        return self._array("vertices")

    @property
    def faces(self) -> Ints:
        """Triangles (m, 3) of the hull, counter-clockwise seen from outside; none without volume."""
        return self._array("triangles")

    @property
    def source(self) -> Ints:
        """Index of each vertex among the points given (n,), read-only."""
        return self._array("source")

    @classmethod
    def _from_core(cls, body: Any) -> Polytope:
        polytope = cls.__new__(cls)
        polytope._adopt(body)
        return polytope

    @property
    def core(self) -> Any:
        """The compiled body, for the rest of the library."""
        return self._core

    @property
    def kind(self) -> Kind:
        """What the body is: the hull of its vertices, or a solid, a set of parts or a half-space, as `of_…` make it."""
        kind: Kind = self._core.kind
        return kind

    @property
    def traits(self) -> KindTraits:
        """What follows from its kind."""
        return traits_of(self._core.kind)

    def _shape_if(self, kind: Kind) -> Any | None:
        return self._core.shape if self._core.kind == kind else None

    @property
    def solid(self) -> Any | None:
        """The compiled solid whose set the body is; None if it is none."""
        return self._shape_if("solid")

    @property
    def parts(self) -> Any | None:
        """The compiled set of parts whose union the body is; None if it is none, see `PointCloud` and its like."""
        return self._shape_if("part_set")

    @property
    def half_space(self) -> tuple[tuple[float, float, float], float] | None:
        """Normal and offset of the half-space that the body is, whose vertices are those of a cube; None if none."""
        return self._shape_if("half_space")

    @classmethod
    def of_shape(cls, shape: Any, inflation_radius: float, hull: Callable[[], Polytope] | None = None) -> Polytope:
        """The body of a shape.

        Args:
            shape: One of our shapes.
            inflation_radius: Inflation radius of a set of parts or a half-space, m.
            hull: Makes the hull of any other shape, with its inflation radius; not needed for those two.
        """
        return _ROWS[kind_of_shape(shape)].of_shape(shape, inflation_radius, hull)

    @classmethod
    def of_half_space(cls, half_space: HalfSpace, inflation_radius: float = 0.0) -> Polytope:
        """The body of a half-space, with an inflation radius in m."""
        normal, offset = half_space.scaled
        return cls._from_core(core.Polytope.of_half_space(np.array(normal), offset, inflation_radius))

    @classmethod
    def of_parts(cls, parts: PartSet, inflation_radius: float = 0.0) -> Polytope:
        """The body of a set of parts that is not empty, with an inflation radius in m; its hull is a box around it."""
        return cls._from_core(parts.core.body(inflation_radius))

    def of_solid(self, solid: Solid) -> Polytope:
        """A solid's body, given its hull, whose inflation radius it has; the hull itself if the solid is its hull."""
        return self if solid.equals_hull else self._from_core(self._core.with_solid(solid.core))

    @property
    def centre(self) -> Floats:
        """The interior point (3,) in m about which the polar is taken."""
        return np.asarray(self._core.centre()[0])

    @property
    def dimension(self) -> int:
        """The hull's dimension: 3, 2 for a polygon, 1 for a segment, 0 for a point."""
        return int(self._core.dimension)

    @property
    def inflation_radius(self) -> float:
        """Distance in m around the hull that belongs to the body."""
        return float(self._core.inflation_radius)

    def without_cells(self) -> Polytope:
        """The same body; extreme vertices are then searched in the hierarchies only, as in the paper: O(log n).

        Otherwise cells of directions list the few vertices that may be extreme (cpp/bodies/direction_cells.hpp), with
        the same results.
        """
        return self._from_core(self._core.without_cells())

    @property
    def nbytes(self) -> int:
        """Memory of the prepared body in bytes."""
        return int(self._core.bytes()) + int(getattr(self._core.shape, "nbytes", 0))

    def statistics(self) -> dict[str, Any]:
        """Sizes of the hull, of both hierarchies (levels, longest chain, fans, bytes), and of the body."""
        return {
            "vertices": len(self.vertices),
            "facets": self._core.facets,
            "inner": dict(self._core.inner_shape()),
            "polar": dict(self._core.polar_shape()),
            "bytes": self.nbytes,
        }

    def extreme(self, directions: ArrayLike) -> Ints:
        """The vertex furthest along each direction.

        Args:
            directions: (k, 3) in the body's frame.

        Returns:
            Indices into `vertices` (k,); exact for the given doubles.

        Raises:
            PlannercheckError: If the directions are not finite numbers of shape (k, 3).
        """
        return np.asarray(self._core.extremes(_checked_directions(directions), False)[0])

    def fault(self) -> str:
        """Names the first broken invariant of hull, polar or hierarchies; empty if all hold (slow)."""
        return str(self._core.fault())

    def save(self, path: str | Path) -> None:
        """Writes the prepared body, if it is a hull, to a file (magic, version, content hash, data)."""
        if not self.traits.fills_hull:
            what = with_article(self.kind.replace("_", "-"))
            raise PlannercheckError(f"files of prepared bodies hold hulls, this is {what}: pickle it")
        body_files.write(Path(path), self._core.serialise())

    @classmethod
    def load(cls, path: str | Path) -> Polytope:
        """Reads a prepared body.

        Args:
            path: A file written by `save`.

        Raises:
            PlannercheckError: If the file is missing, of another kind or version, cut short or changed.
        """
        return cls._from_bytes(body_files.read(Path(path)))

    @classmethod
    def _from_bytes(cls, data: bytes, *solid: Any) -> Polytope:
        body = parsed_polytope(data)
        return cls._from_core(body.with_solid(core.Solid(*solid)) if solid else body)

    def __reduce__(self) -> tuple[Any, ...]:
        return _ROWS[self.kind].pickled(self._core)

    def __repr__(self) -> str:
        if not self.traits.is_bounded:
            return f"Polytope(half-space {self._core.shape[0]} · x <= {self._core.shape[1]})"
        return f"Polytope({len(self.vertices)} vertices, {self._core.facets} facets)"


def _body_of_parts(kind: str, arrays: tuple[Any, ...], inflation_radius: float) -> Polytope:
    """A pickled body of a set of parts: what one of the core's makers was given."""
    return Polytope._from_core(getattr(core.PartSet, kind)(*arrays).body(inflation_radius))


def _body_of_half_space(normal: tuple[float, float, float], offset: float, inflation_radius: float) -> Polytope:
    return Polytope.of_half_space(HalfSpace(normal, offset), inflation_radius)


class _Row(NamedTuple):
    """What differs by a body's kind: how a shape with a radius and a hull becomes one, and how it is pickled."""

    of_shape: Callable[[Any, float, Any], Polytope]
    pickled: Callable[[Any], tuple[Any, ...]]


_ROWS: dict[Kind, _Row] = {
    "hull": _Row(lambda _, __, hull: hull(), lambda body: (Polytope._from_bytes, (body.serialise(),))),
    "solid": _Row(
        lambda solid, _, hull: hull().of_solid(solid),
        lambda body: (Polytope._from_bytes, (body.serialise(), body.shape.points(), body.shape.triangles())),
    ),
    "part_set": _Row(
        lambda parts, radius, _: Polytope.of_parts(parts, radius),
        lambda body: (_body_of_parts, (*body.shape.state(), body.inflation_radius)),
    ),
    "half_space": _Row(
        lambda half_space, radius, _: Polytope.of_half_space(half_space, radius),
        lambda body: (_body_of_half_space, (*body.shape, body.inflation_radius)),
    ),
}


def polytopes_of_boxes(sizes: Floats, inflation_radii: Floats) -> list[Polytope | None]:
    """The polytopes of boxes of sizes (n, 3) and inflation radii (n,), m, without looking at their corners one by one.

    The same as `Polytope` gives for each; None where that may refuse the box, or where the box has no volume.
    """
    out: list[Polytope | None] = [None] * len(sizes)
    largest = np.maximum(sizes.max(axis=1, initial=0.0) / 2, inflation_radii)
    usable = np.flatnonzero((largest <= LARGEST_COORDINATE) & (sizes > 0).all(axis=1))
    made = core.Polytope.of_boxes(
        np.ascontiguousarray(sizes[usable]), np.ascontiguousarray(inflation_radii[usable]), BOX_SIGNS, _box_triangles()
    )
    known: dict[int, Polytope] = {}
    for k, body in zip(usable.tolist(), made, strict=True):
        if body is not None:
            out[k] = known.setdefault(id(body), Polytope._from_core(body))
    return out


@cache
def _box_triangles() -> Ints:
    return fans(prism_faces(4), 8, "box")


def prepared(
    vertices: ArrayLike, faces: GivenFaces | None = None, inflation_radius: float = 0.0, name: str = "polytope"
) -> Polytope:
    """A `Polytope` of points (n, 3), m, through the disk cache: the second preparation of the same points reads a file.

    Arguments are as for `Polytope`. `PLANNERCHECK_CACHE=0` turns the cache off; any other value is the cache's folder.
    """
    return Polytope._from_core(core_polytope(vertices, faces, inflation_radius, name, cached=True))


def _checked_directions(directions: ArrayLike) -> Floats:
    try:
        rows = np.atleast_2d(np.asarray(directions, dtype=np.float64))
    except (TypeError, ValueError, OverflowError) as error:
        raise PlannercheckError(f"directions must be an array of numbers of shape (k, 3): {error}") from error
    if rows.ndim != 2 or rows.shape[1] != 3 or not np.isfinite(rows).all():
        raise PlannercheckError(f"directions must be finite and of shape (k, 3), not {rows.shape}: {rows!r:.80}")
    # Large ones could overflow in products; powers of two change no verdict.
    exponents = np.maximum(np.frexp(np.abs(rows).max(axis=1, keepdims=True))[1], 0)
    return np.ascontiguousarray(np.ldexp(rows, -exponents))
