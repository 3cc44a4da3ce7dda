"""Checks that a vehicle of its kind can drive the pieces of a curve, from the motion's start to its end.

In: a well-formed proof. Out: nothing, or an `UnprovedError`. Pieces tile [0, 1]. Each is an arc of the turning radius
or a line, tangent to the heading, and on Dubins curves it is driven forwards. Neighbours meet up to their slips. The
first piece begins at the start and the last one leads to the end. The root moves along them at constant speed.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

from flint import arb

from plannercheck.proofs.data import ProofData
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.planar_paths import Paths
from plannercheck.proofs.planar_proof import Piece, PlanarModel, PlanarMotion

# OMPL's curves may miss their end by this, in turning radii and rad.
_END_JUMP = 4e-6

# An arc's radius is the turning radius up to this part of it.
_RADIUS_ROUNDING = 1e-12

# A piece's share of the parameter may differ from its share of the length by this part of the whole.
_SPEED_ROUNDING = 1e-9


def check_motion(proof: ProofData) -> None:
    """Raises an `UnprovedError` unless the motion is one of its kind."""
    model, motion = proof.model, proof.motion
    assert isinstance(model, PlanarModel)
    assert isinstance(motion, PlanarMotion)
    if motion.curve == "straight":
        if motion.pieces or motion.turning_radius != 0:
            raise UnprovedError("a straight motion has pieces or a turning radius")
        return
    if model.links[0].joint != "free" or not motion.pieces:
        raise UnprovedError("a curve needs a free root and pieces")
    radius = motion.turning_radius
    if not (isinstance(radius, float) and 0 < radius < math.inf):
        raise UnprovedError(f"the turning radius is {radius!r:.40}, no positive length")
    _check_parameters(motion.pieces)
    for k, piece in enumerate(motion.pieces):
        _check_drivable(piece, motion, proof.margin, f"piece {k}")
    _check_joins(model, motion, proof.margin)
    _check_speed(motion, proof.margin)


def _check_parameters(pieces: tuple[Piece, ...]) -> None:
    reached = 0.0
    for k, piece in enumerate(pieces):
        if piece.start != reached or not piece.start < piece.end:
            raise UnprovedError(
                f"piece {k}, [{piece.start!r}, {piece.end!r}], does not begin where the one before ends"
            )
        reached = piece.end
    if reached != 1.0:
        raise UnprovedError(f"the pieces end at {reached!r}, not at 1")


def _check_drivable(piece: Piece, motion: PlanarMotion, margin: float, what: str) -> None:
    """Seen from the heading, the root's speed is `way` turned back on a line, i turn arm on an arc: along x."""
    loose = piece.slip + margin
    if piece.turn != 0 or any(piece.arm):
        off = abs(abs(piece.arm[1]) - motion.turning_radius)
        if any(piece.way) or piece.arm[0] != 0 or not off <= _RADIUS_ROUNDING * motion.turning_radius:
            raise UnprovedError(
                f"{what} is no arc of the turning radius, {motion.turning_radius!r} m, that the heading touches"
            )
        forwards = arb(-piece.turn) * piece.arm[1]
    else:
        sin, cos = arb(piece.heading).sin_cos()
        forwards = cos * piece.way[0] + sin * piece.way[1]
        if not abs(cos * piece.way[1] - sin * piece.way[0]) <= loose:
            raise UnprovedError(f"{what} is a line that does not go along the heading")
    if motion.curve == "dubins" and not forwards >= -loose:
        raise UnprovedError(f"{what} goes backwards, which no Dubins curve does")


def _check_joins(model: PlanarModel, motion: PlanarMotion, margin: float) -> None:
    lever, paths, last = _lever(model), Paths(model, motion), len(motion.pieces) - 1
    ends = [paths.ends(k) for k in range(len(motion.pieces))]
    loose = margin / 2  # the other half is for computed poses
    slips = [piece.slip for piece in motion.pieces]
    for k, (before, after) in enumerate(pairwise(ends)):
        if not _moved(before[1], after[0], lever) <= slips[k] + slips[k + 1] + loose:
            raise UnprovedError(f"pieces {k} and {k + 1} do not meet up to their slips")
    given = paths.given_ends()
    if not _moved(ends[0][0], given[0], lever) <= slips[0] + loose:
        raise UnprovedError("piece 0 does not begin at the motion's start")
    jump = _END_JUMP * (motion.turning_radius + lever)
    if not _moved(ends[last][1], given[1], lever) <= slips[last] + loose + jump:
        raise UnprovedError(f"piece {last} does not lead to the motion's end")


def _check_speed(motion: PlanarMotion, margin: float) -> None:
    lengths = [math.hypot(*p.way) + abs(p.turn) * math.hypot(*p.arm) for p in motion.pieces]
    whole = sum(lengths)
    loose = 2 * sum(piece.slip + margin for piece in motion.pieces) + _SPEED_ROUNDING * whole
    for k, (piece, length) in enumerate(zip(motion.pieces, lengths, strict=True)):
        if not abs((piece.end - piece.start) * whole - length) <= loose:
            raise UnprovedError(f"piece {k} is gone through at another speed than the rest")


def _moved(first: tuple[Any, Any], second: tuple[Any, Any], lever: float) -> Any:
    """How far any point within a lever of the root is apart at two poses of the root, whole turns aside."""
    turn = first[1] - second[1]
    turn = turn - 2 * arb.pi() * round(float(turn.mid()) / (2 * math.pi))
    return abs(first[0] - second[0]) + lever * abs(turn)


def _lever(model: PlanarModel) -> float:
    """No point of the robot is further than this from its root, m."""
    reaches = [0.0] * len(model.links)
    for k, link in enumerate(model.links):
        if k > 0:
            reaches[k] = reaches[link.parent] + math.hypot(link.x, link.y)
    points = [reaches[b.link] + math.hypot(x, y) for b in model.bodies if b.link >= 0 for x, y in b.vertices.tolist()]
    return max(points, default=0.0) * (1 + 2.0**-40)
