"""Chains of joints with lever arms: they bound how far a motion moves two bodies relative to each other.

In: a robot, bodies, pairs. Out: for each pair a frame between its bodies, and for each body the joints from that frame
to it (`PairParts`). Each joint has a bound on how far the body's points get from its axis at any configuration.

The arms. A point of a joint's axis is fixed on both links that the joint connects. So we go from the body outwards. The
body's points are within D(c) of a point c on the first axis. A point c' on the next axis is on the same link as c, so
the body's points are within D(c) + |c - c'| of c', and their distance from the next axis is at most D(c) plus the
distance of c from it. Both bounds are minimised over a few points of each axis, at one configuration: lengths within a
link do not change. A joint without an axis has one point, its origin.

Sliding joints. At that configuration they stand at 0, so the origins of the links before and after them coincide. At
any other configuration these are as far apart as the joint has slid. The largest such distance over the motion is the
joint's extent; it is added to each length that leads over the joint. A joint's own arm is measured from the origin of
the link after it, about which it turns. If the body is beyond that link, no length leads over the joint itself. If the
body is on the other side (the frame is on the child's side of the joint), one does, and the joint's own extent is added
as well.

The frame. It may be any link between the two bodies. The certificate's error is the sum of the errors of both sides,
and the error of a side grows with each of its joints (cpp/motions/motion_bounds.hpp), so a frame in the middle is best.
We choose the link with the least error if all joints turn at the same rate.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from plannercheck.bodies.shapes import GeometryObject, inflated_hull
from plannercheck.common.array_types import Floats, Ints
from plannercheck.motions.joint_axes import JointTree

# Poses of bodies differ from rigid ones by 3.6e-6 at most (robots/unit_lengths.py), which stretches lengths by half of
# that; lengths are rounded as well.
_STRETCH = 1 + 2e-6

# Points of an axis that are tried: the feet of perpendiculars from the origins of this many joints before and after it.
_NEIGHBOURS = 3


class ChainJoint(NamedTuple):
    """A joint of a chain.

    Attributes:
        joint: Index into the table's joints.
        arm: How far the body's points get from the joint's axis, without the distances that `slides` slide, m.
        slides: Sliding joints between the body and the link after this joint; this joint as well if it slides and is
            crossed from the child's side.
    """

    joint: int
    arm: float
    slides: tuple[int, ...]


def chain_arrays(chains: Sequence[tuple[ChainJoint, ...]]) -> tuple[Ints, Ints, Floats, Ints]:
    """First entries (chains + 1,), entries (k, 3), arms (k,) and slides of chains, as the core takes them."""
    entries = [entry for chain in chains for entry in chain]
    slides = np.cumsum([0, *(len(entry.slides) for entry in entries)])
    rows = [(e.joint, first, past) for e, first, past in zip(entries, slides[:-1], slides[1:], strict=True)]
    return (
        np.cumsum([0, *(len(chain) for chain in chains)]).astype(np.int32),
        np.array(rows, dtype=np.int32).reshape(-1, 3),
        np.array([entry.arm for entry in entries], dtype=np.float64),
        np.array([joint for entry in entries for joint in entry.slides], dtype=np.int32),
    )


class PairParts(NamedTuple):
    """The chains of a pair, each joint by joint from the body outwards.

    Attributes:
        frame: Index of the link in whose frame both bodies are seen, -1 for the world.
        first: The joints of the first body.
        second: The joints of the second body; none for a body at rest in the frame.
    """

    frame: int
    first: tuple[ChainJoint, ...]
    second: tuple[ChainJoint, ...]


class ChainBuilder:
    """Chains of pairs; shared parts are computed once.

    Attributes:
        tree: The joints.
        chains: All chains so far, with entries from the frame to the body.
    """

    def __init__(self, tree: JointTree, bodies: Sequence[GeometryObject], links: Sequence[int], excess: float) -> None:
        """Takes the bodies.

        Args:
            tree: The robot's joints.
            bodies: All bodies.
            links: Each body's link, -1 if no joint moves the body.
            excess: How far polytopes of curved shapes stick out, as a part of the radius.
        """
        self.tree, self._bodies, self._links, self._excess = tree, bodies, links, excess
        self._arms: dict[tuple[int, tuple[int, ...]], tuple[ChainJoint, ...]] = {}
        self._index: dict[tuple[ChainJoint, ...], int] = {}
        self._points: dict[int, tuple[Floats, float]] = {}
        self.chains: list[tuple[ChainJoint, ...]] = []

    def parts(self, first: int, second: int) -> PairParts:
        """The chains of a pair: of two bodies, of which the first moves, by their indices."""
        tree, links = self.tree, self._links
        start = tree.link_joints[links[first]]
        end = tree.link_joints[links[second]] if links[second] >= 0 else -1
        joints, path_links = tree.joint_path(start, end)
        up_count = next((k for k, joint in enumerate(joints) if not tree.carries(joint, start)), len(joints))
        mine = self._chain_joints(first, joints, up_count)
        if links[second] < 0:
            return PairParts(-1, mine, ())
        theirs = self._chain_joints(second, joints[::-1], len(joints) - up_count)
        chord_deviations = [
            _chord_deviation(mine[:k]) + _chord_deviation(theirs[: len(joints) - k]) for k in range(len(path_links))
        ]
        usable = [k for k, joint in enumerate(path_links) if joint in tree.link_on]
        best = min(usable, key=lambda k: chord_deviations[k])
        return PairParts(tree.link_on[path_links[best]], mine[:best], theirs[: len(joints) - best])

    def index(self, entries: tuple[ChainJoint, ...]) -> int:
        """The index of a chain, given by its entries from the body outwards; -1 for one of none."""
        if not entries:
            return -1
        if entries not in self._index:
            self._index[entries] = len(self.chains)
            self.chains.append(entries[::-1])
        return self._index[entries]

    def _chain_joints(self, body: int, joints: Sequence[int], up_count: int) -> tuple[ChainJoint, ...]:
        key = (body, tuple(joints))
        if key not in self._arms:
            self._arms[key] = self._compute(body, joints, up_count)
        return self._arms[key]

    def _compute(self, body: int, joints: Sequence[int], up_count: int) -> tuple[ChainJoint, ...]:
        """Joints from the body outwards; it hangs on the first `up_count`, the others are crossed from below."""
        tree = self.tree
        points, inflation_radius = self._vertices(body)
        middle = points.mean(axis=0)[None]
        slides: tuple[int, ...] = ()
        known: tuple[Floats, Floats] | None = None  # points c of the last axis, and D(c)
        entries = []
        for k, joint in enumerate(joints):
            axis = tree.axes[joint]
            if tree.turns[joint]:
                near = tree.origins[list(joints[max(k - _NEIGHBOURS, 0) : k + _NEIGHBOURS + 1])]
                feet = axis.feet(np.concatenate([near, middle]))
                if known is None:
                    arm = float(axis.distance(points).max()) + inflation_radius
                    reach = _distances(points, feet).max(axis=0) + inflation_radius
                else:
                    arm = float((known[1] + axis.distance(known[0])).min())
                    reach = (known[1][:, None] + _distances(known[0], feet)).min(axis=0)
                known = feet, reach
                from_child = k >= up_count and tree.slides[joint]
                entries.append(ChainJoint(joint, arm * _STRETCH, (*slides, joint) if from_child else slides))
            else:
                entries.append(ChainJoint(joint, 0.0, ()))
            if tree.slides[joint]:
                slides = (*slides, joint)
        return tuple(entries)

    def _vertices(self, body: int) -> tuple[Floats, float]:
        """Vertices in the world at rest (n, 3), and the inflation radius, m."""
        if body not in self._points:
            item = self._bodies[body]
            vertices, _, inflation_radius = inflated_hull(item.shape, self._excess)
            pose = np.asarray(item.pose)
            if self._links[body] >= 0:
                pose = self.tree.link_poses[self._links[body]] @ pose
            self._points[body] = vertices @ pose[:3, :3].T + pose[:3, 3], float(inflation_radius)
        return self._points[body]


def _distances(points: Floats, others: Floats) -> Floats:
    """(n, m) of points (n, 3) from others (m, 3), as np.linalg.norm has them, with less around it."""
    offsets = points[:, None] - others
    return np.asarray(np.sqrt((offsets * offsets).sum(axis=2)))


def _chord_deviation(entries: Sequence[ChainJoint]) -> float:
    """The bound of cpp/motions/motion_bounds.hpp where all joints turn by 1 rad; entries from the body outwards."""
    return sum(entry.arm * (1 + 2 * (len(entries) - 1 - k)) for k, entry in enumerate(entries))
