"""`plannercheck validate --path`: paths of any planner, proved free or stopped by a certificate.

In: options, path files. Out: a line or a JSON object for each path; with --certify, a file of proofs beside each.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any, TypeAlias

from plannercheck import planar
from plannercheck.bodies.certificates import Separation, SharedPoint
from plannercheck.bodies.part_certificates import PartSeparation
from plannercheck.bodies.solid_certificates import Enclosure
from plannercheck.bodies.solid_separations import SolidSeparation
from plannercheck.checking.protocols import AnyChecker, AnyRobot
from plannercheck.checking.verdicts import PairVerdict
from plannercheck.cli.common import padding_of, planar_checker, scene_of
from plannercheck.cli.proved_paths import PathProof, check_proof_file, proof_file, write_proof
from plannercheck.cli.robot_options import robot_of
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.motion_paths import MotionPath
from plannercheck.motions.checker import Checker
from plannercheck.planar.robot_files import is_planar
from plannercheck.validation.formats.paths import PathFile, read_robot_path
from plannercheck.validation.paths import PathVerdict, validate_path

# A path's verdict, and what came of proving it.
Judged: TypeAlias = tuple[PathVerdict, PathProof | None]


def run(options: argparse.Namespace) -> int:
    """Judges the paths of --path.

    Returns:
        0 if all are free and within the limits, else 1.
    """
    if options.certify:
        for path in options.path:
            check_proof_file(proof_file(path, options.proof), options.path)
    judged = _planar(options) if is_planar(options.robot, "robots") else _in_space(options)
    if options.format == "json":
        print(json.dumps([_as_json(path, *each) for path, each in zip(options.path, judged, strict=True)], indent=1))
    else:
        for path, (verdict, proved) in zip(options.path, judged, strict=True):
            print(f"{path}: {_sentence(verdict)}{'' if proved is None else f'; {proved.sentence}'}")
    return 0 if all(verdict.passed and (proved is None or proved.written) for verdict, proved in judged) else 1


def _planar(options: argparse.Namespace) -> list[Judged]:
    checker, verdicts = planar_checker(options), []
    for path in options.path:
        file = _read(path, checker.robot, options)
        with error_context(f"path file {str(path)!r}"):
            if file.others:
                raise PlannercheckError(f"{checker.robot.name!r} has no joint {', '.join(file.others)}")
            verdicts.append(_judged(checker, path, file, options))
    return verdicts


def _judged(checker: AnyChecker, path: Path, file: PathFile, options: argparse.Namespace) -> Judged:
    kind: MotionPath = options.motion_path or file.motion_path or "screw"
    states = file.states
    verdict = validate_path(checker, states, options.tolerance, options.threads, kind, file.pieces)
    if not options.certify or not verdict.free:
        return verdict, None
    return verdict, write_proof(checker, states, options.tolerance, proof_file(path, options.proof), kind)


def _in_space(options: argparse.Namespace) -> list[Judged]:
    robot, scene = robot_of(options), scene_of(options)
    checkers: dict[tuple[tuple[str, float], ...], Checker] = {}
    verdicts = []
    for path in options.path:
        file = _read(path, robot, options)
        held = tuple(sorted(file.others.items()))
        with error_context(f"path file {str(path)!r}"):
            if held not in checkers:
                posed = robot.holding(file.others) if held else robot
                checkers[held] = Checker(
                    posed, scene, self_collision=not options.no_self_collision, padding=padding_of(options, scene)
                )
            verdicts.append(_judged(checkers[held], path, file, options))
    return verdicts


def _read(path: Path, robot: AnyRobot, options: argparse.Namespace) -> PathFile:
    """A path, whose motions are straight, or to be taken so."""
    file = read_robot_path(path, robot)
    if file.bent_by and not options.straight:
        raise PlannercheckError(
            f"path file {str(path)!r}: its {' and '.join(file.bent_by)} are not zero, so a controller runs splines "
            "between its points, but straight motions are what is proved: --straight says that these are meant"
        )
    return file


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
        return f"{start}collides at {stopped.collides_at:.9g}: {pair}, {_certificate(stopped.pair)}{limits}"
    near = f"is within the tolerance of {stopped.tolerance:g} m at {stopped.near_at:.9g}"
    return f"{start}{near}: {pair}, {_certificate(stopped.pair)}{limits}"


def _certificate(pair: PairVerdict) -> str:
    certificate = pair.certificate
    if isinstance(certificate, Separation | planar.Separation):
        return f"apart by at least {certificate.gap:.3g} m along ({_listed(certificate.normal.tolist())})"
    if isinstance(certificate, SolidSeparation | PartSeparation):
        return f"apart by at least {certificate.gap:.3g} m"
    assert isinstance(certificate, SharedPoint | planar.SharedPoint | Enclosure)
    return f"which share the point ({_listed(certificate.point.tolist())})"


def _listed(values: list[float]) -> str:
    return ", ".join(f"{value:.6g}" for value in values)


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
        out |= {"proof": str(proved.file) if proved.written else None, "proof_fault": proved.fault}
        out |= {"proof_entries": proved.entries}
    if verdict.stopped is None or verdict.stopped.pair is None:
        return out
    pair, stopped = verdict.stopped.pair, verdict.stopped
    certificate = pair.certificate
    if isinstance(certificate, Separation | planar.Separation):
        proof: dict[str, Any] = {
            "normal": certificate.normal.tolist(),
            "offset": certificate.offset,
            "gap": certificate.gap,
        }
    elif isinstance(certificate, SolidSeparation | PartSeparation):
        proof = {"gap": certificate.gap}
    else:
        assert isinstance(certificate, SharedPoint | planar.SharedPoint | Enclosure)
        proof = {"shared_point": certificate.point.tolist()}
    return {
        **out,
        "motion": verdict.motion,
        "free_until": stopped.free_until,
        "collides_at": stopped.collides_at,
        "near_at": stopped.near_at,
        "pair": [pair.first, pair.second],
        "bodies": [pair.first_body, pair.second_body],
        "certificate": proof,
    }
