"""The options of `plannercheck validate`, and which of them go together."""

from __future__ import annotations

import argparse
from pathlib import Path

from plannercheck.cli.cell_paths import is_of_cell
from plannercheck.cli.common import add_checker_arguments
from plannercheck.cli.unused_options import check_used
from plannercheck.cli.validate_trajectories import OPTIONS as OF_TRAJECTORIES
from plannercheck.cli.validate_trajectories import add_trajectory_arguments
from plannercheck.common.atomic_files import is_stream
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.motion_paths import PATHS
from plannercheck.common.threads import checked_threads
from plannercheck.motions.certifier import DEFAULT_TOLERANCE
from plannercheck.validation.formats.chunks import STANDARD_INPUT

_EPILOG = """\
Files: npy, npz (its only array, or q, or configurations), csv, parquet (a column a joint, or one of lists; or a
folder of such files), hdf5 (a dataset, or one a joint); - is standard input, npy or csv. (n, nq) in the order of the
robot's joints, rad and m; where a file names its columns (csv's first line, parquet, fields, or joint_names beside the
array), the joints are found by name, in any order.

Output: npz has valid, first_pair (row of pairs, or -1), beyond_limits, pairs, files, file_rows; csv and parquet have
file, row, valid, beyond_limits, first, second. While a run goes on, what it found is in OUTPUT.progress.

Exit codes: 0 all valid and within the limits, 1 some are not (--limits), 2 bad input, or a verdict that --certify can't
prove, 130 interrupted.

Examples:
  plannercheck validate --robot panda --scene bookshelf samples.npy --output verdicts.npz
  plannercheck validate --robot panda --scene bookshelf huge.parquet --output verdicts.parquet --resume
  plannercheck validate --robot panda --scene bookshelf log.csv --degrees --only-invalid --explain --output bad.csv
  plannercheck validate --robot panda --scene bookshelf huge.npy --engine dask --workers 8 --output verdicts.npz
  producer | plannercheck validate --robot panda --scene bookshelf -
  plannercheck validate --robot truck_trailer --scene parking samples.npy
  plannercheck validate --robot panda --scene bookshelf --path plan.json trajectory.yaml
  plannercheck validate --robot panda --scene bookshelf --path trajectory.yaml --controller jtc --tube 0.02 --certify
"""


# Options that say nothing of paths.
_OF_SETS = (
    "--output",
    "--summary",
    "--only-invalid",
    "--explain",
    "--pairs",
    "--limits",
    "--reference",
    "--degrees",
    "--columns",
    "--ignore-columns",
    "--time",
    "--times",
    "--key",
    "--engine",
    "--scheduler",
    "--workers",
    "--resume",
    "--progress",
)


def add_set_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds all options."""
    parser.epilog = _EPILOG
    add_checker_arguments(parser)
    parser.add_argument("files", nargs="*", metavar="FILE", type=Path, help="npy, npz, csv, parquet or hdf5 file, or -")
    _add_input_arguments(parser)
    _add_question_arguments(parser)
    _add_output_arguments(parser)
    _add_run_arguments(parser)
    _add_path_arguments(parser)
    add_trajectory_arguments(parser)


def _add_input_arguments(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("what is in the files")
    group.add_argument("--degrees", action="store_true", help="angles are in degrees; lengths stay in m")
    group.add_argument(
        "--columns",
        type=_names,
        metavar="NAME,NAME,…",
        help="names of the joints' columns in the files, in the robot's order, if they differ from the joints' names",
    )
    group.add_argument(
        "--ignore-columns",
        type=_names,
        default=(),
        metavar="NAME,…",
        help="columns of joints that the robot holds, whose values shall not count",
    )
    group.add_argument("--time", type=float, metavar="S", help="the scene's clock, where something in it moves")
    group.add_argument("--times", type=Path, metavar="FILE", help="npy with that of each row (n,), s, of one FILE")
    group.add_argument("--key", metavar="NAME", help="array of an npz, dataset of an hdf5, lists' column of a parquet")


def _add_question_arguments(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("what is asked")
    group.add_argument(
        "--limits",
        choices=("error", "warn", "ignore"),
        default="error",
        help="configurations beyond the joint limits make the exit code 1, or a warning, or are ignored; they "
        "are judged all the same; default: error",
    )
    group.add_argument(
        "--pairs",
        choices=("first", "all"),
        default="first",
        help="count for each configuration the first colliding pair found, or all; default: first",
    )
    group.add_argument(
        "--reference",
        choices=("fcl",),
        help="compare every pair's verdict with FCL's as well, exact arithmetic being the judge (slow)",
    )
    group.add_argument(
        "--certify",
        action="store_true",
        help="prove every verdict in exact arithmetic, apart from the compiled core: a shared point for each invalid "
        "configuration, separation of all pairs for each valid one (slow: some 10 ms a configuration); with --path "
        "write a proof of all motions, which `plannercheck verify` confirms by itself (some 0.5 s a motion)",
    )


def _add_output_arguments(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("what is written")
    group.add_argument("--output", type=Path, metavar="FILE", help="verdicts of all files in order: npz, csv, parquet")
    group.add_argument(
        "--only-invalid", action="store_true", help="write only configurations that fail, with their file and row"
    )
    group.add_argument(
        "--explain",
        action="store_true",
        help="write a certificate of each, too: a point that the first colliding pair shares, or a plane between the "
        "two bodies that are nearest to each other (slow: some 1 ms a configuration)",
    )
    group.add_argument("--summary", type=Path, metavar="FILE.json", help="write the summary, too")
    group.add_argument("--format", choices=("table", "json"), default="table", help="format of what is printed")


def _add_run_arguments(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("how it is done")
    group.add_argument("--threads", type=int, default=1, help="threads of this process, or of each worker; default: 1")
    group.add_argument(
        "--resume",
        action="store_true",
        help="go on with an interrupted run of the same command, whose journal is beside the output",
    )
    group.add_argument(
        "--progress",
        choices=("auto", "bar", "lines", "none"),
        default="auto",
        help="a bar, a line every 10 s, or nothing; default: a bar on a terminal, else lines",
    )
    group.add_argument(
        "--engine",
        choices=("local", "dask"),
        default="local",
        help="judge in this process, or on a dask.distributed cluster",
    )
    group.add_argument("--scheduler", metavar="ADDRESS", help="address of the cluster, e.g. tcp://10.0.0.1:8786")
    group.add_argument(
        "--workers", type=int, help="number of processes of a cluster on this machine; default: one for each core"
    )


def _add_path_arguments(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("paths")
    group.add_argument(
        "--path",
        nargs="+",
        type=Path,
        metavar="PATH",
        help="paths instead of sets: every motion between neighbours is proved free, or the first that is not is named "
        "with parameter, pair and certificate; plans (json), npy, npz, csv, MoveIt trajectories (yaml, json), OMPL's "
        "printed paths (any other suffix)",
    )
    group.add_argument(
        "--straight",
        action="store_true",
        help="for --path: prove the straight motions between a trajectory's points although it gives velocities or "
        "accelerations, with which a controller runs splines; without this, the splines are proved",
    )
    group.add_argument(
        "--motion-path",
        choices=PATHS,
        help="for --path: how planar and floating joints move: along one screw, or straight and turning by slerp, as "
        "plans of free bodies do; default: as the file says, or screw",
    )
    group.add_argument(
        "--tolerance",
        type=float,
        default=DEFAULT_TOLERANCE,
        metavar="M",
        help="for --path: a motion that comes nearer than this may be refused, m; default: %(default)g",
    )
    group.add_argument(
        "--proof",
        type=Path,
        metavar="FILE",
        help="with --path and --certify: where the proof is written, json or npz; default: beside the path, "
        "plan.proof.json of plan.json",
    )


# Options of one robot's paths.
_OF_ONE_ROBOT = ("--straight", "--motion-path", "--start", "--start-time", "--message", "--joint-limits")


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",") if name.strip())


def check_options(options: argparse.Namespace) -> None:
    """Raises if options contradict each other."""
    if options.files and options.path:
        named = ", ".join(map(str, options.files))
        raise PlannercheckError(
            f"takes files with configurations ({named}) or --path with paths, not both; --proof FILE says where "
            "--certify writes the proof of a path"
        )
    if not options.files and not options.path:
        raise PlannercheckError("needs either files with configurations or --path with paths")
    if options.path:
        _check_path_options(options)
    else:
        check_used(
            options,
            ("--straight", "--motion-path", "--tolerance", "--delay", *OF_TRAJECTORIES),
            "with --path, not for sets",
        )
    with error_context("--threads"):
        checked_threads(options.threads, options.threads)
    if options.proof is not None:
        _check_proof_option(options)
    written = options.output or options.summary
    if (options.only_invalid or options.explain) and options.output is None:
        raise PlannercheckError("--only-invalid and --explain say what is written: they need --output")
    if options.resume and written is None:
        raise PlannercheckError("--resume needs --output or --summary: the journal of a run is beside it")
    if options.resume and is_stream(written):
        raise PlannercheckError(f"--resume can't go on with {str(written)!r}, which is no file: it has no journal")
    if options.resume and STANDARD_INPUT in options.files:
        raise PlannercheckError("--resume can't go on with standard input, which is gone: write it to a file")
    if options.resume and (options.reference or options.certify):
        raise PlannercheckError("--reference and --certify are not kept in the journal: leave --resume out")
    if options.engine == "local" and (options.scheduler or options.workers is not None):
        raise PlannercheckError("--scheduler and --workers are for --engine dask")
    if options.scheduler and options.workers is not None:
        raise PlannercheckError(
            "--workers starts a cluster on this machine, --scheduler uses another: give one of them"
        )
    if options.workers is not None and options.workers < 1:
        raise PlannercheckError(f"--workers must be at least 1, not {options.workers}")


def _check_proof_option(options: argparse.Namespace) -> None:
    if not (options.path and options.certify):
        raise PlannercheckError(
            "--proof says where --certify writes the proof of a path: it needs --path and --certify"
        )
    if len(options.path) > 1 and not is_of_cell(options.path):
        raise PlannercheckError(f"--proof is one file, and there are {len(options.path)} paths: leave it out")


def _check_path_options(options: argparse.Namespace) -> None:
    check_used(options, _OF_SETS, "for sets, not with --path")
    if is_of_cell(options.path):
        check_used(options, _OF_ONE_ROBOT, "for one robot, not with --path ROBOT=FILE")
    else:
        check_used(options, ("--delay",), "with --path ROBOT=FILE")
    if options.straight or options.motion_path:
        given = "--straight" if options.straight else "--motion-path"
        check_used(options, OF_TRAJECTORIES, f"without {given}, which is about straight motions")
