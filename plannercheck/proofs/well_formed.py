"""Checks that a proof in space is well-formed: indices, finite numbers, rigid placements, hashes, the motion's ends.

In: a proof of any content whose classes are those of `data.py`. Out: nothing, or an `UnprovedError`. After this check
the verifier may index and compute.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import flint
import numpy as np
from flint import arb

from plannercheck.common.arrays import distinct_rows
from plannercheck.common.motion_paths import PATHS
from plannercheck.proofs.covers import check_covers, check_directions, pairs_in_parts
from plannercheck.proofs.data import JOINTS, WORLD, Entry, Hashes, Joint, Model, Motion, PosedBody, ProofData
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.hashing import content_hash
from plannercheck.proofs.numbers_of_proofs import (
    HALF_TURN,
    LARGEST_NUMBER,
    check_length,
    check_numbers,
    check_pairs,
    check_rigid,
    check_tiled,
    check_vertices,
)
from plannercheck.proofs.parts import VERTICES

# How far the length of an axis or a unit vector may be from 1.
LARGEST_STRETCH = 1e-6

# The largest degree of a motion.
MOST_DEGREE = 20

# What may keep a pair apart in space.
_KEEPS_APART = ("plane", "balls", "half-space")

# The precision in which whole turns are taken off angles of up to 1e15 rad: far better than the result's double.
_TURN_BITS = 192


def check_well_formed(proof: ProofData) -> None:
    """Raises an `UnprovedError` for a proof that is not well-formed; `check_tiling` checks the entries."""
    model, motion = proof.model, proof.motion
    if proof.kind != "space" or not isinstance(model, Model) or not isinstance(motion, Motion):
        raise UnprovedError("the proof is not of a motion in space")
    _check_margin(proof.margin)
    _check_tree(model)
    _check_bodies(model)
    check_pairs(model.pairs, len(model.bodies))
    _check_bounded(model)
    _check_ends(model, motion)
    if hashes_of(model) != proof.hashes:
        raise UnprovedError("the model is not the one whose content hashes the proof has")


def hashes_of(model: Model) -> Hashes:
    """The content hashes of a model."""
    mounted = [body for body in model.bodies if body.link != WORLD]
    standing = [body for body in model.bodies if body.link == WORLD]
    return Hashes(content_hash(model.joints, model.links, mounted), content_hash(standing), content_hash(model))


def check_tiling(proof: ProofData) -> None:
    """Raises a `UnprovedError` unless the entries of every pair tile [0, 1], in order, and name what there is.

    Those of a pair in parts have to cover it, in any order.
    """
    assert isinstance(proof.model, Model)
    model = proof.model
    _check_planes_of_half_spaces(proof.model, proof.entries)
    check_covers(proof.model, proof.entries)

    def check_entry(entry: Entry, k: int) -> None:
        check_directions(model, entry, k)

    check_tiled(
        proof.entries,
        len(proof.model.pairs),
        check_entry,
        "1",
        covered=pairs_in_parts(proof.entries),
        known=_KEEPS_APART,
    )


def _check_planes_of_half_spaces(model: Model, entries: Sequence[Entry]) -> None:
    """Raises an `UnprovedError` unless pairs with a half-space, and no others, are kept apart by its plane."""
    for k, entry in enumerate(entries):
        pair = model.pairs[entry.pair] if 0 <= entry.pair < len(model.pairs) else ()
        if (entry.by == "half-space") != any(model.bodies[body].half_space for body in pair):
            raise UnprovedError(f"entry {k} is by {entry.by!r:.40}: only a half-space's own plane keeps a body from it")


def _check_margin(margin: float) -> None:
    check_numbers([margin], "margin")
    if margin < 0:
        raise UnprovedError(f"the margin is {margin!r}, below 0")


def _check_tree(model: Model) -> None:
    for index, joint in enumerate(model.joints):
        what = f"joint {index} ({joint.name!r})"
        if joint.kind not in JOINTS:
            raise UnprovedError(f"{what} is of kind {joint.kind!r:.40}, which is not known")
        if not WORLD <= joint.parent < index:
            raise UnprovedError(f"{what} has the parent {joint.parent}, which is no joint before it")
        _check_placement(joint.placement, what)
        _check_axis(joint, what)
        for values in (joint.columns, joint.multipliers, joint.offsets):
            check_length(values, JOINTS[joint.kind].numbers, what)
        check_numbers((*joint.multipliers, *joint.offsets), what)
        _check_columns(joint, model.columns, what)
    for index, link in enumerate(model.links):
        if not WORLD <= link.joint < len(model.joints):
            raise UnprovedError(f"link {index} ({link.name!r}) is on joint {link.joint}, which there is not")
        _check_placement(link.placement, f"link {index} ({link.name!r})")


def _check_axis(joint: Joint, what: str) -> None:
    check_length(joint.axis, 3, what)
    check_numbers(joint.axis, what)
    if JOINTS[joint.kind].has_axis and not abs(math.hypot(*joint.axis) - 1) <= LARGEST_STRETCH:
        raise UnprovedError(f"{what} has an axis of length {math.hypot(*joint.axis)!r}, not 1")


def _check_columns(joint: Joint, columns: int, what: str) -> None:
    used = [column for column in joint.columns if column != WORLD]
    if not all(0 <= column < columns for column in used):
        raise UnprovedError(f"{what} takes a column that there is not")
    form = JOINTS[joint.kind]
    if not used or form.numbers == 1:
        return
    plain = (-1.0, 1.0) if form.has_axis else (1.0,)
    consecutive = joint.columns == tuple(range(used[0], used[0] + len(joint.columns)))
    if not consecutive or any(joint.offsets) or not all(factor in plain for factor in joint.multipliers):
        raise UnprovedError(f"{what} takes several numbers, which have to be columns in a row as they are")


def _check_placement(rows: Sequence[float], what: str) -> None:
    check_length(rows, 12, what)
    check_numbers(rows, what)
    check_rigid(np.reshape(rows, (3, 4))[:, :3], f"{what} has a placement")


def _check_bodies(model: Model) -> None:
    for index, body in enumerate(model.bodies):
        what = f"body {index} ({body.name!r})"
        if not WORLD <= body.link < len(model.links):
            raise UnprovedError(f"{what} is on link {body.link}, which there is not")
        _check_placement(body.pose, what)
        check_numbers((body.radius, body.padding, body.reach, *body.centre), what)
        check_length(body.centre, 3, what)
        if not 0 <= body.padding <= body.radius or body.reach < 0:
            raise UnprovedError(f"{what} has a negative length, or a padding beyond its radius")
        if body.half_space:
            _check_half_space(body, what)
        elif body.parts and type(body.vertices) is np.ndarray and body.vertices.shape == (0,):
            pass  # an empty set
        else:
            check_vertices(body.vertices, 3, what)
        _check_parts(body, what)
        _check_triangles(body, what)


def _check_parts(body: PosedBody, what: str) -> None:
    check_numbers([body.base], what)
    if not body.parts:
        if body.radii is not None or body.base:
            raise UnprovedError(f"{what} has radii or a base, and no parts")
        return
    if not isinstance(body.parts, str) or body.parts not in VERTICES:
        raise UnprovedError(f"{what} has parts {body.parts!r:.40}, which are not known")
    if body.triangles or body.half_space or len(body.vertices) % VERTICES[body.parts]:
        raise UnprovedError(f"{what} has {len(body.vertices)} vertices for {body.parts}, or is of another kind as well")
    if (body.radii is None) != (body.parts != "balls") or (body.base and body.parts != "prisms"):
        raise UnprovedError(f"{what} has radii that are not of balls, or a base that is not of prisms")
    if body.radii is not None and not _are_radii(body.radii, len(body.vertices)):
        raise UnprovedError(f"{what} has radii that are not one for all, or one for each ball, of at least 0")


def _are_radii(radii: Any, count: int) -> bool:
    if type(radii) is not np.ndarray or radii.dtype != np.float64 or radii.shape not in ((1,), (count,)):
        return False
    return bool(((radii >= 0) & (radii <= LARGEST_NUMBER)).all())


def _check_half_space(body: PosedBody, what: str) -> None:
    check_length(body.half_space, 4, what)
    check_numbers(body.half_space, what)
    if not any(body.half_space[:3]):
        raise UnprovedError(f"{what} is a half-space whose normal is 0")
    if body.link != WORLD or body.triangles or np.size(body.vertices):
        raise UnprovedError(f"{what} is a half-space that is on a link, or has vertices or triangles as well")


def _check_bounded(model: Model) -> None:
    """Raises an `UnprovedError` for a pair of two half-spaces."""
    for index, (a, b) in enumerate(model.pairs):
        if model.bodies[a].half_space and model.bodies[b].half_space:
            raise UnprovedError(f"pair {index} is of two half-spaces")


def _check_triangles(body: PosedBody, what: str) -> None:
    """Corners have to be there, and no two vertices the same: a surface is closed or open by its indices."""
    if not body.triangles:
        return
    if not all(0 <= k < len(body.vertices) for triangle in body.triangles for k in triangle):
        raise UnprovedError(f"{what} has a triangle with a corner that there is not")
    if len(distinct_rows(body.vertices + 0.0)[0]) < len(body.vertices):  # -0 is 0
        raise UnprovedError(f"{what} has a vertex twice")


def _check_ends(model: Model, motion: Motion) -> None:
    if motion.path not in PATHS:
        raise UnprovedError(f"the motion's path is {motion.path!r:.40}, which is not known")
    for name, q in (("start", motion.start), ("end", motion.end), ("asked end", motion.asked_end)):
        check_length(q, model.columns, f"the motion's {name}")
        check_numbers(q, f"the motion's {name}")
    _check_curve(model, motion)
    check_numbers(motion.clock, "the motion's clock")
    if motion.clock and not (len(motion.clock) == 2 and motion.clock[0] < motion.clock[1]):
        raise UnprovedError(f"the motion's clock is {list(motion.clock)!s:.80}: not a time and a later one")
    for column in model.whole_turns:
        if not 0 <= column < model.columns:
            raise UnprovedError(f"column {column} of whole turns is not there")
        users = [joint for joint in model.joints if column in joint.columns]
        if any(joint.kind != "turn" or joint.multipliers[0] % 1 for joint in users):
            raise UnprovedError(f"a whole turn of column {column} is none of every joint that follows it")
        if not motion.inner and not abs(motion.end[column] - motion.start[column]) <= HALF_TURN:
            raise UnprovedError(f"the motion turns column {column} by more than half a turn: not the short way")
    for column, (end, asked) in enumerate(zip(motion.end, motion.asked_end, strict=True)):
        if end != asked and column not in model.whole_turns:
            raise UnprovedError(f"the motion ends at {end!r} in column {column}, where {asked!r} was asked for")
    for joint in model.joints:
        _check_unit(joint, motion)


def _check_curve(model: Model, motion: Motion) -> None:
    """Inner control points and the tube."""
    if len(motion.inner) not in range(0, max(1, MOST_DEGREE * model.columns), model.columns or 1):
        raise UnprovedError(
            f"the motion has {len(motion.inner)} inner numbers: not {model.columns} for each of at most "
            f"{MOST_DEGREE - 1} control points"
        )
    check_numbers((*motion.inner, *motion.tube), "the motion's curve")
    if motion.tube:
        check_length(motion.tube, model.columns, "the motion's tube")
    if (motion.inner or motion.tube) and motion.end != motion.asked_end:
        raise UnprovedError("the motion follows a curve or has a tube, and another end was asked for")
    for joint in model.joints:
        form = JOINTS[joint.kind]
        if motion.inner and motion.path != "slerp" and form.is_pose and max(joint.columns) >= 0:
            raise UnprovedError(f"joint {joint.name!r} follows a curve, and its path is not slerp")
        units = [column for column in joint.columns[form.lengths :] if form.has_unit and column >= 0]
        if motion.tube and any(motion.tube[column] for column in units):
            raise UnprovedError(f"joint {joint.name!r} has a tube around a cosine, a sine or a quaternion")
    if not all(width >= 0 for width in motion.tube):
        raise UnprovedError("the motion's tube is narrower than 0")


def _check_unit(joint: Joint, motion: Motion) -> None:
    form = JOINTS[joint.kind]
    if not form.has_unit:
        return
    held = max(joint.columns) < 0
    ends = [joint.offsets] if held else [[q[c] for c in joint.columns] for q in (motion.start, motion.end)]
    for values in ends:
        if not abs(math.hypot(*values[form.lengths :]) - 1) <= LARGEST_STRETCH:
            raise UnprovedError(f"joint {joint.name!r} has a quaternion, or cosine and sine, that is not of length 1")


def unreached(model: Model, motion: Motion) -> dict[int, float]:
    """By column of whole turns, a bound on the difference of the ends besides whole turns, rad."""
    bits, flint.ctx.prec = flint.ctx.prec, _TURN_BITS
    try:
        out = {}
        for column in model.whole_turns:
            difference = arb(motion.end[column]) - arb(motion.asked_end[column])
            turns = round(float(difference / (2 * arb.pi())))
            out[column] = float((difference - 2 * arb.pi() * turns).abs_upper()) * (1 + 1e-12)
        return out
    finally:
        flint.ctx.prec = bits
