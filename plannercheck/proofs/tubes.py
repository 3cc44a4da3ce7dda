"""How far a motion's tube moves the points of a body, seen from a frame.

In: a model, a motion with a tube, a frame and a body. Out: a length, m: the body is displaced by at most that where
every number of a configuration is changed by at most its tube.

Let q be a configuration on the motion and q + e one of its tube, and move along q + s e, s from 0 to 1. Seen from the
frame, a point's velocity is a sum over the joints between frame and body. A joint that slides adds |e| times its
multiplier, at most; one that turns adds that times the point's distance from its axis. The displacement is at most
the sum of all these. No number of a tube turns a joint that has no axis.

Distances hold at every configuration: a point of an axis is fixed on both links of its joint. If a body's points are
within r of a point c on one axis, they are within r + |c - c'| of a point c' on the next, and their distance from that
axis is at most r plus that of c. Both are least over some points c. A joint without an axis has its origin. Lengths are
measured with all joints at rest, where sliding joints stand at 0; elsewhere each adds at most how far it slides.

A radius adds nothing, since a ball that is turned is the same ball. Maps are rigid up to a defect, which changes no
length by more than some times its part of all lengths between frame and body.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct
from plannercheck.proofs.chains import Chains
from plannercheck.proofs.data import JOINTS, WORLD, Joint, Model, Motion, PosedBody
from plannercheck.proofs.joint_motions import held_map
from plannercheck.proofs.rounding import ROUNDING, UP

# Points of an axis that are tried: those nearest to the origins of joints up to so many moving joints away, so many at
# most, and to two middles of the body.
_NEAR, _MOST_TRIED = 3, 24

# How many times its part of all lengths the defect of maps changes a length, at most.
_DEFECTS = 16


@dataclass(frozen=True)
class _Room:
    """What the tube allows a joint.

    Attributes:
        turn: By how much it turns, at most, rad.
        slide: By how much it slides, m.
        extent: How far its origin is from where it is at rest, at most, all along the motion and its tube, m.
    """

    turn: float = 0.0
    slide: float = 0.0
    extent: float = 0.0


@dataclass(frozen=True, eq=False)
class _View:
    """A body as seen from a joint's frame, all joints between them at rest.

    Attributes:
        points: (n, 3) the body's own, or some of the last axis between them, m.
        reaches: (n,) how far all of the body is from each of these points, at most; none of the body's own points.
        middles: (2, 3) middles of the body.
        slid: How far the joints between them may slide, together, m.
        lengths: At least the sum of all lengths between them, and within the body, m.
        shift: How far the body is displaced, m.
    """

    points: Floats
    reaches: Floats | None
    middles: Floats
    slid: float
    lengths: float
    shift: float


class _AtRest:
    """What holds on every motion; each is computed once."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._own: dict[int, _View] = {}

    @cached_property
    def maps(self) -> list[Floats]:
        """From each joint's frame to its parent's."""
        return [_map_at_rest(joint) for joint in self._model.joints]

    @cached_property
    def tried(self) -> list[Floats]:
        """For each joint places on its axis, m."""
        return _tried_points(self._model, self.maps)

    def own_view(self, body: int) -> _View:
        """A body as seen from its own joint's frame."""
        if body not in self._own:
            self._own[body] = _own_view(self._model, body)
        return self._own[body]


class Tube:
    """The displacements of one motion's tube; each is computed once."""

    def __init__(self, model: Model, motion: Motion, chains: Chains) -> None:
        """Reads a well-formed model and motion."""
        self._model, self._rest = model, _AtRest(model)
        self._begin(motion, chains)

    def _begin(self, motion: Motion, chains: Chains) -> None:
        self._chains, self._is_any = chains, any(motion.tube)
        self._views: dict[tuple[int, int], _View] = {}
        if self._is_any:
            self._rooms = [_room(joint, motion) for joint in self._model.joints]

    def on(self, motion: Motion, chains: Chains) -> Tube:
        """The same model's on another motion."""
        made = copy(self)
        made._begin(motion, chains)
        return made

    def widening(self, frame: int, a: int, b: int) -> float:
        """By how much two bodies together are displaced, at most, seen from a joint's frame, m."""
        return (self._view(frame, a).shift + self._view(frame, b).shift) * UP if self._is_any else 0.0

    def _view(self, frame: int, body: int) -> _View:
        if (frame, body) in self._views:
            return self._views[frame, body]
        steps = list(self._steps(frame, body))
        known = next((k for k, (at, _) in enumerate(steps) if (at, body) in self._views), len(steps))
        if known == len(steps):
            known -= 1
            self._views[steps[known][0], body] = self._rest.own_view(body)
        for (before, _), (at, joint) in zip(steps[known:0:-1], steps[known - 1 :: -1], strict=False):
            self._views[at, body] = self._crossed(self._views[before, body], joint, is_up=joint == before)
        return self._views[frame, body]

    def _steps(self, frame: int, body: int) -> Iterator[tuple[int, int]]:
        """The frames from a frame to a body's, and for each the joint that is crossed to it from the next one."""
        link = self._model.bodies[body].link
        own = WORLD if link == WORLD else self._model.links[link].joint
        meeting, parents = self._chains.meeting(frame, own), [joint.parent for joint in self._model.joints]
        while frame != meeting:
            yield frame, frame
            frame = parents[frame]
        up = [own]
        while up[-1] != meeting:
            up.append(parents[up[-1]])
        below = [*up[-2::-1], WORLD]
        yield from zip(reversed(up), below, strict=True)

    def _crossed(self, view: _View, joint: int, is_up: bool) -> _View:
        """The view from a joint's other side; from its parent's frame if it goes up."""
        matrix = self._rest.maps[joint]
        longer = replace(view, lengths=view.lengths + 2 * math.hypot(*matrix[:3, 3]) + 2 * self._rooms[joint].extent)
        if is_up:
            return _moved(self._moved_by(longer, joint), matrix)
        return self._moved_by(_moved(longer, np.asarray(np.linalg.inv(matrix), dtype=np.float64)), joint)

    def _moved_by(self, view: _View, joint: int) -> _View:
        """What a joint adds, seen from its frame; its axis leads through the origin."""
        own, room = self._model.joints[joint], self._rooms[joint]
        further = replace(view, slid=view.slid + room.extent, shift=view.shift + room.slide)
        if max(own.columns) < 0 or own.kind == "slide":
            return further
        axis = _axis(own)
        tried = np.concatenate([self._rest.tried[joint], view.middles @ axis])[:, None] * axis
        if not axis.any():
            tried = np.zeros((1, 3))
        loose = view.lengths * (_DEFECTS * self._chains.defect + (len(self._rest.maps) + 8) * ROUNDING)
        arms, apart = _distances(view.points, axis), np.linalg.norm(view.points[:, None] - tried, axis=2)
        if view.reaches is None:
            arm, reaches = arms.max(), apart.max(axis=0)  # all of the body's points count
        else:  # any point of the last axis will do
            arm, reaches = (arms + view.reaches).min(), (apart + view.reaches[:, None]).min(axis=0)
        shift = further.shift + room.turn * (float(arm) + view.slid + loose) * UP
        return replace(further, points=tried, reaches=reaches, shift=shift)


def _own_view(model: Model, body: int) -> _View:
    points = _points(model, body) if len(model.bodies[body].vertices) else np.zeros((1, 3))
    middles = np.array([points.mean(axis=0), (points.min(axis=0) + points.max(axis=0)) / 2])
    return _View(points, None, middles, 0.0, 2 * float(np.linalg.norm(points, axis=1).max()) * UP, 0.0)


def _moved(view: _View, matrix: Floats) -> _View:
    turn, shift = matrix[:3, :3].T, matrix[:3, 3]
    return replace(view, points=view.points @ turn + shift, middles=view.middles @ turn + shift)


def _axis(joint: Joint) -> Floats:
    """The direction of a joint's axis, 0 if it has none."""
    axis = np.array(joint.axis)
    return np.asarray(axis / np.linalg.norm(axis)) if JOINTS[joint.kind].has_axis else np.zeros(3)


def _distances(points: Floats, axis: Floats) -> Floats:
    """(n,) of points from the line along an axis through the origin, or from the origin."""
    return np.asarray(np.linalg.norm(points - np.outer(points @ axis, axis), axis=1))


def _tried_points(model: Model, maps: Sequence[Floats]) -> list[Floats]:
    """For each joint places on its axis, m: a choice, on which no bound depends."""
    poses: list[Floats] = []
    for joint, matrix in zip(model.joints, maps, strict=True):
        poses.append(poses[joint.parent] @ matrix if joint.parent != WORLD else matrix)
    places = []
    for k, near in enumerate(_near_joints(model)):
        offsets = np.array([poses[other][:3, 3] for other in near]) - poses[k][:3, 3]
        places.append(distinct(offsets @ poses[k][:3, :3] @ _axis(model.joints[k])))
    return places


def _near_joints(model: Model) -> list[list[int]]:
    """For each joint those that may follow it on a path between bodies, the nearest first, and itself."""
    moves = [max(joint.columns) >= 0 for joint in model.joints]
    above: list[int] = []  # the next joint above that moves
    for joint in model.joints:
        above.append(joint.parent if joint.parent == WORLD or moves[joint.parent] else above[joint.parent])
    below: dict[int, list[int]] = {}
    for k, parent in enumerate(above):
        if moves[k]:
            below.setdefault(parent, []).append(k)
    found = []
    for k in range(len(above)):
        near, last = {k: None}, [k]
        for _ in range(_NEAR):
            if len(near) < _MOST_TRIED:
                last = [j for i in last for j in (above[i], *below.get(i, ()), *below.get(above[i], ())) if j != WORLD]
                near.update(dict.fromkeys(last))
        found.append(list(near)[:_MOST_TRIED])
    return found


def _room(joint: Joint, motion: Motion) -> _Room:
    form = JOINTS[joint.kind]
    if max(joint.columns) < 0:
        return _Room()
    if form.numbers == 1:
        (column,), (factor,), (offset,) = joint.columns, joint.multipliers, joint.offsets
        width = abs(factor) * motion.tube[column] * UP
        if not form.lengths:
            return _Room(width, 0.0, 0.0)
        products = [factor * row[column] for row in motion.control]
        largest = max(abs(x + offset) + ROUNDING * (abs(x) + abs(offset)) for x in products) * UP
        return _Room(0.0, width, largest + width)
    columns = slice(joint.columns[0], joint.columns[0] + form.lengths)
    width = math.hypot(*motion.tube[columns]) * UP
    return _Room(0.0, width, _furthest(motion, columns) + width)


def _furthest(motion: Motion, columns: slice) -> float:
    """How far from 0 the position of a planar or free joint comes, m."""
    control = [row[columns] for row in motion.control]
    if motion.path == "slerp":
        return max(math.hypot(*row) for row in control) * UP
    # A screw turns by half a turn at most, so it is furthest from its start at its end.
    return (math.hypot(*control[0]) + math.dist(control[0], control[-1])) * UP


def _map_at_rest(joint: Joint) -> Floats:
    """The map from a joint's frame to its parent's: of a joint that moves, with its value 0."""
    placement = np.vstack([np.reshape(joint.placement, (3, 4)), [0.0, 0.0, 0.0, 1.0]])
    if max(joint.columns) >= 0:
        return placement
    held = np.array([float(x) for x in held_map(joint).entries()]).reshape(4, 4)
    return np.asarray(placement @ held)


def _points(model: Model, body: int) -> Floats:
    """(n, 3) points on the body's joint, in whose hull the body is but for its radii."""
    own = model.bodies[body]
    points = _own_points(own)
    for rows in (own.pose, *([model.links[own.link].placement] if own.link != WORLD else [])):
        matrix = np.reshape(rows, (3, 4))
        points = points @ matrix[:, :3].T + matrix[:, 3]
    return points


def _own_points(body: PosedBody) -> Floats:
    vertices = body.vertices.reshape(-1, 3)
    if body.parts == "prisms":
        return np.concatenate([vertices, np.column_stack([vertices[:, :2], np.full(len(vertices), body.base)])])
    if body.parts == "boxes":
        signs = np.arange(8)[:, None] >> np.arange(3) & 1
        return np.where(signs, vertices[1::2, None], vertices[::2, None]).reshape(-1, 3)
    return vertices
