"""Clouds of points: the union of balls about the points that a sensor has seen.

In: points in m and one radius, or one for each point; or a file of points. Out: `PointCloud`, immutable, one of the
shapes of links and obstacles. Thinner clouds that surely contain a cloud are made in thinned_clouds.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.bodies.depth_images import points_of_depth
from plannercheck.bodies.part_sets import PartSet, check_coordinates, checked_rows, compiled_part_set
from plannercheck.bodies.point_files import points_of_file
from plannercheck.bodies.thinned_clouds import representatives, uncovered
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.arrays import read_only, real_numbers, shown_array
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.public_names import set_module

# What is done with points that are not finite: PCL writes NaN where a sensor had no return.
Invalid: TypeAlias = Literal["error", "drop"]

_DROP_HINT = '; invalid="drop" leaves such points out, and counts them'


@set_module("plannercheck")
@dataclass(frozen=True, eq=False, repr=False)
class PointCloud(PartSet):
    """Points with a radius: the union of the balls about them.

    A cloud may be empty, as a frame without returns is: it then collides with nothing.

    Attributes:
        points: (n, 3) in m, read-only: those given, less those that were dropped.
        radius: (n,) or (1,) in m, above 0, read-only. It is measured in the world: poses move the points alone.
        invalid: What to do with points that have a coordinate NaN or infinite: "error", or "drop".
        source: (n,) row of each point among those given, read-only; None if none was dropped.
        dropped: How many points were dropped for their coordinates.
    """

    points: Floats
    radius: Floats
    invalid: Invalid = "error"
    source: Ints64 | None = field(default=None, init=False)
    dropped: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        if self.invalid not in get_args(Invalid):
            raise unknown_name("choice for invalid points", str(self.invalid), get_args(Invalid))
        points = checked_rows(self.points, "points of a cloud")
        radius = _checked_radius(self.radius, len(points))
        if self.invalid == "drop":
            kept = np.isfinite(points).all(axis=1)
            if not kept.all():
                object.__setattr__(self, "source", read_only(np.flatnonzero(kept)))
                object.__setattr__(self, "dropped", int(len(points) - np.count_nonzero(kept)))
                points, radius = points.compress(kept, axis=0), radius if len(radius) == 1 else radius[kept]
        check_coordinates(points, "points of a cloud", _DROP_HINT)
        object.__setattr__(self, "points", read_only(points))
        object.__setattr__(self, "radius", read_only(radius))

    @classmethod
    def load(cls, path: str | Path, radius: ArrayLike, invalid: Invalid = "error") -> PointCloud:
        """Loads a file of points: ply, pcd, npy, npz, xyz, pts, txt or csv.

        Args:
            path: The file. Its numbers are in m; a PCD file's viewpoint is not applied.
            radius: In m, one or one for each point of the file.
            invalid: As of the class.

        Returns:
            The cloud, with the points in the file's order; organised clouds row by row.

        Raises:
            PlannercheckError: If the file is missing, broken or cut short, or holds no points (n, 3).
        """
        points = points_of_file(Path(path))
        try:
            return cls(points, radius, invalid)  # type: ignore[arg-type]  # which checks it
        except PlannercheckError as error:
            raise PlannercheckError(f"cloud file {str(path)!r}: {error}") from None

    @classmethod
    def from_depth(
        cls, depth: ArrayLike, intrinsics: ArrayLike, pose: ArrayLike | None, radius: ArrayLike
    ) -> PointCloud:
        """The cloud of a depth image, as REP 118 of ROS defines it, in doubles.

        Args:
            depth: (h, w) depth along z: floats in m, or uint16 in mm. NaN, 0 and +inf are no return.
            intrinsics: K (3, 3), or (fx, fy, cx, cy), in pixels, of the rectified image; pixels have whole numbers in
                their middle.
            pose: (4, 4) of the camera's optical frame (z forward, x right, y down) in the world, m; None is the
                identity.
            radius: In m: one, or (h, w) one for each pixel, as in `depth * 0.71 / fx`, by which the balls of
                one depth leave no hole. Those of pixels without a return do not matter.

        Returns:
            The cloud, row by row; `source` holds the pixel v * w + u of each point, `dropped` how many have no return.

        Raises:
            PlannercheckError: If the image is of another type or shape, or has negative depths; if intrinsics, pose or
                radius are none.
        """
        points = points_of_depth(depth, intrinsics, pose)
        radii = _radii(radius)
        if radii.ndim == 2 and radii.shape == np.shape(depth):
            radii = np.where(np.isnan(points[:, 0]), 1.0, radii.reshape(-1))  # any, of points that are dropped
        return cls(points, radii, "drop")

    @property
    def count(self) -> int:
        """The number of balls."""
        return len(self.points)

    @property
    def radii(self) -> Floats:
        """(n,) the radius of each ball, m, read-only."""
        return np.broadcast_to(self.radius, (len(self.points),))

    def part_name(self, index: int) -> str:
        """The row of a point among the points as they were given."""
        return str(index if self.source is None else int(self.source[index]))

    def with_points(self, points: ArrayLike) -> PointCloud:
        """A cloud of the same radius about other points (m, 3), m: the sensor's next frame; invalid points as here.

        Raises:
            PlannercheckError: If the balls have a radius each, and it is not as many.
        """
        return PointCloud(points, self.radius, self.invalid)  # type: ignore[arg-type]  # which checks them

    def without_covered(self) -> PointCloud:
        """The cloud without balls that are surely inside another one: the same set, also where a checker poses it.

        Of balls of one radius only repeated points go; of others, most that a larger ball holds.
        """
        kept = uncovered(self.points, self.radii)
        return self._of(kept, self.radius if len(self.radius) == 1 else self.radius[kept])

    def thinned(self, excess: float) -> tuple[PointCloud, float]:
        """A cloud of fewer, larger balls that contains this one and sticks out of it by a little.

        Every ball that is left out lies inside a larger one that is kept. The verdict "free" of the thinned cloud
        therefore holds for this one; the verdict "collision" holds for this one grown by the bound.

        Args:
            excess: How far it may stick out, m.

        Returns:
            The thinned cloud, and how far it sticks out at most, m: at most the excess.
        """
        kept, radii = representatives(self.points, self.radii, excess)
        bound = np.nextafter(np.max(radii - self.radii[kept], initial=0.0), np.inf) if len(kept) else 0.0
        return self._of(kept, radii), min(float(bound), float(excess))

    def _of(self, kept: Ints64, radius: Floats) -> PointCloud:
        """The points of these rows, under their names, and their radius."""
        source = kept if self.source is None else self.source[kept]
        return _restored(self.points[kept], radius, self.invalid, read_only(source), self.dropped)

    def _bounds(self) -> Sequence[ArrayLike]:
        columns = self.points.T  # one by one, since NumPy takes 80 times as long for all three at once
        if len(self.radius) == 1:  # rounding keeps the order: the least difference is that of the least
            low = np.array([column.min() for column in columns]) - self.radius
            high = np.array([column.max() for column in columns]) + self.radius
        else:
            low = np.array([(column - self.radius).min() for column in columns])
            high = np.array([(column + self.radius).max() for column in columns])
        return np.nextafter(low, -np.inf), np.nextafter(high, np.inf)

    def _core(self) -> Any:
        return compiled_part_set().balls(self.points, self.radius)

    def _hashed(self) -> Sequence[NDArray[Any]]:
        return self.points, self.radius

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self.points, self.radius, self.invalid, self.source, self.dropped)

    def __repr__(self) -> str:
        dropped = f", {self.dropped} dropped" if self.dropped else ""
        low, high = (float(self.radius.min(initial=np.inf)), float(self.radius.max(initial=0.0)))
        size = f"{low:.4g} m" if low == high else f"{low:.4g} to {high:.4g} m"
        return f"PointCloud({self.count} points, radius {size}{dropped})" if self.count else "PointCloud(0 points)"


def _restored(points: Floats, radius: Floats, invalid: Invalid, source: Ints64 | None, dropped: int) -> PointCloud:
    """A cloud of points that have names already: of what was pickled, and of a part of another cloud."""
    cloud = PointCloud(points, radius, invalid)
    object.__setattr__(cloud, "source", source)
    object.__setattr__(cloud, "dropped", dropped)
    return cloud


def _radii(values: ArrayLike) -> Floats:
    """A copy of the given radii, of one dimension or more."""
    try:
        return np.atleast_1d(np.array(real_numbers(values), dtype=np.float64))
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(f"radius of a cloud must be a length in m, not {shown_array(values)}") from None


def _checked_radius(values: ArrayLike, count: int) -> Floats:
    """One radius (1,), or one for each point (n,), above 0."""
    radius = _radii(values)
    if radius.ndim != 1 or len(radius) not in (1, count):
        raise PlannercheckError(f"radius of a cloud must be one, or one for each of {count} points, not {radius.shape}")
    bad = np.flatnonzero(~((radius > 0) & np.isfinite(radius)))
    if len(bad):
        which = f" {bad[0]}" if len(radius) > 1 else ""
        raise PlannercheckError(f"radius{which} of a cloud must be finite and above 0 (m), not {radius[bad[0]]}")
    check_coordinates(radius[:, None], "radius of a cloud")
    return radius
