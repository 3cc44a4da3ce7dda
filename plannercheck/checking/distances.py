"""Tables of distances: the pairs that are near, their nearest points, and gradients by the configuration.

In: rows that the core measured (cpp/distances). Out: `Distances`, a row for each pair of each configuration that is
nearer than a limit. A gradient is the normal times the difference of both points' velocities; where more than one pair
of points is nearest, the distance has derivatives along directions only (Danskin's theorem): the least one over these
pairs of points.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.checking.nearest_sets import NearestPlace, nearest_points_of
from plannercheck.common.array_types import Bools, Floats, Ints, Ints64
from plannercheck.common.arrays import OwnsArrays, distinct, named_numbers
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module
from plannercheck.common.whole_numbers import row_of_table

# Numbers that say where a row's descent ended: how many corners, their vertices of the first body, of the second one.
CORNER_NUMBERS = 9

# All places where the bodies of a row are nearest, without padding, and the gradients (n, nv) at nearest points (n, 3)
# of the first one along a normal.
Places = Callable[[int], tuple[list[NearestPlace], Callable[[Floats, Floats], Floats]]]


@set_module("plannercheck")
@dataclass(frozen=True, eq=False, repr=False)
class Distances(OwnsArrays):
    """Distances of pairs, in the order of the configurations, the nearest pair of each first.

    Attributes:
        state: (r,) row of the configurations that were given.
        pair: (r,) row of the checker's `pairs`.
        distance: (r,) m, without the padding. Negative where the bodies overlap: moving the first body by its amount
            along the normal separates them; see `signed_distance`.
        lower: (r,) m, a proved lower bound of the distance.
        points: (r, 2, 3) the nearest points of both bodies in the world, m.
        normal: (r, 3) of length 1, in the world, from the second body to the first.
        gradient: (r, nv) derivative of the distance by the configuration, in m/rad and m/m; (r, 0) if not asked for.
            Its columns are Pinocchio's tangent of the group: one for each number of the configuration, except that a
            joint given by cosine and sine has one, a ball joint three (turns about x, y and z of its own frame), and
            a free or planar joint its velocity along the axes of its own frame, then its turn.
        gap: (r,) all nearest pairs of points are proved to be within this of the given one, m; infinite where nothing
            is proved: where faces or edges are parallel, where two places are as near or as deep, and where solids,
            clouds or maps overlap.
        unique: (r,) whether `gap` is at most 1e-8 of the smaller body's size: only one pair of points is nearest, and
            the distance has the gradient.
    """

    state: Ints64
    pair: Ints
    distance: Floats
    lower: Floats
    points: Floats
    normal: Floats
    gap: Floats
    unique: Bools
    gradient: Floats
    _corners: Ints = field(compare=False)
    _places: Places | None = field(default=None, compare=False)
    _measured: tuple[Ints, tuple[str, ...]] | None = field(default=None, compare=False)  # the checker's pairs and names

    def _is_of(self, pairs: Ints, names: tuple[str, ...]) -> bool:
        """Whether it is a table of a checker of these pairs of bodies, of links and obstacles of these names."""
        if self._measured is None:
            return False
        own, called = self._measured
        return called == names and (own is pairs or np.array_equal(own, pairs))

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_places": None}  # the checker is left behind

    def __len__(self) -> int:
        return len(self.state)

    def __repr__(self) -> str:
        if not len(self):
            return "Distances(no pair within the limit)"
        return (
            f"Distances({len(self)} {'row' if len(self) == 1 else 'rows'} of {len(distinct(self.state))} "
            f"configurations, the least {self.distance.min():.6g} m, {self.unique.mean():.0%} unique)"
        )

    def directional(self, row: int, dq: ArrayLike) -> float:
        """How fast a distance changes along a direction of the configuration, also where it has no gradient.

        It is the least rate of all nearest pairs of points: of all triangles, parts, cells and points that are nearest
        up to 1e-12 of the smaller body's size, and of faces and edges that are parallel up to rounding.

        Args:
            row: A row of this table.
            dq: (nv,) the direction, as the columns of `gradient`.

        Returns:
            The one-sided derivative, m/s for a dq in rad/s and m/s.

        Raises:
            PlannercheckError: If the table has no gradients, the direction is malformed, the bodies overlap, or are
                so near that rounding leaves the normal open.
        """
        direction = named_numbers(dq, "dq")
        row = row_of_table(row, len(self))
        if self._places is None:
            raise PlannercheckError(
                "the table has no gradients, or comes from a pickle: ask for distances(..., gradients=True)"
            )
        if direction.shape != self.gradient.shape[1:] or not np.isfinite(direction).all():
            raise PlannercheckError(f"dq must be {self.gradient.shape[1]} finite numbers")
        if self.unique[row]:
            return float(self.gradient[row] @ direction)
        if self.distance[row] <= 0:
            raise PlannercheckError(f"row {row}: the bodies overlap; derivatives are of bodies that are apart")
        places, gradients_at = self._places(row)
        if np.inf in (place.turn for place in places):
            raise PlannercheckError(
                f"row {row}: the bodies are {self.distance[row]:.3g} m apart, where rounding leaves the normal open"
            )
        rates = [gradients_at(nearest_points_of(place), place.normal) @ direction for place in places]
        return float(np.concatenate(rates).min())
