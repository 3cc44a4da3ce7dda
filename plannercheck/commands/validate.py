"""`plannercheck validate`: sets of configurations in files.

In: a robot, a scene, npy, npz or csv files. Out: a summary, and on request one verdict a configuration. The
sets are read in chunks, so that memory stays bounded; kept are 5 bytes a configuration.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.agreement import AgreementReport, compare_with_fcl
from plannercheck.agreement import merged as merged_agreement
from plannercheck.certification import CertificationReport, certify_verdicts
from plannercheck.certification import merged as merged_certification
from plannercheck.certified_motions import DEFAULT_TOLERANCE
from plannercheck.checker import Checker
from plannercheck.commands import validated_paths
from plannercheck.commands.common import (
    add_checker_arguments,
    add_robot_argument,
    add_scene_argument,
    check_folder,
    load_checker,
    percentage,
    table,
)
from plannercheck.configuration_files import Chunk, read_chunks
from plannercheck.errors import PlannercheckError
from plannercheck.output_files import written_aside
from plannercheck.planar.certification import certify_verdicts as certify_planar
from plannercheck.planar.checker import Checker as PlanarChecker
from plannercheck.protocols import AnyChecker
from plannercheck.reading import within
from plannercheck.report import ValidityReport, merged
from plannercheck.validation import validate

_EPILOG = """\
Files: npy, npz (its only array, or q, or configurations), csv (with or without a header of joint names);
(n, nq) in the order of the robot's joints, rad and m.

Exit codes: 0 all valid and within the limits, 1 some are not, 2 bad input, or a verdict that --certify can't prove.

Examples:
  plannercheck validate --robot panda --scene bookshelf samples.npy --output verdicts.npz
  plannercheck validate --robot truck_trailer --scene parking samples.npy
  plannercheck validate --robot panda --scene bookshelf --path plan.json trajectory.yaml
  plannercheck validate --robot arm.urdf --scene cell.yaml --pairs all --format json log1.csv log2.csv
"""

# Rows of the table of pairs.
_SHOWN_PAIRS = 10

# Verdicts without a proof that an error lists.
_SHOWN_UNPROVED = 5

# Disagreements with the reference that are listed one by one.
_SHOWN_DISAGREEMENTS = 10


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's options."""
    parser.epilog = _EPILOG
    add_robot_argument(parser)
    add_scene_argument(parser)
    add_checker_arguments(parser)
    parser.add_argument("files", nargs="*", metavar="FILE", type=Path, help="npy, npz or csv file")
    parser.add_argument(
        "--path",
        nargs="+",
        type=Path,
        metavar="PATH",
        help="paths instead of sets: every motion between neighbours is proved free, or the first that is not is named "
        "with parameter, pair and certificate; plans (json), npy, npz, csv, MoveIt trajectories (yaml, json), OMPL's "
        "printed paths (any other suffix)",
    )
    parser.add_argument(
        "--tolerance",
        type=float,
        default=DEFAULT_TOLERANCE,
        metavar="M",
        help="for --path: a motion that comes nearer than this may be refused, m; default: %(default)g",
    )
    parser.add_argument(
        "--output",
        type=Path,
        metavar="FILE.npz",
        help="write arrays valid, first_pair (row of pairs, or -1), pairs (names), for all files in order",
    )
    parser.add_argument("--threads", type=int, default=1, help="default: 1")
    parser.add_argument(
        "--pairs",
        choices=("first", "all"),
        default="first",
        help="count for each configuration the first colliding pair found, or all; default: first",
    )
    parser.add_argument(
        "--reference",
        choices=("fcl",),
        help="compare every pair's verdict with FCL's as well, exact arithmetic being the judge (slow)",
    )
    parser.add_argument(
        "--certify",
        action="store_true",
        help="prove every verdict in exact arithmetic, apart from the compiled core: a shared point for each invalid "
        "configuration, separation of all pairs for each valid one (slow: some 10 ms a configuration)",
    )
    parser.add_argument("--format", choices=("table", "json"), default="table", help="default: table")


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    if bool(options.files) == bool(options.path):
        raise PlannercheckError("needs either files with configurations or --path with paths")
    if options.path:
        if options.output or options.reference or options.certify or options.pairs != "first":
            raise PlannercheckError("--output, --pairs, --reference and --certify are for sets, not for --path")
        return validated_paths.run(options)
    check_folder(options.output)
    if options.output is not None and options.output.suffix != ".npz":
        raise PlannercheckError(f"--output must be an npz file, not {str(options.output)!r}")
    checker = load_checker(options)
    first_pairs, reports, agreements, certifications = [], [], [], []
    for path, chunk in _chunks(options.files, checker):
        with within(f"file {str(path)!r}, rows from {chunk.first_row} on"):
            found = validate(checker, chunk.rows, options.threads, options.pairs == "all")
        first_pairs.append(found.first_pair)
        reports.append(found.report)
        if options.reference:
            agreements.append(_agreement(checker, chunk))
        if options.certify:
            certifications.append(_certification(checker, chunk, found.first_pair))
    report = merged(reports)
    agreement = merged_agreement(agreements) if options.reference else None
    if options.output is not None:
        _save(options.output, checker, np.concatenate([np.empty(0, dtype=np.int32), *first_pairs]))
    show = _show_json if options.format == "json" else _show_table
    certification = merged_certification(certifications) if options.certify else None
    show(checker, report, agreement, certification)
    _check_proofs(certification)
    return 0 if report.passed and (agreement is None or agreement.passed) else 1


def _chunks(paths: list[Path], checker: AnyChecker) -> Iterator[tuple[Path, Chunk]]:
    for path in paths:
        for chunk in read_chunks(path, checker.robot.joint_names, checker.robot.nq):
            yield path, chunk


def _agreement(checker: AnyChecker, chunk: Chunk) -> AgreementReport:
    """The comparison of a chunk, with rows as in its file."""
    if not isinstance(checker, Checker):
        raise PlannercheckError("--reference fcl is for robots in space: FCL knows no polygons")
    report = compare_with_fcl(checker, chunk.rows)
    return replace(
        report,
        disagreements=tuple(replace(d, row=d.row + chunk.first_row) for d in report.disagreements),
        contradictions=tuple(row + chunk.first_row for row in report.contradictions),
    )


def _certification(checker: AnyChecker, chunk: Chunk, first_pair: NDArray[np.int32]) -> CertificationReport:
    """The proofs of a chunk's verdicts, with rows as in its file."""
    if isinstance(checker, PlanarChecker):
        report = certify_planar(checker, chunk.rows, first_pair)
    else:
        assert isinstance(checker, Checker)
        report = certify_verdicts(checker, chunk.rows, first_pair)
    return replace(report, unproved=tuple(replace(u, row=u.row + chunk.first_row) for u in report.unproved))


def _check_proofs(certification: CertificationReport | None) -> None:
    if certification is None or certification.passed:
        return
    shown = [f"row {u.row}: {u.first} and {u.second}" for u in certification.unproved[:_SHOWN_UNPROVED]]
    raise PlannercheckError(
        f"{len(certification.unproved)} verdicts are not proved, which is a fault of plannercheck and worth a report: "
        + "; ".join(shown)
    )


def _save(path: Path, checker: AnyChecker, first_pair: NDArray[np.int32]) -> None:
    names = [checker.pair_names(pair) for pair in range(len(checker.pairs))]
    arrays: dict[str, Any] = {
        "valid": first_pair < 0,
        "first_pair": first_pair,
        "pairs": np.array(names, dtype=np.str_).reshape(-1, 2),
    }
    written_aside(path, lambda aside: np.savez(aside, **arrays))


def _show_json(
    checker: AnyChecker,
    report: ValidityReport,
    agreement: AgreementReport | None,
    certification: CertificationReport | None,
) -> None:
    values: dict[str, Any] = {
        "robot": checker.robot.name,
        "scene": checker.scene.name,
        **asdict(report),
        "invalid": report.invalid,
    }
    if agreement is not None:
        values["fcl"] = {**_agreement_counts(agreement), "passed": agreement.passed}
    if certification is not None:
        values["certificates"] = {**_proof_counts(certification), "passed": certification.passed}
    print(json.dumps(values, indent=1))


def _show_table(
    checker: AnyChecker,
    report: ValidityReport,
    agreement: AgreementReport | None,
    certification: CertificationReport | None,
) -> None:
    print(f"{checker.robot.name} in {checker.scene.name}, {len(checker.pairs)} pairs of bodies")
    counts = (
        ("configurations", report.states),
        ("valid", report.valid),
        ("invalid", report.invalid),
        ("beyond limits", report.beyond_limits),
    )
    print(table(("", "count", "part"), [(name, n, percentage(n, report.states)) for name, n in counts]))
    if report.duration > 0:
        print(f"{report.duration:.3f} s, {report.rate:,.0f} configurations a second")
    _show_pairs(report)
    if agreement is not None:
        _show_agreement(agreement)
    if certification is not None:
        print("\nProved in exact arithmetic, apart from the compiled core:")
        print(table(("", "count"), list(_proof_counts(certification).items())))


def _show_pairs(report: ValidityReport) -> None:
    if not report.pairs:
        return
    counted = "all colliding pairs" if report.all_pairs else "the first colliding pair found"
    print(f"\nMost frequent collisions (each configuration counts for {counted}):")
    rows = [(p.first, p.second, p.states, percentage(p.states, report.states)) for p in report.pairs]
    print(table(("link", "link or obstacle", "count", "part"), rows[:_SHOWN_PAIRS]))
    if len(rows) > _SHOWN_PAIRS:
        print(f"and {len(rows) - _SHOWN_PAIRS} more pairs")


def _agreement_counts(agreement: AgreementReport) -> dict[str, int]:
    return {
        "configurations": agreement.states,
        "pairs": agreement.pairs,
        "decided by FCL": agreement.fcl_calls,
        "decided by exact arithmetic instead": agreement.exact_calls,
        "collisions": agreement.collisions,
        "disagreements": len(agreement.disagreements),
        "errors of FCL": len(agreement.errors_of_fcl),
        "against us": len(agreement.against_us),
    }


def _proof_counts(certification: CertificationReport) -> dict[str, int]:
    return {
        "configurations": certification.states,
        "shared points": certification.shared_points,
        "separating planes": certification.planes,
        "separate boxes": certification.boxes,
        "not proved": len(certification.unproved),
    }


def _show_agreement(agreement: AgreementReport) -> None:
    print("\nCompared with FCL, exact arithmetic being the judge:")
    print(table(("", "count"), list(_agreement_counts(agreement).items())))
    for found in agreement.disagreements[:_SHOWN_DISAGREEMENTS]:
        verdict = "collide" if found.exact else f"are {found.distance:.3g} m apart"
        side = "against us" if found.against_us else "FCL errs"
        print(f"row {found.row}: {found.bodies[0]} and {found.bodies[1]} {verdict}: {side}")
    if agreement.contradictions:
        print(f"rows whose verdicts contradict each other: {list(agreement.contradictions)}")
