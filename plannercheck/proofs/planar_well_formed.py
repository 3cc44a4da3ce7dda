"""Checks that a proof in the plane is well-formed: indices, finite numbers, rigid poses, circles, hashes, ends, margin.

In: a proof of any content whose classes are those of `planar_proof.py`. Out: nothing, or an `UnprovedError`. After this
check the verifier may index and compute.
"""

from __future__ import annotations

import math

import numpy as np
from flint import arb

from plannercheck.proofs.data import Entry, Hashes, ProofData
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.hashing import content_hash
from plannercheck.proofs.numbers_of_proofs import (
    HALF_TURN,
    LARGEST_DEFECT,
    check_length,
    check_numbers,
    check_pairs,
    check_rigid,
    check_tiled,
    check_vertices,
)
from plannercheck.proofs.planar_proof import Piece, PlanarBody, PlanarLink, PlanarModel, PlanarMotion

_WORLD = -1
_WIDTHS = {"fixed": 0, "revolute": 1, "free": 3}
_CURVES = ("straight", "dubins", "reeds_shepp")

# With u = 2^-53, L links, A = 1 + all angles' sizes and S the size of what is posed: an angle of the chain is a sum of
# L + 1 numbers, each interpolated with an error of 3 u, and errs by (L + 4) u A; sine and cosine add 4 u; so a turned
# length errs by that much of its part of S; sums of positions add 3 u S a link. Two bodies: less than 2 * 16 u L A S.
# As much again is for the start of a curve, whose heading loses its whole turns.
_ROUNDING = 2.0**-47


def check_well_formed(proof: ProofData) -> None:
    """Raises an `UnprovedError` for a proof that is not well-formed; curves and entries are checked elsewhere."""
    model, motion = proof.model, proof.motion
    if proof.kind != "plane" or not isinstance(model, PlanarModel) or not isinstance(motion, PlanarMotion):
        raise UnprovedError("the proof is not of a motion in the plane")
    _check_links(model)
    for index, body in enumerate(model.bodies):
        _check_body(body, len(model.links), f"body {index} ({body.name!r})")
    check_pairs(model.pairs, len(model.bodies))
    _check_ends(model, motion)
    for index, piece in enumerate(motion.pieces):
        _check_piece(piece, f"piece {index}")
    if hashes_of(model) != proof.hashes:
        raise UnprovedError("the model is not the one whose content hashes the proof has")
    check_numbers([proof.margin], "margin")
    least = least_margin(model, motion)
    if not proof.margin >= least:
        raise UnprovedError(f"the margin is {proof.margin!r} m; computed poses may be off by {least!r}")


def hashes_of(model: PlanarModel) -> Hashes:
    """The content hashes of a model."""
    mounted = [body for body in model.bodies if body.link != _WORLD]
    standing = [body for body in model.bodies if body.link == _WORLD]
    return Hashes(content_hash(model.links, mounted), content_hash(standing), content_hash(model))


def least_margin(model: PlanarModel, motion: PlanarMotion) -> float:
    """The largest error of computed poses of two bodies on this motion, m."""
    first = 2 if model.links[0].joint == "free" else 0
    size = sum(math.hypot(link.x, link.y) for link in model.links)
    size += max((math.hypot(*row) for body in model.bodies if body.link >= 0 for row in body.vertices), default=0.0)
    if motion.pieces:
        size += max(sum(map(abs, (*piece.origin, *piece.way, *piece.arm))) for piece in motion.pieces)
    size += max(sum(map(abs, q[:first])) for q in (motion.start, motion.end))
    angles = 1 + sum(abs(link.angle) for link in model.links)
    angles += sum(map(abs, motion.start[first:])) + sum(map(abs, motion.asked_end[first:]))
    return _ROUNDING * len(model.links) * angles * size


def check_tiling(proof: ProofData) -> None:
    """Raises an `UnprovedError` unless the entries of every pair tile [0, 1], in order, and name what there is.

    On curves the end counts by itself.
    """
    assert isinstance(proof.motion, PlanarMotion)
    check_tiled(proof.entries, len(proof.model.pairs), _check_entry, "the end", bool(proof.motion.pieces))


def _check_entry(entry: Entry, k: int) -> None:
    if entry.by == "plane":
        if len(entry.direction) != 2 or not any(entry.direction):
            raise UnprovedError(f"entry {k} needs a direction of two numbers that are not both 0")
        check_numbers(entry.direction, f"direction of entry {k}")


def _check_links(model: PlanarModel) -> None:
    column = 0
    if not model.links:
        raise UnprovedError("the robot has no links")
    for index, link in enumerate(model.links):
        _check_link(link, index, column)
        column += _WIDTHS[link.joint]
    if column != model.columns:
        raise UnprovedError(f"the links take {column} numbers, a configuration has {model.columns}")


def _check_link(link: PlanarLink, index: int, column: int) -> None:
    what = f"link {index} ({link.name!r})"
    if link.joint not in _WIDTHS:
        raise UnprovedError(f"{what} has a joint of kind {link.joint!r:.40}, which is not known")
    if not (link.parent == _WORLD if index == 0 else 0 <= link.parent < index):
        raise UnprovedError(f"{what} has the parent {link.parent}, which is no link before it")
    if link.joint == "free" and index > 0:
        raise UnprovedError(f"{what} is free, and not the first")
    if link.column != column:
        raise UnprovedError(f"{what} takes column {link.column}, where column {column} is the next")
    check_numbers((link.x, link.y, link.angle), what)


def _check_body(body: PlanarBody, links: int, what: str) -> None:
    if not _WORLD <= body.link < links:
        raise UnprovedError(f"{what} is on link {body.link}, which there is not")
    check_length(body.pose, 6, what)
    check_length(body.centre, 2, what)
    check_numbers((*body.pose, *body.centre, body.reach), what)
    matrix = np.reshape(body.pose, (2, 3))
    if body.link >= 0 and not (matrix == np.eye(2, 3)).all():
        raise UnprovedError(f"{what} is on a link, but has a pose of its own")
    check_rigid(matrix[:, :2], f"{what} has a pose")
    check_vertices(body.vertices, 2, what)
    # Stretched by the pose, too: by less than the defect.
    held = arb(body.reach) / (1 + 2 * LARGEST_DEFECT if body.link < 0 else 1)
    for x, y in body.vertices.tolist():
        if not (arb(x) - body.centre[0]) ** 2 + (arb(y) - body.centre[1]) ** 2 <= held**2:
            raise UnprovedError(f"{what} has the vertex ({x!r}, {y!r}) outside its circle")
    if body.reach < 0:
        raise UnprovedError(f"{what} has a circle of negative radius")


def _check_ends(model: PlanarModel, motion: PlanarMotion) -> None:
    for name, q in (("start", motion.start), ("end", motion.end), ("asked end", motion.asked_end)):
        check_length(q, model.columns, f"the motion's {name}")
        check_numbers(q, f"the motion's {name}")
    if motion.curve not in _CURVES:
        raise UnprovedError(f"the curve is {motion.curve!r:.40}, which is not known")
    angles = {link.column + (2 if link.joint == "free" else 0) for link in model.links if link.joint != "fixed"}
    if not set(model.whole_turns) <= angles:
        raise UnprovedError(f"columns {sorted(set(model.whole_turns) - angles)} of whole turns are no angles")
    for column, (start, end, asked) in enumerate(zip(motion.start, motion.end, motion.asked_end, strict=True)):
        keeps = motion.curve != "straight" and column == 2
        if column not in model.whole_turns or keeps:
            if end != asked:
                raise UnprovedError(f"the motion ends at {end!r} in column {column}, where {asked!r} was asked for")
            continue
        if not abs(end - start) <= HALF_TURN:
            raise UnprovedError(f"the motion turns column {column} by more than half a turn: not the short way")
        turns = round((asked - end) / (2 * math.pi))
        off = arb(asked) - end - 2 * arb.pi() * turns
        if not abs(off) <= 2.0**-51 * (abs(asked) + abs(end)):
            raise UnprovedError(
                f"the motion ends at {end!r} in column {column}, no whole turns from {asked!r} asked for"
            )


def _check_piece(piece: Piece, what: str) -> None:
    for values in (piece.origin, piece.way, piece.arm):
        check_length(values, 2, what)
    numbers = piece.start, piece.end, *piece.origin, *piece.way, piece.heading, piece.turn, *piece.arm, piece.slip
    check_numbers(numbers, what)
    if piece.slip < 0:
        raise UnprovedError(f"{what} has a negative slip")
