"""Boxes of configurations that are proved free of collision, as tables.

In: boxes that a search has proved (box_search.py). Out: `FreeBoxes`, a row for each configuration that was given, and
`FreeBox`, one of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plannercheck.common.array_types import Bools, Floats, Ints64
from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module
from plannercheck.common.whole_numbers import row_of_table


@set_module("plannercheck")
@dataclass(frozen=True, eq=False)
class FreeBox(OwnsArrays):
    """A box of configurations, all proved free.

    Attributes:
        lower: (nq,) the least of each number, rad and m.
        upper: (nq,) the largest.
        cells: How many boxes, each proved by one distance a pair, cover it.
    """

    lower: Floats
    upper: Floats
    cells: int

    @property
    def volume(self) -> float:
        """The product of its widths, in rad and m."""
        return float(np.prod(self.upper - self.lower))

    def half_spaces(self) -> tuple[Floats, Floats]:
        """(A, b), (2 nq, nq) and (2 nq,): the box is {q : A q <= b}, as drake's HPolyhedron takes it."""
        eye = np.eye(len(self.lower))
        return np.concatenate([eye, -eye]), np.concatenate([self.upper, -self.lower])


@set_module("plannercheck")
@dataclass(frozen=True, eq=False, repr=False)
class FreeBoxes(OwnsArrays):
    """Boxes of configurations, all proved free, in the order of the configurations that they are around.

    Attributes:
        lower: (n, nq) the least of each number, rad and m; NaN where no box is proved.
        upper: (n, nq) the largest.
        cells: (n,) how many boxes, each proved by one distance a pair, cover it; 0 where no box is proved.
    """

    lower: Floats
    upper: Floats
    cells: Ints64

    def __len__(self) -> int:
        return len(self.cells)

    def __repr__(self) -> str:
        found = int(self.proved.sum())
        return f"FreeBoxes({found} of {len(self)} proved, the largest volume {self.volume.max(initial=0.0):.6g})"

    @property
    def proved(self) -> Bools:
        """(n,) which rows have a box."""
        return self.cells > 0

    @property
    def volume(self) -> Floats:
        """(n,) the products of their widths, in rad and m; 0 where no box is proved."""
        return np.where(self.proved, np.prod(self.upper - self.lower, axis=1), 0.0)

    def box(self, row: int) -> FreeBox | None:
        """The box of a row; None if none is proved."""
        k = row_of_table(row, len(self))
        return FreeBox(self.lower[k], self.upper[k], int(self.cells[k])) if self.cells[k] else None

    def half_spaces(self, row: int) -> tuple[Floats, Floats]:
        """(A, b) of a row's box, as of `FreeBox.half_spaces`.

        Raises:
            PlannercheckError: If no box is proved.
        """
        box = self.box(row)
        if box is None:
            raise PlannercheckError(f"row {row}: no box is proved; `proved` says which rows have one")
        return box.half_spaces()
