"""`pc.first_conflict`: when robots that run their trajectories on one clock first meet each other or the scene.

In: a checker of a cell, trajectories by robot, when each starts, a tube. Out: a `Conflict`: the first instant that
collides, its pair and robots and how long it lasts; or none, with proofs of the whole cell.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.intersection import intersects
from plannercheck.checking.verdicts import PairCertificate, PairVerdict
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.arrays import named_numbers
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.html_tables import html_table
from plannercheck.common.public_names import set_module
from plannercheck.common.shown_times import shown_seconds
from plannercheck.motions.certifier import DEFAULT_TOLERANCE
from plannercheck.motions.checker import Checker
from plannercheck.motions.trajectory_verdict import TrajectoryVerdict
from plannercheck.proofs.proof import Proof
from plannercheck.robots.robot import Robot
from plannercheck.timing.overlaps import needed
from plannercheck.trajectories.one_clock import Run, on_one_clock
from plannercheck.trajectories.trajectory import Trajectory

# The end of a conflict is sought among so many instants, then by halving.
_LOOKS, _HALVINGS = 2000, 60

# One tube for all numbers, or tubes by robot: a number, or one a column; rad and m.
Tubes = ArrayLike | Mapping[str, ArrayLike]


@set_module("plannercheck")
@dataclass(frozen=True, repr=False)
class Conflict:
    """The first conflict of a cell's robots on one clock; false if there is none, proved.

    Attributes:
        instant: The first instant that is found to collide, s on the clock; None if none is. No earlier one than
            `free_until` collides.
        until: The last instant of the pair's conflict that is found, s; infinite if the robots end in it. Among
            neighbours of 2,000 instants the pair may part and meet again.
        robots: The robots that the pair belongs to, by links or by what they carry; one if it meets the scene.
        trajectory: The cell's, from 0 s to the end of the longest.
        starts: When each robot's trajectory starts, s.
        verdict: The cell trajectory's.
    """

    instant: float | None
    until: float | None
    robots: tuple[str, ...]
    trajectory: Trajectory = field(repr=False)
    starts: Mapping[str, float]
    verdict: TrajectoryVerdict = field(repr=False)

    @property
    def free(self) -> bool:
        """Whether it is proved that there is no conflict, with the tube."""
        return self.verdict.free

    @property
    def free_until(self) -> float:
        """It is proved that there is none from 0 s to here, s."""
        return self.verdict.free_until

    @property
    def pair(self) -> PairVerdict | None:
        """The pair that collides; if none does, the one that is too near for its tube and the tolerance."""
        return self.verdict.pair

    @property
    def certificate(self) -> PairCertificate | None:
        """The proof of the pair's collision at the instant: a point that both bodies share."""
        return self.pair.certificate if self.pair is not None and self.instant is not None else None

    @property
    def clearance(self) -> float:
        """Bodies are proved to keep further than this apart, m; 0 if there is a conflict."""
        return self.verdict.clearance

    @property
    def proof(self) -> tuple[Proof, ...] | None:
        """The proofs of the cell trajectory's pieces, in order (`Proof.verify`); None unless it is free."""
        return self.verdict.proof

    def __bool__(self) -> bool:
        return not self.free

    def __repr__(self) -> str:
        return f"Conflict({self.sentence})"

    @property
    def sentence(self) -> str:
        """In words."""
        started = "".join(f", {name} from {shown_seconds(start)} s" for name, start in self.starts.items() if start)
        if self.pair is None:
            return f"none, proved, with {self.clearance:.3g} m of room{started}"
        names, run = " – ".join(self.pair.names), self.verdict
        if self.instant is None or self.until is None:
            return f"none found, but not proved after {shown_seconds(self.free_until)} s: {names} too near{started}"
        lasts = "to the end" if math.isinf(self.until) else f"until {shown_seconds(self.until)} s"
        until = shown_seconds(run.free_until)
        return f"at {shown_seconds(self.instant)} s: {names}, {lasts}; proved free until {until} s{started}"

    def _repr_html_(self) -> str:
        return html_table(repr(self), (), ())


@set_module("plannercheck")
def first_conflict(
    checker: Checker,
    trajectories: Mapping[str, Run],
    starts: Mapping[str, float] | None = None,
    tube: Tubes = 0.0,
    tolerance: float = DEFAULT_TOLERANCE,
) -> Conflict:
    """The first conflict of robots on one clock, among each other, with themselves, and with the scene.

    Before its start a robot stands at its first point, and at the end of its trajectory at the last one. What moves in
    the scene is where it is at these times; what it meets after the last robot has ended is not looked at.

    Args:
        checker: The checker of a cell (`pc.Robot.together`).
        trajectories: By robot of the cell's group; or the configuration (k,) at which a robot stands.
        starts: When a robot's trajectory starts, s on the clock; 0 if not named.
        tube: By how much each number may be off, as for `check_trajectory`; or by robot, of which the others have none.
        tolerance: As for `check_trajectory`.

    Returns:
        The conflict, false if it is proved that there is none.

    Raises:
        PlannercheckError: For unknown or missing robots, trajectories of other widths, a start before 0 s.
    """
    cell = cell_of(checker)
    merged = on_one_clock(cell, trajectories, starts)
    verdict = checker.explain_trajectory(merged, tube_row(cell, tube), tolerance)
    begins = {name: float((starts or {}).get(name, 0.0)) for name, run in trajectories.items() if is_run(run)}
    instant = verdict.collides_at
    until = None if instant is None else _end_of_conflict(*on_scene_clock(checker, merged), instant)
    return Conflict(instant, until, robots_of(cell, verdict.pair), merged, begins, verdict)


def cell_of(checker: Checker) -> Robot:
    """The checker's robot, if it is a cell."""
    if not isinstance(checker, Checker):
        raise PlannercheckError(f"needs a pc.Checker of a cell, not {checker!r:.80}")
    if not checker.robot.parts:
        raise PlannercheckError(f"{checker.robot.name!r} is a single robot: make a cell by pc.Robot.together")
    if not checker._settings.self_collision:
        raise PlannercheckError("without self-collision no pair between two robots of a cell is tested: leave it on")
    return checker.robot


def is_run(run: Run) -> bool:
    """Whether a robot moves."""
    return isinstance(run, Trajectory)


def tube_row(cell: Robot, tube: Tubes) -> ArrayLike:
    """A tube as `check_trajectory` takes it, from tubes by robot."""
    if not isinstance(tube, Mapping):
        return tube
    row = np.zeros(cell.nq)
    for name, given in tube.items():
        if name not in cell.parts:
            raise unknown_name("robot with a tube", name, cell.parts)
        own, columns = named_numbers(given, f"the tube of {name!r}"), cell.parts[name].columns
        if own.shape not in ((1,), (len(columns),)):
            raise PlannercheckError(f"the tube of {name!r} must be a number, or {len(columns)}, not {own.shape}")
        row[columns] = own
    return row


def robots_of(cell: Robot, pair: PairVerdict | None) -> tuple[str, ...]:
    """The robots whose links, or the objects that these carry, a pair has."""
    links = {link: link for link in cell.link_names} | {item.name: str(item.link) for item in cell.carried}
    pairs = [] if pair is None else [links.get(each, "") for each in (pair.first, pair.second)]
    return tuple(dict.fromkeys(name for link in pairs for name in cell.parts if link.startswith(f"{name}/")))


def on_scene_clock(checker: Checker, trajectory: Trajectory) -> tuple[Checker, Trajectory]:
    """What judges a trajectory from 0 s of the scene's clock on, and the trajectory with the columns of what moves."""
    judge, (judged,) = checker._on_clock([trajectory], 0.0)
    return judge, judged


def _end_of_conflict(checker: Checker, trajectory: Trajectory, instant: float) -> float:
    """The last instant up to which the pair that collides at an instant is found to collide."""
    end = float(trajectory.curve.breaks[-1])
    row = int(np.argmax(checker.colliding_pairs(trajectory.position(np.array([instant])))[0]))
    a, b = checker.pairs[row].tolist()
    p, r = needed(checker.polytopes, a), needed(checker.polytopes, b)

    def collide(times: Floats) -> Bools:
        poses = checker.body_poses(trajectory.position(times))
        return np.asarray(intersects(p, r, poses[:, a], poses[:, b]))

    times = np.linspace(instant, end, _LOOKS)[1:]
    apart = np.flatnonzero(~collide(times)) if end > instant else np.zeros(0, dtype=np.int64)
    if not len(apart):
        return math.inf
    first = int(apart[0])
    low, high = float(times[first - 1]) if first else instant, float(times[first])
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        if not low < middle < high:
            break
        low, high = (middle, high) if collide(np.array([middle]))[0] else (low, middle)
    return low
