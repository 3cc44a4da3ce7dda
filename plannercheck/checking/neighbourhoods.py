"""Relative poses of some frames of a long chain, without the joints that move all of them.

In: a joint table with frames, some of the frames. Out: `Neighbourhood`, compiled kinematics of the joints beyond the
last one that the frames have in common. Its time depends on the number of joints between the frames, not on the chain's
length.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.core import core
from plannercheck.robots.kinematics import JointTable

# The fields of a joint table that have a row for each joint, except the parents.
_OF_JOINTS = ("kinds", "axes", "placements", "columns", "multipliers", "offsets")


class Neighbourhood(NamedTuple):
    """Relative kinematics of some frames of `Chains`.

    Attributes:
        kernel: Compiled kinematics, from a frame that all of them have in common.
        place: By frame, its index among the kernel's frames.
    """

    kernel: core.Kinematics
    place: dict[int, int]

    def poses(self, q: Floats) -> Floats:
        """(n, frames, 4, 4) at configurations (n, nq)."""
        return np.asarray(self.kernel.link_poses(q, np.ones(len(self.place), dtype=np.uint8)))


def neighbourhood(table: JointTable, wanted: Sequence[int]) -> Neighbourhood:
    """Kinematics of some links of a joint table, given in ascending order, relative to each other.

    They are those of the joints that move the links relative to each other, and of the last joint that they have in
    common.
    """
    hung: list[int] = table.link_joints[list(wanted)].tolist()
    parents: list[int] = table.parents.tolist()
    ends = set(hung)
    while len(ends) > 1:  # parents come first, so the last joint is no ancestor of the others
        ends.add(parents[last := max(ends)])
        ends.remove(last)
    (fork,) = ends
    known: set[int] = set()
    for joint in hung:
        while joint >= max(fork, 0) and joint not in known:
            known.add(joint)
            joint = parents[joint]
    kept = sorted(known)
    place = {joint: k for k, joint in enumerate(kept)}
    rows: dict[str, Any] = {name: np.ascontiguousarray(getattr(table, name)[kept]) for name in _OF_JOINTS}
    part = table._replace(
        **rows,
        parents=np.array([place.get(parents[joint], -1) for joint in kept], dtype=np.int32),
        link_joints=np.array([place.get(joint, -1) for joint in hung], dtype=np.int32),
        link_placements=np.ascontiguousarray(table.link_placements[list(wanted)]),
    )
    return Neighbourhood(core.Kinematics(*part), {frame: k for k, frame in enumerate(wanted)})
