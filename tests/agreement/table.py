"""FCL's errors, counted by the size and flatness of the bodies and by the gap between them."""

import math
from collections import Counter

from solids import width

from plannercheck.evaluation.stress.contact_poses import Solid

# Lower ends of the rows: the smaller body's size, m, and the flatter body's width over its size.
SIZE_STEPS = (0.1, 0.01, 1e-3, 1e-4, 0.0)
FLATNESS_STEPS = (0.1, 0.01, 0.0)
# Columns: |gap| over the smaller body's size, up to this.
GAP_STEPS = (0.0, 1e-12, 1e-10, 1e-8, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1)
# A gap computed from a product falls a hair beside the step it is meant to be.
_HAIR = 1 + 1e-9

Key = tuple[int, int, int]


class ErrorTable:
    """Counts pairs and FCL's errors in cells of size, flatness and gap."""

    def __init__(self) -> None:
        self.pairs: Counter[tuple[Key, bool]] = Counter()
        self.errors: Counter[tuple[Key, bool]] = Counter()

    def add(self, p: Solid, r: Solid, gap: float, truth: bool, theirs: bool) -> None:
        """Counts a pair; gap in m, NaN if unknown; truth and FCL's verdict are True for a collision."""
        size = min(p.size, r.size)
        flatness = min(width(p) / p.size, width(r) / r.size)
        column = len(GAP_STEPS) if math.isnan(gap) else gap_column(abs(gap) / size)
        key = (row_of(size, SIZE_STEPS), row_of(flatness, FLATNESS_STEPS), column)
        self.pairs[key, truth] += 1
        self.errors[key, truth] += theirs != truth

    def total(self, truth: bool) -> tuple[int, int]:
        """FCL's errors and the pairs, of those that collide or of those that are free."""
        errors = sum(count for (_, collides), count in self.errors.items() if collides == truth)
        return errors, sum(count for (_, collides), count in self.pairs.items() if collides == truth)

    def lines(self) -> list[str]:
        """The table as text, in percent of wrong verdicts a cell."""
        lines = []
        for truth, title in ((True, "collisions that FCL misses"), (False, "free pairs that FCL calls collisions")):
            errors, pairs = self.total(truth)
            lines += [f"{title}: {errors} of {pairs}; percent by |gap| over the smaller size", heading()]
            lines += [self._line(size, flatness, truth) for size, flatness in self._rows(truth)]
        return lines

    def _rows(self, truth: bool) -> list[tuple[int, int]]:
        return sorted({(size, flatness) for (size, flatness, _), collides in self.pairs if collides == truth})

    def _line(self, size: int, flatness: int, truth: bool) -> str:
        cells = [self._cell((size, flatness, column), truth) for column in range(len(GAP_STEPS) + 1)]
        return f"  {SIZE_STEPS[size]:7g} {FLATNESS_STEPS[flatness]:7g} " + " ".join(cells)

    def _cell(self, key: Key, truth: bool) -> str:
        pairs, errors = self.pairs[key, truth], self.errors[key, truth]
        if not pairs:
            return f"{'':>6}"
        return f"{100 * errors / pairs:6.2f}" if errors else f"{'0':>6}"


def heading() -> str:
    """The table's head."""
    gaps = " ".join(f"{step:6.0e}" for step in GAP_STEPS)
    return f"  {'size ≥':>7} {'flat ≥':>7} {gaps} random"


def row_of(value: float, steps: tuple[float, ...]) -> int:
    """The first step that a value reaches."""
    return next(k for k, step in enumerate(steps) if value >= step)


def gap_column(relative: float) -> int:
    """The first step that a relative gap does not exceed."""
    return next((k for k, step in enumerate(GAP_STEPS) if relative <= step * _HAIR), len(GAP_STEPS) - 1)
