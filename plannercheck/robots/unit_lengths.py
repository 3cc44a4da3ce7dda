"""How far the lengths of a configuration's unit vectors (quaternions, cosine and sine) may differ from 1.

In: a Pinocchio model, the sources of a configuration's numbers. Out: `UnitLengths`, which refuses configurations that
would stretch links by more than the checker's bounds allow. The stretch is added up along the robot's chains.

Quaternions and pairs are used as they are, which is what Pinocchio does. A quaternion q = (v, w) of squared length n
maps the plane at right angles to v by the complex number 1 - 2 |v|^2 + 2 i w |v|, whose squared length is
1 + 4 |v|^2 (n - 1), and keeps v. So its matrix M has |M^T M - 1| = 4 sqrt(2) |v|^2 |n - 1| in the Frobenius norm, at
most 8 sqrt(2) |q|^2 (1 + e / 2) e if its length is 1 + e, and a half turn reaches that. A pair scales the plane by its
length 1 + e, also in Rodrigues' formula: sqrt(2) (2 + e) e. Of a product,
|(M N)^T (M N) - 1| <= |N|^2 |M^T M - 1| + |N^T N - 1|: along a chain these defects add up, up to a factor 1 + 1e-5 as
long as their sum is below 1e-5. Held joints and placements count as well.

The budget. All bounds of states (bounding_sphere.cpp, box_filter.cpp, overlap_filter.cpp, centre_axis.hpp,
pair_frame.cpp, distance.cpp) and of motions (motion_filters.hpp) allow a defect of `LINK_DEFECT` for links, and of
`shapes.RIGID_TOLERANCE` for obstacles and for bodies on links: 3.6e-6 for a body in the world. A single quaternion at
`UNIT_TOLERANCE` takes 2.3e-6 of 2.5e-6. So a robot with one floating base, or with a ball joint in each arm, accepts
every quaternion within `UNIT_TOLERANCE`. Several quaternions on one chain have to share the budget; the error says so.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.errors import PlannercheckError
from plannercheck.robots.joints import kind_of

# How far the length of a quaternion or of a (cosine, sine) may be from 1; values rounded to single precision pass.
UNIT_TOLERANCE = 2e-7

# The largest defect ||M^T M - 1|| of a link's pose that the bounds of states and motions allow.
LINK_DEFECT = 2.5e-6

# ||M^T M - 1|| for a length of 1 + e, as a part of e: 8 sqrt(2) and 2 sqrt(2), with room for the terms above and for
# the lengths' own rounding.
DEFECT_PARTS = {4: 8 * math.sqrt(2) * (1 + 1e-5), 2: 2 * math.sqrt(2) * (1 + 1e-5)}

# The rounding of Pinocchio's products of placements, and of sums of products here.
_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class UnitLengths(OwnsArrays):
    """The unit vectors of a configuration, and how much their lengths stretch links.

    Attributes:
        columns: (start, stop) of each unit vector in a configuration.
        parts: (chains, unit vectors) factor of each vector's error on each chain; 0 where it is not on the chain.
        held: (chains,) defect of placements and held joints, which no configuration changes.
        depth: The largest number of these unit vectors on one chain.
        harmless: If all lengths are this near to 1, no chain is stretched too much.
    """

    columns: tuple[tuple[int, int], ...]
    parts: Floats
    held: Floats
    depth: int
    harmless: float

    def check(self, rows: Floats) -> None:
        """Raises an error if a row of (n, nq) has a unit vector, or a chain of them, too far from length 1."""
        offs = [_off_unit(rows, start, stop) for start, stop in self.columns]
        if len(rows) and not all(off.max() <= self.harmless for off in offs):
            chains = np.stack(offs, axis=1) @ self.parts.T + self.held
            row, chain = (int(k) for k in np.unravel_index(np.argmax(chains), chains.shape))
            if not chains[row, chain] <= LINK_DEFECT:
                raise PlannercheckError(self._text(rows[row], row, chain, float(chains[row, chain])))

    def _text(self, row: Floats, index: int, chain: int, defect: float) -> str:
        listed = [
            f"columns {start} to {stop - 1} (length {float(np.linalg.norm(row[start:stop]))})"
            for (start, stop), part in zip(self.columns, self.parts[chain].tolist(), strict=True)
            if part > 0
        ]
        return (
            f"row {index}: the quaternions, cosines and sines along one chain are off length 1 so far that a link is "
            f"stretched, |M^T M - 1| up to {defect:.3g}, accepted is {LINK_DEFECT:g}: {', '.join(listed)}; normalise "
            "them in double precision"
        )


def unit_lengths(model: pin.Model, columns: Sequence[int], offsets: Floats, angles: Sequence[bool]) -> UnitLengths:
    """The unit vectors of a robot's configurations.

    Args:
        model: Pinocchio's.
        columns: (full nq,) column of the configuration that gives each number of Pinocchio's q, -1 if held.
        offsets: (full nq,) the held numbers.
        angles: (full nq,) which numbers are the cosine or sine of an angle, and so have exact length.

    Returns:
        The lengths.

    Raises:
        PlannercheckError: If held joints already stretch links by more than they may.
    """
    frames = max((_defect(frame.placement.rotation) for frame in model.frames), default=0.0)
    held, moving = np.full(model.njoints, frames + _ROUNDING), np.zeros((model.njoints, 0))
    found: list[tuple[int, int]] = []
    for joint in range(1, model.njoints):
        parent = model.parents[joint]
        held[joint] = held[parent] + _defect(model.jointPlacements[joint].rotation)
        moving[joint] = moving[parent]
        kind = kind_of(model.joints[joint])
        if kind is None or kind.unit is None:
            continue
        first, past = (model.idx_qs[joint] + k for k in kind.unit)
        part = DEFECT_PARTS[past - first]
        if angles[first]:
            continue
        if columns[first] < 0:
            held[joint] += part * abs(float(np.linalg.norm(offsets[first:past])) - 1)
            continue
        found.append((int(columns[first]), int(columns[first]) + past - first))
        moving = np.hstack([moving, np.zeros((model.njoints, 1))])
        moving[joint, -1] = part
    if not held.max() <= LINK_DEFECT:
        joint = int(np.argmax(~(held <= LINK_DEFECT)))
        raise PlannercheckError(
            f"what is held at joint {model.names[joint]!r} and before it is off rigid, |M^T M - 1| up to "
            f"{held[joint]:.3g}, accepted is {LINK_DEFECT:g}: give quaternions of length 1"
        )
    order = np.argsort([start for start, _ in found]) if found else np.zeros(0, dtype=np.int64)
    listed = tuple(found[k] for k in order)
    parts = moving[:, order]
    rates = np.maximum(parts.sum(axis=1), 1.0)
    harmless = float(((LINK_DEFECT - held) / rates).min())
    return UnitLengths(listed, parts, held, int((parts > 0).sum(axis=1).max(initial=0)), harmless)


def _off_unit(rows: Floats, start: int, stop: int) -> Floats:
    """(n,) how far lengths are from 1."""
    length = np.linalg.norm(rows[:, start:stop], axis=1)
    off = np.abs(length - 1.0)
    if not off.max(initial=0.0) <= UNIT_TOLERANCE:
        row = int(np.argmax(~(off <= UNIT_TOLERANCE)))
        kind = "a quaternion" if stop - start == 4 else "cosine and sine"
        raise PlannercheckError(
            f"columns {start} to {stop - 1} are {kind}, of length 1; in row {row} it is {length[row]}:"
            " normalise it in double precision"
        )
    return np.asarray(off)


def _defect(rotation: Floats) -> float:
    return float(np.linalg.norm(rotation.T @ rotation - np.eye(3)))
