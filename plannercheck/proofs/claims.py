"""What a verified proof claims, as plain data and in words: for the one who receives it.

In: a proof that is well-formed. Out: a dictionary of JSON's values, the names of a configuration's columns, and a line.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from plannercheck.common.errors import PlannercheckError
from plannercheck.common.shown_times import shown_span
from plannercheck.proofs.data import JOINTS, Joint, Model, Motion, ProofData
from plannercheck.proofs.planar_proof import PlanarModel, PlanarMotion

# Kinds of joints whose way between two configurations `Motion.path` names.
_FREE = tuple(kind for kind, form in JOINTS.items() if form.is_pose)


def motion_of(proof: ProofData) -> dict[str, Any]:
    """The motion of a proof: its ends, and how the robot moves between them; a malformed one as well."""
    motion = proof.motion
    if isinstance(motion, PlanarMotion):
        how: dict[str, Any] = {"path": motion.curve, "turning_radius": motion.turning_radius if motion.pieces else None}
    else:
        free = any(joint.kind in _FREE for joint in getattr(proof.model, "joints", ()))
        curve = "polynomial" if motion.inner else "straight"
        how = {"path": motion.path if free else curve, "turning_radius": None}
        how |= {"degree": _degree(motion), "inner": list(motion.inner), "tube": list(motion.tube)}
        how |= {"clock": list(motion.clock)} if motion.clock else {}
    ends = {"start": list(motion.start), "end": list(motion.end), "asked_end": list(motion.asked_end)}
    return {**ends, **how, "margin": proof.margin}


def _degree(motion: Motion) -> int:
    return 1 + len(motion.inner) // max(1, len(motion.start))


def sentence_of(motion: dict[str, Any]) -> str:
    """A motion in words; JSON has all digits."""
    radius, asked = motion["turning_radius"], motion["asked_end"]
    turning = "" if radius is None else f" with a turning radius of {radius:.9g} m"
    other = "" if asked == motion["end"] else f" (asked for: {_listed(asked)})"
    degree = f" of degree {motion['degree']}" if motion.get("inner") else ""
    return (
        f"{motion['path']}{degree}{turning} from {_listed(motion['start'])} to {_listed(motion['end'])}{other}"
        f"{_around(motion.get('tube', ()))}{timed(motion.get('clock', ()))}, margin {motion['margin']:.3g} m"
    )


def _around(tube: Sequence[float]) -> str:
    if not any(tube):
        return ""
    widths = {f"{width:.9g}" for width in tube}
    told = widths.pop() if len(widths) == 1 else _listed(tube)
    return f", and at every instant every configuration within {told} rad or m of it in each number"


def timed(clock: Sequence[float]) -> str:
    """A clock in words."""
    return f", from {shown_span(clock[0], clock[-1])} of the scene's clock" if clock else ""


def _listed(values: Sequence[float]) -> str:
    return f"({', '.join(f'{value:.9g}' for value in values)})"


def clock_of(proofs: Sequence[ProofData]) -> tuple[float, ...]:
    """The times of the scene's clock at which motions begin or end, s, growing; none where nothing moves."""
    return tuple(sorted({time for proof in proofs for time in getattr(proof.motion, "clock", ())}))


def least_padding(proof: ProofData) -> float | None:
    """What every pair keeps besides not touching, m; None in the plane."""
    model = proof.model
    if isinstance(model, PlanarModel):
        return None
    return min((model.bodies[a].padding + model.bodies[b].padding for a, b in model.pairs), default=0.0)


def held_joints(proof: ProofData) -> dict[str, list[float]]:
    """The joints that stand still, which no file says: by name, where."""
    model = proof.model
    joints = () if isinstance(model, PlanarModel) else model.joints
    return {joint.name: list(joint.offsets) for joint in joints if max(joint.columns) < 0}


def column_names(proof: ProofData, known: Collection[str] = ()) -> tuple[str, ...]:
    """The joints that give a configuration its numbers, in their order: one that takes several stands there once.

    Of joints that take a number as it is, one that is `known` to give it stands there, else the first one.
    """
    model = proof.model
    if isinstance(model, PlanarModel):
        given = {"free": ("x", "y", "theta"), "fixed": ()}
        return tuple(name for link in model.links for name in given.get(link.joint, (f"{link.name}_joint",)))
    leaders = _leaders(model, known)
    return tuple(leaders[column].name for column in sorted(leaders))


def _leaders(model: Model, known: Collection[str]) -> dict[int, Joint]:
    """By column the joint that gives its name to the number of this column, and to those behind it that it takes."""
    found: dict[int, Joint] = {}
    for joint in sorted(model.joints, key=lambda joint: (not _is_plain(joint), joint.name not in known)):
        found.setdefault(joint.columns[0], joint)  # a leader takes its column as it is, a follower seldom does
    return {column: joint for column, joint in found.items() if column >= 0}


def named_columns(proof: ProofData, known: Collection[str] = ()) -> tuple[str, ...]:
    """`column_names` by which files of paths are read.

    Raises:
        PlannercheckError: If a joint that is not known and one that may turn the other way take the same number.
    """
    if isinstance(proof.model, Model):
        leaders = _leaders(proof.model, known)
        for joint in filter(_is_plain, proof.model.joints):
            leader = leaders.get(joint.columns[0], joint)
            # The signs of multipliers and axes are those of the file only where a joint slides and does not turn.
            form = JOINTS[joint.kind]
            same = form.lengths == form.numbers and (joint.kind, joint.multipliers) == (leader.kind, leader.multipliers)
            if joint is not leader and not same and leader.name not in known:
                raise PlannercheckError(
                    f"joints {leader.name!r} and {joint.name!r} take the same number of a configuration, and the robot"
                    " says which one follows: name it (--robot, robot=)"
                )
    return column_names(proof, known)


def _is_plain(joint: Joint) -> bool:
    """Whether a joint takes its first number as it is, or the other way round."""
    return joint.offsets[0] == 0 and abs(joint.multipliers[0]) == 1


def robots_of(proof: ProofData, columns: int | None) -> dict[str, list[int]]:
    """Of a proof about several robots: each one's columns, by the name before the slash of its joints.

    The robots have so many columns, the first ones; none are found if that is not known.
    """
    found: dict[str, list[int]] = {}
    names = column_names(proof)[:columns]
    if columns is None or not all("/" in name for name in names) or len(names) != columns:
        return {}
    for column, name in enumerate(names):
        found.setdefault(name.partition("/")[0], []).append(column)
    return found if len(found) > 1 else {}
