"""Figures of a plan's corners after timing: `Timing`, which `pc.time_path` stores in its trajectory."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Timing:
    """What rounding the corners of a plan brought.

    Attributes:
        saved: How much longer the plan takes if it stops at each corner, s.
        corners: How many corners the plan has; a waypoint on a straight line is none.
        stops: How many of them the trajectory stops at.
        cut: How many blends had to be made smaller, or given up, until the trajectory was proved.
        tolerance: With which it was proved, m: the one that was asked for, or less.
    """

    saved: float
    corners: int
    stops: int
    cut: int
    tolerance: float
