"""Whether entries of parts of solids cover [0, 1] and all pairs of triangles of a pair.

In: a model, entries. Out: nothing, or an `UnprovedError`. An entry is a box of three sides: its interval, and the
ranges of triangles of both bodies. A cell is covered if one box holds it. Else it is cut where a box ends, and both
halves have to be covered. The choice of the end changes only the time.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct
from plannercheck.proofs.data import WORLD, Entry, Model
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.numbers_of_proofs import check_numbers
from plannercheck.proofs.parts import part_count


def pairs_in_parts(entries: Sequence[Entry]) -> set[int]:
    """The pairs of which some entry is of parts."""
    return {entry.pair for entry in entries if entry.first or entry.second}


def is_whole(entry: Entry) -> bool:
    """Whether an entry is of both bodies' hulls."""
    return not entry.first and not entry.second


def check_covers(model: Model, entries: Sequence[Entry]) -> None:
    """Raises an `UnprovedError` unless the entries of each pair that is proved in parts cover it."""
    boxes: dict[int, list[list[float]]] = {pair: [] for pair in pairs_in_parts(entries)}
    for k, entry in enumerate(entries):
        if entry.pair in boxes:
            boxes[entry.pair].append(_box(model, entry, k))
    for pair, rows in boxes.items():
        sides = [(0.0, 1.0), *((0.0, float(_count(model, body))) for body in model.pairs[pair])]
        _check_covered(pair, np.array(sides), np.array(rows).reshape(-1, 3, 2))


def check_directions(model: Model, entry: Entry, k: int) -> None:
    """Raises an `UnprovedError` unless an entry by planes has a direction; several only against a set of parts."""
    count, rest = divmod(len(entry.direction), 3)
    is_one = count == 1 or any(model.bodies[body].parts for body in model.pairs[entry.pair])
    if entry.by == "plane" and not (count and not rest and is_one and WORLD <= entry.frame < len(model.links)):
        raise UnprovedError(f"entry {k} needs a direction of three numbers and the index of a link, or -1")
    check_numbers(entry.direction, f"direction of entry {k}")


def _count(model: Model, body: int) -> int:
    own = model.bodies[body]
    return max(1, part_count(own) if own.parts else len(own.triangles))


def _box(model: Model, entry: Entry, k: int) -> list[float]:
    if not 0 <= entry.pair < len(model.pairs):
        raise UnprovedError(f"entry {k} is of pair {entry.pair}, of {len(model.pairs)}")
    if not 0 <= entry.start < entry.end <= 1:
        raise UnprovedError(f"entry {k} is of [{entry.start!r}, {entry.end!r}], which is no part of [0, 1]")
    if entry.by != "plane" and not (entry.by == "balls" and is_whole(entry)):
        raise UnprovedError(f"entry {k} is of parts, which only planes hold apart")
    check_directions(model, entry, k)
    box = [entry.start, entry.end]
    for part, body in zip((entry.first, entry.second), model.pairs[entry.pair], strict=True):
        is_set = bool(model.bodies[body].parts)
        count = part_count(model.bodies[body]) if is_set else len(model.bodies[body].triangles)
        if part and not (len(part) == 2 and 0 <= part[0] < part[1] <= count):
            raise UnprovedError(f"entry {k} is of {'parts' if is_set else 'triangles'} {list(part)[:4]}, of {count}")
        box += [float(x) for x in part] if part else [0.0, float(max(1, count))]
    return box


def _check_covered(pair: int, whole: Floats, boxes: Floats) -> None:
    """Sides are (3, 2), boxes (n, 3, 2)."""
    cells = [(whole, boxes)]
    while cells:
        cell, given = cells.pop()
        low, high = cell.T
        near = given[((given[:, :, 0] < high) & (given[:, :, 1] > low)).all(axis=1)]
        if ((near[:, :, 0] <= low) & (near[:, :, 1] >= high)).all(axis=1).any():
            continue
        cut = _cut(cell, near) if len(near) else None
        if cut is None:
            raise UnprovedError(
                f"pair {pair} is not proved on [{low[0]!r}, {high[0]!r}], triangles {int(low[1])} to {int(high[1])} "
                f"beside {int(low[2])} to {int(high[2])}"
            )
        axis, value = cut
        for side in (0, 1):
            half = cell.copy()
            half[axis, 1 - side] = value
            cells.append((half, near))


def _cut(cell: Floats, boxes: Floats) -> tuple[int, float] | None:
    """An axis and where some box ends on it, within the cell: where fewest boxes are cut, then nearest the middle."""
    found: list[tuple[int, int, int, float]] = []
    for axis in range(3):
        low, high = cell[axis]
        starts, ends = np.sort(boxes[:, axis, 0]), np.sort(boxes[:, axis, 1])
        values = distinct(np.concatenate([starts, ends]))
        values = values[(values > low) & (values < high)]
        before, after = np.searchsorted(starts, values), len(ends) - np.searchsorted(ends, values, side="right")
        straddled = before + after - len(boxes)
        uneven = np.abs(before - after)
        found += zip(straddled.tolist(), uneven.tolist(), [axis] * len(values), values.tolist(), strict=True)
    if not found:
        return None
    _, _, axis, value = min(found)
    return axis, value
