"""How far the poses at the requested end may be from the poses at the end of the motion.

In: a model, a motion, its bodies. Out: a length, m. Both ends differ by whole turns, and by rounding.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from plannercheck.proofs.data import JOINTS, Model
from plannercheck.proofs.heights import Seen
from plannercheck.proofs.rounding import UP
from plannercheck.proofs.well_formed import unreached


def end_shift(model: Model, motion: Any, seen_bodies: Sequence[Seen], stretch: float) -> float:
    """How far the asked end's poses may be from those of the end that is gone to, by what are no whole turns, m.

    A joint that is off by an angle moves the points beyond it by at most that times their distance from its axis, which
    is at most the sum of all lengths between the joints and within the bodies.
    """
    angles = unreached(model, motion)
    shift = sum(abs(j.multipliers[0]) * angles.get(j.columns[0], 0.0) for j in model.joints)
    if not shift:
        return 0.0
    lengths = [_slide(joint, motion) + _length(joint.placement) for joint in model.joints]
    bodies = zip(model.bodies, seen_bodies, strict=True)  # of a model without pairs there are none
    sizes = (_length(body.pose) + math.hypot(*seen.sizes) * 2 + body.radius for body, seen in bodies)
    furthest = max(_length(link.placement) for link in model.links) + max(sizes, default=0.0)
    return shift * (sum(lengths) + furthest) * stretch * UP


def _length(rows: Sequence[float]) -> float:
    return math.hypot(rows[3], rows[7], rows[11]) * UP


def _slide(joint: Any, motion: Any) -> float:
    """How far a joint shifts its frame at most, m: on any path at most pi / 2 of the way between its ends."""
    count = JOINTS[joint.kind].lengths
    ends = [
        [
            offset if column < 0 else factor * q[column] + offset
            for column, factor, offset in zip(joint.columns, joint.multipliers, joint.offsets, strict=True)
        ][:count]
        for q in (motion.start, motion.end)
    ]
    return (math.hypot(*ends[0]) + math.pi / 2 * math.dist(*ends)) * UP * 1.000002
