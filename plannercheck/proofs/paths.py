"""Whether proofs prove a whole path: every motion of it, in order, end to end.

In: confirmed proofs of one file in their order, and the path's configurations. Out: what is missing. A motion from one
configuration to the next is proved by a proof from the one to the other, to the last bit, or by several in a row whose
inner ends are on the straight line between both, up to one rounding: so long turns are cut. Where the path turns a
joint through its numbers as given, no end may be other than it was asked for.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import row_length
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.model_comparisons import joint_reader, path_reader
from plannercheck.proofs.claims import column_names, held_joints, motion_of, named_columns
from plannercheck.proofs.data import Motion, ProofData
from plannercheck.proofs.planar_proof import PlanarModel

# An inner end of a long turn may be off the line by this part of both: rounded products and a sum, there and here.
_ROUNDING = 8 * 2.0**-53

# Straight lines that turn no further are the short way as well, rad.
_SHORT = 3.0

# Missing motions that are named.
_NAMED = 5


@dataclass(frozen=True)
class PathProved:
    """Whether a path is proved.

    Attributes:
        motions: How many motions it has.
        missing: Which of them are not proved, from 0.
        fault: What is missing, in one sentence; None if nothing is.
    """

    motions: int
    missing: tuple[int, ...]
    fault: str | None

    def __bool__(self) -> bool:
        return self.fault is None


def path_proved(proofs: Sequence[ProofData], path: Any, straight: bool = False, robot: Any = None) -> PathProved:
    """Whether proofs prove a path.

    Args:
        proofs: At least one, of one model; those that are confirmed, in their order.
        path: A file, or configurations (k, columns), which are joined the short way.
        straight: Whether straight motions are meant although a file has velocities or accelerations.
        robot: The robot, as for `Proof.verify`, for paths of one number a joint.

    Returns:
        What is missing.

    Raises:
        PlannercheckError: If the file can't be read, holds other joints, or is run along splines.
    """
    proof, as_given = proofs[0], None
    names, columns = column_names(proof), proof.model.columns
    robot = None if isinstance(proof.model, PlanarModel) else robot
    if isinstance(path, str) or hasattr(path, "__fspath__"):
        if Path(path).suffix.lower() != ".npy":  # which names no joints
            names = named_columns(proof, () if robot is None else joint_reader()(robot).names)
        file = path_reader()(path, names, columns, robot)
        if file.bent_by and not straight:
            raise PlannercheckError(
                f"path file {str(path)!r}: its {' and '.join(file.bent_by)} are not zero, so a controller runs splines "
                "between its points: --controller says which, --straight says that straight motions are meant"
            )
        other = held_elsewhere(proof, file.others) or _moved_otherwise(proofs, file.motion_path)
        states, as_given = file.states, file.as_given
        if states.shape[1] != columns:
            raise PlannercheckError(
                f"path file {str(path)!r}: its configurations have {states.shape[1]} numbers, the proof's {columns}: "
                "name the robot, too (--robot, robot=)"
            )
        if other:
            return PathProved(max(1, len(states) - 1), tuple(range(max(1, len(states) - 1))), other)
    elif robot is not None and row_length(path) != columns:
        states = path_reader()(path, names, columns, robot).states
    else:
        states = _configurations(path, columns)
    return _compared(proofs, states, as_given)


def _configurations(path: ArrayLike, columns: int) -> Floats:
    try:
        states = np.atleast_2d(np.asarray(path, dtype=np.float64))
    except (TypeError, ValueError):
        states = np.zeros((0, 0))
    if states.ndim != 2 or states.shape[1] != columns or not len(states) or not np.isfinite(states).all():
        raise PlannercheckError(
            f"path= must be a file, or finite configurations (k, {columns}), k at least 1; with robot= they may have "
            "one number a joint"
        )
    return states


def held_elsewhere(proof: ProofData, others: Mapping[str, float]) -> str | None:
    """The first joint that a path holds at another value than the proof."""
    held = held_joints(proof)
    known = {} if isinstance(proof.model, PlanarModel) else {joint.name: joint for joint in proof.model.joints}
    for name, value in others.items():
        if name not in known:
            return f"the path has the joint {name!r}, which the proof does not know"
        if name not in held:
            return f"the path holds the joint {name!r}, which follows a moving joint in the proof: leave it out"
        # A turn about a negative axis has the opposite value, and the sign of its multiplier, which is a zero, says so.
        if held[name] != [math.copysign(1.0, known[name].multipliers[0]) * value]:
            return f"the path holds the joint {name!r} at {value!r}, the proof at {held[name]}"
    return None


def _moved_otherwise(proofs: Sequence[ProofData], path: str | None) -> str | None:
    """The first motion that goes another way than the path says; files say nothing of curves, so mean straight ones."""
    for k, proof in enumerate(proofs):
        how = motion_of(proof)["path"]
        wanted = "straight" if isinstance(proof.model, PlanarModel) else path or "screw"
        if how not in (wanted, "straight"):
            return f"motion {k} is proved along {how!r}, and the path goes along {wanted!r}"
    return None


def _compared(proofs: Sequence[ProofData], states: Floats, as_given: Any) -> PathProved:
    rows = [tuple(row) for row in states.tolist()]
    motions = list(pairwise(rows)) or [(rows[0], rows[0])]
    starts: dict[tuple[float, ...], list[int]] = {}
    for k, proof in enumerate(proofs):
        if not _is_curve(proof):
            starts.setdefault(proof.motion.start, []).append(k)
    missing, last = list[int](), 0
    for k, (start, end) in enumerate(motions):
        literal = as_given is not None and bool(as_given[k])
        ends = (_chained(proofs, j, start, end, literal) for j in starts.get(start, ()) if j >= last)
        found = next((after for after in ends if after), None)
        if found is None:
            missing.append(k)
        else:
            last = found
    return PathProved(len(motions), tuple(missing), _sentence(missing, motions) if missing else None)


def _chained(proofs: Sequence[ProofData], first: int, start: Any, end: Any, literal: bool) -> int:
    """The index after the proofs that lead from a start to an end, beginning with a given one; 0 if they do not."""
    motion = proofs[first].motion
    if motion.asked_end == end and not (literal and motion.end != motion.asked_end):
        return first + 1
    if not _is_line(proofs[first], start, end, literal):
        return 0
    reached, part = start, 0.0
    for k in range(first, len(proofs)):
        motion = proofs[k].motion
        if motion.start != reached or motion.end != motion.asked_end or _is_curve(proofs[k]):
            return 0
        reached = motion.end
        if reached == end:
            return k + 1
        before, part = part, _part_of(start, end, reached)
        if not before < part < 1:
            return 0
    return 0


def _is_curve(proof: ProofData) -> bool:
    """Whether a proof is of polynomials, which go another way than a path's straight motions."""
    return isinstance(proof.motion, Motion) and bool(proof.motion.inner)


def _is_line(proof: ProofData, start: Any, end: Any, literal: bool) -> bool:
    """Whether the straight line between two configurations is the motion between them, also where it is cut."""
    if isinstance(proof.model, PlanarModel):
        several = set() if motion_of(proof)["path"] == "straight" else set(range(3))
    else:
        several = {column for joint in proof.model.joints if len(joint.columns) > 1 for column in joint.columns}
    turns = (abs(end[column] - start[column]) for column in proof.model.whole_turns)
    short = literal or max(turns, default=0.0) <= _SHORT
    return short and all(start[column] == end[column] for column in several if column >= 0)


def _part_of(start: Any, end: Any, point: Any) -> float:
    """Where on the straight line between two configurations a point is, from 0 to 1; 2 if it is off the line."""
    a, b, p = (np.array(q) for q in (start, end, point))
    way = b - a
    if not way.size or not np.abs(way).max() > 0:
        return 2.0
    k = int(np.argmax(np.abs(way)))
    part = float((p - a)[k] / way[k])
    off = np.abs((1 - part) * a + part * b - p)
    return part if (off <= _ROUNDING * (np.abs(a) + np.abs(b))).all() else 2.0


def _sentence(missing: Sequence[int], motions: Sequence[tuple[Any, Any]]) -> str:
    named = ", ".join(map(str, missing[:_NAMED])) + (", …" if len(missing) > _NAMED else "")
    start, end = (list(q) for q in motions[missing[0]])
    one = len(missing) == 1
    return (
        f"{'motion' if one else 'motions'} {named} of the path's {len(motions)} {'is' if one else 'are'} not proved; "
        f"motion {missing[0]} goes from {start} to {end}"
    )
