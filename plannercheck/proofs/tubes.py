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
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.proofs.chains import Chains
from plannercheck.proofs.data import JOINTS, WORLD, Joint, Model, Motion, PosedBody
from plannercheck.proofs.joint_motions import held_map
from plannercheck.proofs.rounding import ROUNDING, UP

# Points of an axis that are tried: those nearest to the origins of this many joints before and after it.
_NEIGHBOURS = 3

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

    turn: float
    slide: float
    extent: float


class Tube:
    """The displacements of one motion's tube; each is computed once."""

    def __init__(self, model: Model, motion: Motion, chains: Chains) -> None:
        """Reads a well-formed model and motion."""
        self._model, self._chains, self._is_any = model, chains, any(motion.tube)
        if self._is_any:
            self._rooms = [_room(joint, motion) for joint in model.joints]
            self._maps = [_map_at_rest(joint) for joint in model.joints]
        self._known: dict[tuple[int, int, int], float] = {}

    def widening(self, frame: int, a: int, b: int) -> float:
        """By how much two bodies together are displaced, at most, seen from a joint's frame, m."""
        return (self._displacement(frame, a, b) + self._displacement(frame, b, a)) * UP if self._is_any else 0.0

    def _displacement(self, frame: int, body: int, other: int) -> float:
        """How far the points of a body are displaced; the path to the other body says which points are tried."""
        key = (frame, body, self._joint(other))
        if key not in self._known:
            self._known[key] = self._sum(*key)
        return self._known[key]

    def _joint(self, body: int) -> int:
        link = self._model.bodies[body].link
        return WORLD if link == WORLD else self._model.links[link].joint

    def _path(self, start: int, end: int) -> list[int]:
        """The joints that move between two joints' frames."""
        meeting = self._chains.meeting(start, end)
        return [*self._to(meeting, start), *reversed(self._to(meeting, end))]

    def _to(self, above: int, joint: int) -> list[int]:
        """The joints that move from a joint up to one above it, which is left out."""
        found = []
        while joint != above:
            found += [joint] if max(self._model.joints[joint].columns) >= 0 else []
            joint = self._model.joints[joint].parent
        return found

    def _sum(self, frame: int, body: int, other: int) -> float:
        own = self._joint(body)
        path = self._path(own, frame)
        total = sum(self._rooms[k].slide for k in path)
        if not any(self._rooms[k].turn for k in path):
            return total * UP
        near = path + self._path(frame, other)
        top = min(self._chains.meeting(own, frame), self._chains.meeting(frame, other))
        poses = {k: self._at_rest(top, k) for k in {own, *near}}
        points = _points(self._model, body) @ poses[own][:3, :3].T + poses[own][:3, 3]
        lengths = self._lengths(top, near, own, points)
        loose = lengths * (_DEFECTS * self._chains.defect + (len(near) + 8) * 8 * ROUNDING)
        arms = self._arms(path, near, poses, points)
        return (total + sum(self._rooms[k].turn * (arm + loose) for k, arm in arms.items())) * UP

    def _arms(
        self, path: Sequence[int], near: Sequence[int], poses: dict[int, Floats], points: Floats
    ) -> dict[int, float]:
        """How far a body's points are from the axis of each joint that turns, at most; joints from the body on."""
        centre, reaches = points.mean(axis=0), np.zeros(len(points))  # of points: how far the body's are from it
        slid, arms = 0.0, dict[int, float]()
        for k, joint in enumerate(path):
            if self._model.joints[joint].kind != "slide":
                origin, direction = self._axis(joint, poses[joint])
                tried = [poses[other][:3, 3] for other in near[max(k - _NEIGHBOURS, 0) : k + _NEIGHBOURS + 1]]
                feet = origin + np.outer((np.array([*tried, centre]) - origin) @ direction, direction)
                best = np.min if arms else np.max  # any point of an axis will do, but all points of the body count
                arms[joint] = float(best(_distances(points, origin, direction) + reaches)) + slid
                reaches = best(np.linalg.norm(points[:, None] - feet, axis=2) + reaches[:, None], axis=0)
                points = feet
            slid += self._rooms[joint].extent
        return arms

    def _axis(self, joint: int, pose: Floats) -> tuple[Floats, Floats]:
        """Origin and direction of a joint's axis; 0 for one without."""
        direction = pose[:3, :3] @ self._model.joints[joint].axis
        length = float(np.linalg.norm(direction))
        return pose[:3, 3], direction / length if JOINTS[self._model.joints[joint].kind].has_axis else np.zeros(3)

    def _at_rest(self, above: int, joint: int) -> Floats:
        """The map from a joint's frame to that of one above it, 4 x 4, with all joints at rest."""
        out = np.eye(4)
        while joint != above:
            out, joint = self._maps[joint] @ out, self._model.joints[joint].parent
        return out

    def _lengths(self, top: int, near: Sequence[int], own: int, points: Floats) -> float:
        """At least the sum of all lengths between the joints, and within the body."""
        joints = set[int]()
        for joint in (own, *near):
            while joint != top and joint not in joints:
                joints.add(joint)
                joint = self._model.joints[joint].parent
        between = sum(math.hypot(*self._maps[k][:3, 3]) + self._rooms[k].extent for k in joints)
        return 2 * float(between + np.linalg.norm(points, axis=1).max(initial=0.0)) * UP


def _room(joint: Joint, motion: Motion) -> _Room:
    form = JOINTS[joint.kind]
    if max(joint.columns) < 0:
        return _Room(0.0, 0.0, 0.0)
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


def _distances(points: Floats, origin: Floats, direction: Any) -> Floats:
    """(n,) of points from a line, or from a point where the direction is 0."""
    off = points - origin
    return np.asarray(np.linalg.norm(off - np.outer(off @ direction, direction), axis=1))
