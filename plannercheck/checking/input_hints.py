"""Hints for configurations that are probably mistakes: degrees, or columns in another order.

In: configurations as given. Out: a sentence with the likely mistake and its remedy, or an empty string. Hints never
change a verdict.
"""

from __future__ import annotations

import numpy as np

from plannercheck.checking.protocols import AnyChecker, AnyRobot
from plannercheck.common.angles import are_degrees, share_within
from plannercheck.common.array_types import Floats

# If this share of the rows is beyond the limits, all rows are probably wrong.
_SUSPICIOUS_SHARE = 0.5
# Least and largest number of configurations used to find what always collides, and how many pairs are named.
_LEAST_CONFIGURATIONS, _SAMPLES, _SHOWN_PAIRS = 20, 200, 8


def limits_hint(robot: AnyRobot, rows: Floats) -> str:
    """Says what configurations (n, nq) look like if most of them are beyond the limits; else an empty string."""
    start = f"most configurations are beyond the limits of {robot.name!r}"
    if are_degrees(rows, robot.lower, robot.upper):
        return (
            f"{start}, and as degrees they would not be: angles are in rad, convert them by numpy.radians, or on the"
            " command line by --degrees"
        )
    if share_within(rows[:, ::-1], robot.lower, robot.upper) >= _SUSPICIOUS_SHARE:
        return f"{start}, and in reverse order they would not be: {_order(robot)}"
    return f"{start}: {_order(robot)}, in rad and m"


def always_hint(checker: AnyChecker, rows: Floats) -> str:
    """What colliding configurations (n, nq) have in common; empty if nothing, or if they are too few to tell."""
    if len(rows) < _LEAST_CONFIGURATIONS:
        return ""
    always = np.flatnonzero(checker.colliding_pairs(rows[:_SAMPLES]).all(axis=0))
    pairs = dict.fromkeys(checker.pair_names(int(pair)) for pair in always)
    if not pairs:
        return ""
    shown = ", ".join(f"{a} – {b}" for a, b in list(pairs)[:_SHOWN_PAIRS])
    more = f" and {len(pairs) - _SHOWN_PAIRS} more pairs" if len(pairs) > _SHOWN_PAIRS else ""
    return (
        f"every configuration collides, each time by these pairs: {shown}{more}; links that touch by design belong "
        "into the SRDF or the robot YAML's disabled_pairs, which `plannercheck acm --robot FILE --output FILE.srdf` "
        "writes and --srdf FILE.srdf takes; obstacles to be touched belong into the scene's allowed pairs"
    )


def degrees_hint(robot: AnyRobot, q: Floats) -> str:
    """A sentence if a configuration (nq,) seems to be in degrees; else empty."""
    limits = robot.lower, robot.upper
    is_meant = share_within(q[None], *limits) < 1 and are_degrees(q[None], *limits)
    return "as degrees it would be within: angles are in rad" if is_meant else ""


def _order(robot: AnyRobot) -> str:
    return f"columns have to be {', '.join(robot.joint_names)}"
