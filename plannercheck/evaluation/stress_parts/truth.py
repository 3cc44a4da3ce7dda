"""Whether two bodies of pieces share a point: every piece of one against every piece of the other, exactly.

In: two bodies, poses of both. Out: verdicts, proved by cpp/oracle. Pieces in hulls that are apart are not tested one by
one, unless all pairs are asked for.
"""

from __future__ import annotations

import itertools

import numpy as np

from plannercheck.bodies import exact_reference
from plannercheck.common.array_types import Bools, Floats
from plannercheck.evaluation.stress.oracle import compiled_oracle
from plannercheck.evaluation.stress_parts.bodies import Body
from plannercheck.evaluation.stress_parts.half_space_truth import meets_half_space
from plannercheck.evaluation.stress_parts.pieces import Group, Piece
from plannercheck.evaluation.stress_solids.bodies import Body as SolidBody
from plannercheck.evaluation.stress_solids.bodies import decided

# The answer of the oracle where it found no proof.
_UNPROVED = 2


def decide(p: Body, poses_p: Floats, r: Body, poses_r: Floats, every: bool = False) -> Bools:
    """Whether two bodies, of which only r may be a half-space, share a point at poses (k, 4, 4): (k,).

    `every`: no pair of pieces is left out, and whole numbers alone decide.
    """
    if r.half_space is not None:
        return meets_half_space(p, poses_p, r.half_space, poses_r, every)
    shared = np.zeros(len(poses_p), dtype=bool)
    if r.solid is not None or p.solid is not None:
        for piece in (*p.pieces, *r.pieces):
            left = np.flatnonzero(~shared)
            first, second = (piece.surface if body.solid is None else body.solid for body in (p, r))
            shared[left] = _of_meshes(first, poses_p[left], second, poses_r[left])
        return shared
    if every:
        for i, j in itertools.product(p.pieces, r.pieces):
            left = np.flatnonzero(~shared)
            shared[left] = _of_pieces(i, poses_p[left], j, poses_r[left], every)
        return shared
    return _of_groups(p.group, poses_p, r.group, poses_r)


def _of_groups(p: Group, poses_p: Floats, r: Group, poses_r: Floats) -> Bools:
    """Where what is around both shares a point, halves of the group of more corners decide."""
    shared = _of_pieces(p.around, poses_p, r.around, poses_r, False)
    if not p.halves and not r.halves:
        return shared
    waiting = np.flatnonzero(shared)
    shared[:] = False
    parts_p = bool(p.halves) and (not r.halves or len(p.around.corners) >= len(r.around.corners))
    for half in p.halves if parts_p else r.halves:
        left = waiting[~shared[waiting]]
        first, second = (half, r) if parts_p else (p, half)
        shared[left] = _of_groups(first, poses_p[left], second, poses_r[left])
    return shared


def _of_meshes(p: SolidBody, poses_p: Floats, r: SolidBody, poses_r: Floats) -> Bools:
    return np.asarray(decided(p, poses_p, r, poses_r) != 0) if len(poses_p) else np.zeros(0, dtype=bool)


def _of_pieces(p: Piece, poses_p: Floats, r: Piece, poses_r: Floats, every: bool) -> Bools:
    if not len(poses_p):
        return np.zeros(0, dtype=bool)
    found = compiled_oracle().decide(p.points, poses_p, r.points, poses_r, every)
    shared = np.asarray(found == 1)
    for k in np.flatnonzero(found == _UNPROVED):
        shared[k] = exact_reference.intersects(p.corners, r.corners, poses_p[k], poses_r[k], p.radius, r.radius)
    return shared
