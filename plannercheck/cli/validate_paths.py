"""`plannercheck validate --path`: paths of any planner, proved free or stopped by a certificate.

In: options, path files. Out: a line or a JSON object for each path; with --certify, a file of proofs beside each.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from plannercheck.checking.protocols import AnyChecker
from plannercheck.cli.cell_paths import is_of_cell, judge_cell
from plannercheck.cli.common import check_at_rest, padding_of, planar_checker, scene_of, space_checker
from plannercheck.cli.proved_paths import PathProof, check_proof_file, proof_file, write_proof
from plannercheck.cli.robot_options import robot_of
from plannercheck.cli.told_certificates import certificate_as_json, certificate_in_words
from plannercheck.cli.validate_trajectories import JudgedTrajectory, is_asked, judge_trajectory
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.motion_paths import MotionPath
from plannercheck.motions.checker import Checker
from plannercheck.planar.robot_files import is_planar
from plannercheck.robots.robot import Robot
from plannercheck.validation.formats.paths import PathFile, read_robot_path
from plannercheck.validation.paths import PathVerdict, validate_path


@dataclass(frozen=True)
class JudgedPath:
    """A path's verdict, and what came of proving it."""

    verdict: PathVerdict
    proved: PathProof | None

    @property
    def passed(self) -> bool:
        """Whether it is free, within the limits, and proved if that was asked for."""
        return self.verdict.passed and (self.proved is None or self.proved.written)

    @property
    def sentence(self) -> str:
        """For the terminal."""
        return "; ".join([_sentence(self.verdict), *([] if self.proved is None else [self.proved.sentence])])

    def as_json(self, path: Path) -> dict[str, Any]:
        """As JSON has it."""
        return _as_json(path, self.verdict, self.proved)


Judged: TypeAlias = JudgedPath | JudgedTrajectory


def run(options: argparse.Namespace) -> int:
    """Judges the paths of --path: 0 if all are free and within the limits, else 1."""
    if is_of_cell(options.path):
        is_plane = is_planar(options.robot, "robots")
        return judge_cell(options, planar_checker(options) if is_plane else space_checker(options))
    if options.certify:
        for path in options.path:
            check_proof_file(proof_file(path, options.proof), options.path)
    judged = _planar(options) if is_planar(options.robot, "robots") else _in_space(options)
    found = list(zip(options.path, judged, strict=True))
    if options.format == "json":
        print(json.dumps([each.as_json(path) for path, each in found], indent=1))
    else:
        for path, each in found:
            print(f"{path}: {each.sentence}")
    return 0 if all(each.passed for each in judged) else 1


def _planar(options: argparse.Namespace) -> list[Judged]:
    checker = planar_checker(options)
    verdicts: list[Judged] = []
    for path in options.path:
        file = read_robot_path(path, checker.robot)
        with error_context(f"path file {str(path)!r}"):
            if is_asked(options) or (file.bent_by and not options.straight):
                raise PlannercheckError(f"{checker.robot.name!r} is planar, and trajectories are of robots in space")
            if file.others:
                raise PlannercheckError(f"{checker.robot.name!r} has no joint {', '.join(file.others)}")
            verdicts.append(_judged(checker, path, file, options))
    return verdicts


def _judged(checker: AnyChecker, path: Path, file: PathFile, options: argparse.Namespace) -> JudgedPath:
    kind: MotionPath = options.motion_path or file.motion_path or "screw"
    states = file.states
    verdict = validate_path(checker, states, options.tolerance, options.threads, kind, file.pieces)
    if not options.certify or not verdict.free:
        return JudgedPath(verdict, None)
    return JudgedPath(verdict, write_proof(checker, states, options.tolerance, proof_file(path, options.proof), kind))


def _in_space(options: argparse.Namespace) -> list[Judged]:
    robot, scene = robot_of(options), scene_of(options)
    checkers: dict[tuple[tuple[str, float], ...], Checker] = {}

    def checker_of(others: Mapping[str, float]) -> Checker:
        held = tuple(sorted(others.items()))
        if held not in checkers:
            posed = robot.holding(others) if held else robot
            checkers[held] = Checker(
                posed, scene, self_collision=not options.no_self_collision, padding=padding_of(options, scene)
            )
        return checkers[held]

    return [_judged_in_space(path, robot, checker_of, options) for path in options.path]


def _judged_in_space(
    path: Path, robot: Robot, checker_of: Callable[[Mapping[str, float]], Checker], options: argparse.Namespace
) -> Judged:
    if is_asked(options):
        return judge_trajectory(path, robot, checker_of, options)
    file = read_robot_path(path, robot)
    if file.bent_by and not options.straight:
        return judge_trajectory(path, robot, checker_of, options)
    with error_context(f"path file {str(path)!r}"):
        checker = checker_of(file.others)
        check_at_rest(checker.scene, "a path's motions are")
        return _judged(checker, path, file, options)


def _sentence(verdict: PathVerdict) -> str:
    limits = f"; {verdict.beyond_limits} configurations beyond the limits" if verdict.beyond_limits else ""
    if verdict.stopped is None:
        motions = "the only motion" if verdict.motions == 1 else f"all {verdict.motions} motions"
        cut = f" in {verdict.motions + verdict.cut} pieces of less than half a turn" if verdict.cut else ""
        return f"free, proved for {motions}{cut}{limits}"
    stopped, count = verdict.stopped, f"{verdict.motions - verdict.free_motions} of {verdict.motions} motions"
    start = f"not free ({count}): motion {verdict.motion} is proved free up to {stopped.free_until:.9g}, "
    assert stopped.pair is not None
    pair = " with ".join(stopped.pair.names)
    if stopped.collides_at is not None:
        return f"{start}collides at {stopped.collides_at:.9g}: {pair}, {certificate_in_words(stopped.pair)}{limits}"
    near = f"is within the tolerance of {stopped.tolerance:g} m at {stopped.near_at:.9g}"
    return f"{start}{near}: {pair}, {certificate_in_words(stopped.pair)}{limits}"


def _as_json(path: Path, verdict: PathVerdict, proved: PathProof | None) -> dict[str, Any]:
    out: dict[str, Any] = {
        "path": str(path),
        "free": verdict.free,
        "states": verdict.states,
        "motions": verdict.motions,
        "free_motions": verdict.free_motions,
        "beyond_limits": verdict.beyond_limits,
        "tolerance": verdict.tolerance,
        "duration": verdict.duration,
    }
    if proved is not None:
        out |= proved.as_json
    if verdict.stopped is None or verdict.stopped.pair is None:
        return out
    stopped = verdict.stopped
    return {
        **out,
        "motion": verdict.motion,
        "free_until": stopped.free_until,
        "collides_at": stopped.collides_at,
        "near_at": stopped.near_at,
        **certificate_as_json(verdict.stopped.pair),
    }
