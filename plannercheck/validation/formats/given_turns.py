"""Motions on which a continuous joint runs through the given numbers, cut into pieces of less than half a turn.

In: configurations of a trajectory message, and which motions between them run as given. Out: configurations, with added
ones in between, and the number of pieces of each motion. A controller interpolates positions as they are
(ros2_controllers, `Trajectory::interpolate_between_points`): from 3 to -3 rad it turns by 6 rad, through 0. Proofs of
motions take the shorter turn of a continuous joint. On pieces of less than half a turn both are the same.
"""

from __future__ import annotations

import numpy as np

from plannercheck.checking.protocols import AnyRobot
from plannercheck.common.array_types import Bools, Floats, Ints64
from plannercheck.common.errors import PlannercheckError
from plannercheck.planar.robot import Robot as PlanarRobot
from plannercheck.robots.configurations import PLAIN, ConfigurationMap
from plannercheck.robots.robot import Robot

# A continuous joint turns by at most so much in a piece, rad: less than half a turn, with room for rounding.
LONGEST_TURN = 3.0

# A path of more pieces is a mistake: a joint would turn around half a million times.
_MOST_PIECES = 10**6


def largest_turns(robot: AnyRobot, rows: Floats, of_joints: ConfigurationMap | None = None) -> Floats:
    """How far, (k - 1,) rad, joints whose motions take the short way turn at most from row to row.

    Rows are (k, n) numbers, of which a continuous joint takes one, its angle; `of_joints` says how they become
    configurations, None if they are.
    """
    steps = np.abs(np.diff(rows, axis=0))
    if of_joints is not None:  # each continuous joint has a cosine and a sine, followers as well
        turning = (of_joints.columns >= 0) & (of_joints.roles != PLAIN)
        columns = np.asarray(of_joints.columns[turning], dtype=np.int64)
        steps = steps[:, columns] * np.abs(of_joints.multipliers[turning])
    elif isinstance(robot, Robot):
        steps = steps[:, np.flatnonzero(robot.configuration_map.turning_columns())]
    else:
        assert isinstance(robot, PlanarRobot)
        steps = steps[:, np.flatnonzero(robot.angles)]
    return np.asarray(steps.max(axis=1, initial=0.0))


def cut_at_turns(rows: Floats, turns: Floats, as_given: Bools) -> tuple[Floats, Ints64]:
    """Cuts motions into equal pieces.

    Args:
        rows: (k, n) numbers of configurations.
        turns: (k - 1,) how far continuous joints turn, rad.
        as_given: (k - 1,) which motions run through the numbers as given; the others stay whole.

    Returns:
        (m, n) the rows with others in between, which are rounded once; and (k - 1,) the pieces of each motion.
    """
    wanted = np.where(as_given, np.ceil(turns / LONGEST_TURN), 1.0)
    if not wanted.sum() <= _MOST_PIECES:
        raise PlannercheckError(f"a continuous joint turns by {turns.max():.3g} rad in one motion, which no robot does")
    pieces = np.maximum(wanted, 1.0).astype(np.int64)
    if (pieces == 1).all():
        return rows, pieces
    out = [rows[:1]]
    for start, end, count in zip(rows[:-1], rows[1:], pieces.tolist(), strict=True):
        parts = (np.arange(1, count) / count)[:, None]
        out += [(1 - parts) * start + parts * end, end[None]]
    return np.concatenate(out), pieces
