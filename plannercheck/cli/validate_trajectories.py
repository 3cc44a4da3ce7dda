"""`plannercheck validate --path` for trajectories: judged as the controller runs them.

In: a checker's robot and scene, a file of a trajectory, options. Out: `JudgedTrajectory`, a sentence or a JSON object.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from plannercheck.cli.cell_paths import add_delay_argument
from plannercheck.cli.proved_paths import PathProof, proof_file, write_proofs
from plannercheck.cli.told_certificates import certificate_as_json, certificate_in_words
from plannercheck.cli.trajectory_files import (
    add_controller_argument,
    add_start_time_argument,
    listed_numbers,
    trajectory_of,
)
from plannercheck.common.array_types import Floats
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.shown_times import shown_seconds
from plannercheck.motions.checker import Checker
from plannercheck.motions.trajectory_verdict import TrajectoryVerdict
from plannercheck.robots.robot import Robot
from plannercheck.trajectories import Excess, Trajectory, joint_limits
from plannercheck.validation.formats.paths import read_robot_path

# Options by which a file is judged as a trajectory, whatever is in it.
OPTIONS = ("--controller", "--tube", "--start", "--start-time", "--message", "--joint-limits")

_MESSAGES = (".json", ".yaml", ".yml")


def add_trajectory_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options."""
    group = parser.add_argument_group("trajectories, as --path")
    add_controller_argument(group, "prove")
    group.add_argument(
        "--tube",
        type=listed_numbers,
        metavar="RAD",
        help="prove every configuration within this of the trajectory, rad and m: one number, or one a joint, with "
        "commas, e.g. the controller's path tolerances",
    )
    group.add_argument(
        "--start",
        type=listed_numbers,
        metavar="V,V,…",
        help="where the robot stands when it gets the trajectory: the way to the first point is proved as well",
    )
    add_delay_argument(group)
    add_start_time_argument(group)
    group.add_argument(
        "--message", type=int, metavar="N", help="which trajectory of a DisplayTrajectory or of a bag, from 0"
    )
    group.add_argument(
        "--joint-limits",
        type=Path,
        metavar="FILE",
        help="MoveIt's joint_limits.yaml: speeds and accelerations are held against it, and speeds against the URDF",
    )


def is_asked(options: argparse.Namespace) -> bool:
    """Whether files are to be judged as trajectories, whatever is in them."""
    names = (name.removeprefix("--").replace("-", "_") for name in OPTIONS)
    return any(getattr(options, name) is not None for name in names)


@dataclass(frozen=True)
class JudgedTrajectory:
    """A trajectory and what came of it.

    Attributes:
        trajectory: The trajectory.
        verdict: Its verdict.
        limits: Limits that it breaks, also of speeds and accelerations.
        duration: Time that it took, s.
        proved: What came of proving it; None if that was not asked for.
    """

    trajectory: Trajectory
    verdict: TrajectoryVerdict
    limits: tuple[Excess, ...]
    duration: float
    proved: PathProof | None

    @property
    def passed(self) -> bool:
        """Whether it is free, within the limits, and proved if that was asked for."""
        return self.verdict.free and not self.limits and (self.proved is None or self.proved.written)

    @property
    def sentence(self) -> str:
        """For the terminal."""
        verdict, tube = self.verdict, _shown_tube(self.verdict.tube)
        run = f"{len(self.trajectory.curve.pieces)} pieces, run by {self.trajectory.controller} in"
        run = f"{run} {shown_seconds(self.trajectory.duration)} s{f', tube {tube}' if tube else ''}"
        room = f"largest tube {verdict.largest_tube:.3g}"
        if verdict.free:
            found = f"free at every instant ({run}); clearance {verdict.clearance:.3g} m, least at"
            parts = [f"{found} {shown_seconds(verdict.clearance_at)} s{verdict.clock}; {room}"]
        else:
            until = shown_seconds(verdict.free_until)
            parts = [f"not free ({run}): proved free until {until} s{verdict.clock}, {self._stop()}; {room}"]
        parts += [f"breaks a limit: {excess}" for excess in self.limits]
        return "; ".join(parts + ([] if self.proved is None else [self.proved.sentence]))

    def _stop(self) -> str:
        verdict = self.verdict
        if verdict.collides_at is not None:
            words = f"collides at {shown_seconds(verdict.collides_at)} s"
        elif verdict.near_at is not None:
            at = shown_seconds(verdict.near_at)
            words = f"too near for its tube and the tolerance of {verdict.tolerance:g} m at {at} s"
        else:
            words = "not proved after it"
        if verdict.pair is None:
            return words
        return f"{words}: {' with '.join(verdict.pair.names)}, {certificate_in_words(verdict.pair)}"

    def as_json(self, path: Path) -> dict[str, Any]:
        """As JSON has it."""
        verdict = self.verdict
        out: dict[str, Any] = {
            "path": str(path),
            "free": verdict.free,
            "controller": self.trajectory.controller,
            "pieces": len(self.trajectory.curve.pieces),
            "seconds": self.trajectory.duration,
            "tube": verdict.tube.tolist(),
            "tolerance": verdict.tolerance,
            "free_until": verdict.free_until,
            "collides_at": verdict.collides_at,
            "near_at": verdict.near_at,
            "clearance": verdict.clearance if math.isfinite(verdict.clearance) else None,
            "clearance_at": verdict.clearance_at,
            "largest_tube": verdict.largest_tube,
            "limits": [vars(excess) for excess in self.limits],
            "duration": self.duration,
        }
        if verdict.pair is not None:
            out |= certificate_as_json(verdict.pair)
        return out | ({} if self.proved is None else self.proved.as_json)


def _shown_tube(tube: Floats) -> str:
    """A tube in words; nothing for none."""
    if not tube.any():
        return ""
    return f"{tube[0]:g}" if (tube == tube[0]).all() else ",".join(f"{size:g}" for size in tube.tolist())


def judge_trajectory(
    path: Path, robot: Robot, checker_of: Callable[[Mapping[str, float]], Checker], options: argparse.Namespace
) -> JudgedTrajectory:
    """Judges the trajectory in a file; `checker_of` gives the checker of a robot that holds joints at other values."""
    held = read_robot_path(path, robot).others if path.suffix.lower() in _MESSAGES else {}
    posed = robot.holding(held) if held else robot
    trajectory = trajectory_of(path, posed, options.controller, options.start, options.message)
    began = time.perf_counter()
    with error_context(f"trajectory file {str(path)!r}"):
        checker = checker_of(held)
        verdict = checker.explain_trajectory(
            trajectory,
            0.0 if options.tube is None else options.tube,
            options.tolerance,
            start_time=0.0 if options.start_time is None else options.start_time,
        )
        limits = tuple(trajectory.limits(robot, *_limits(options, robot)))
        proved = None
        if options.certify and verdict.free:
            proved = write_proofs(verdict.proof, proof_file(path, options.proof), "piece")
    return JudgedTrajectory(trajectory, verdict, limits, time.perf_counter() - began, proved)


def _limits(options: argparse.Namespace, robot: Robot) -> tuple[Floats, ...]:
    """Largest speeds and accelerations, if they are to be kept."""
    if options.joint_limits is None:
        return ()
    found = joint_limits.read(options.joint_limits, robot)
    return found.velocity, found.acceleration
