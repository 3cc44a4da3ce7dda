"""`plannercheck verify`: confirms proofs of motions, or of pairs of links, without the checker that made them.

In: proof files, and on request the robot, the scene and the path that they should belong to. Out: what each file
proves, in lines or as JSON. Names come from the files: they are printed quoted.
"""

from __future__ import annotations

import argparse
import json
from itertools import pairwise
from pathlib import Path
from typing import Any, get_args

from plannercheck.cli.cell_paths import add_delay_argument, delays_of, is_of_cell, parts_of
from plannercheck.cli.robot_options import ROBOT_HELP, add_urdf_arguments, described, given_options
from plannercheck.cli.trajectory_files import add_start_time_argument, listed_numbers
from plannercheck.cli.unused_options import check_used
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.model_comparisons import RobotJoints, joint_reader
from plannercheck.common.shown_times import shown_seconds
from plannercheck.proofs import Proof, Verification
from plannercheck.proofs.claims import clock_of, held_joints, least_padding, motion_of, robots_of, sentence_of, timed
from plannercheck.proofs.executed_curves import RUNNERS
from plannercheck.proofs.executed_messages import cell_proved, trajectory_proved
from plannercheck.proofs.files import read_document
from plannercheck.proofs.link_pairs import PairProofs, is_of_pairs, pairs_from_document
from plannercheck.proofs.pair_checks import pair_model_confirmed, verify_pairs
from plannercheck.proofs.paths import path_proved
from plannercheck.proofs.proof import proofs_from_document
from plannercheck.proofs.verify import model_confirmed
from plannercheck.scenes.scene_paths import MeshKind

_EPILOG = """\
Exit codes: 0 all motions proved, 1 some are not, 2 bad input, such as a file that is no proof.

Examples:
  plannercheck validate --robot panda --scene bookshelf --path plan.json --certify
  plannercheck verify plan.proof.json --robot panda --scene bookshelf --path plan.json
  plannercheck verify traj.proof.json --robot panda --scene bookshelf --path traj.yaml --controller jtc --tube 0.02
  plannercheck verify plan.proof.json --robot ur10 --geometry solid --scene cell.yaml --scene-meshes solid
"""

# Options of one robot's path that a controller runs.
_OF_CONTROLLERS = ("--controller", "--tube", "--start", "--start-time", "--message")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's options."""
    parser.epilog = _EPILOG
    parser.add_argument("files", nargs="+", metavar="PROOF", type=Path, help="json or npz, as --certify writes them")
    parser.add_argument("--robot", help=f"confirm that the proof's joints and bodies are this one's: {ROBOT_HELP}")
    add_urdf_arguments(parser)
    parser.add_argument("--scene", help="with --robot: confirm the obstacles, too; default: the empty scene")
    parser.add_argument(
        "--scene-meshes", choices=get_args(MeshKind), default="hull", help="what meshes of the scene are; default: hull"
    )
    parser.add_argument(
        "--path",
        type=Path,
        nargs="+",
        metavar="FILE",
        help="confirm that every motion of this path is proved, in its order; of a cell: ROBOT=FILE …",
    )
    parser.add_argument(
        "--straight", action="store_true", help="with --path: straight motions are meant, whatever its velocities"
    )
    parser.add_argument(
        "--controller", choices=RUNNERS, help="with --path: it is a JointTrajectory, and this one runs it along curves"
    )
    parser.add_argument(
        "--tube",
        type=listed_numbers,
        metavar="RAD",
        help="with --controller: in a tube, rad and m: one number, or one a joint, with commas; default: 0",
    )
    parser.add_argument(
        "--start",
        type=listed_numbers,
        metavar="V,V,…",
        help="with --controller: where the robot stands: the way to the first point is proved as well",
    )
    parser.add_argument(
        "--message", type=int, metavar="N", help="with --controller: which trajectory of --path, from 0"
    )
    add_delay_argument(parser)
    add_start_time_argument(parser)
    parser.add_argument("--format", choices=("table", "json"), default="table", help="format of what is printed")


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    if options.scene is not None and options.robot is None:
        raise PlannercheckError("--scene needs --robot: a proof is of a robot in a scene")
    if options.robot is None and given_options(options):
        check_used(options, given_options(options), "with --robot")
    if options.scene is None:
        check_used(options, ("--scene-meshes",), "with --scene")
    if not is_of_cell(options.path):
        check_used(options, ("--delay",), "with --path ROBOT=FILE")
        _take_path(options)
    elif (
        options.controller is None
        or len(options.tube or (0.0,)) > 1
        or options.start
        or options.start_time is not None
        or options.straight
        or options.message is not None
    ):
        raise PlannercheckError("--path ROBOT=FILE takes --controller, one --tube and --delay, nothing else")
    if options.path is None:
        check_used(options, ("--straight", *_OF_CONTROLLERS), "with --path")
    elif len(options.files) > 1:
        raise PlannercheckError(f"--path is of one proof file, and {len(options.files)} are given")
    elif options.controller is None:
        check_used(options, _OF_CONTROLLERS[1:], "with --controller")
    elif options.straight:
        raise PlannercheckError("--straight and --controller say different things: give one of them")
    results = [_verified(path, options) for path in options.files]
    if options.format == "json":
        print(json.dumps(results, indent=1))
    else:
        for result in results:
            print("\n".join(_lines(result)))
    return 0 if all(result["proved"] for result in results) else 1


def _take_path(options: argparse.Namespace) -> None:
    """Leaves the one path that is given in place of a list."""
    if options.path is not None and len(options.path) > 1:
        raise PlannercheckError(f"--path is one file, or ROBOT=FILE for each robot of a cell, not {len(options.path)}")
    options.path = options.path and options.path[0]


def _robot(options: argparse.Namespace) -> Any:
    """The robot's name or file, or with options its description."""
    return described(options) if given_options(options) else options.robot


def _verified(path: Path, options: argparse.Namespace) -> dict[str, Any]:
    with error_context(f"proof file {str(path)!r}"):
        content = read_document(path)
        if is_of_pairs(content):
            return _pairs_verified(path, pairs_from_document(content), options)
        proofs = proofs_from_document(content)
    found = [proof.verify() for proof in proofs]
    model = (
        None
        if options.robot is None
        else model_confirmed(
            proofs[0],
            _robot(options),
            options.scene,
            options.scene_meshes,
            mesh_units=options.mesh_units,
            others=[proof for proof, each in zip(proofs[1:], found[1:], strict=True) if each],
        )
    )
    joints = _joints(proofs[0], options) if any(found) else None
    columns = _robot_columns(proofs[0], joints) if any(found) else None
    proved_path = _path(proofs, found, options, columns, joints)
    return {
        "proof": str(path),
        "proved": all(found) and proved_path["fault"] is None and (model is None or bool(model)),
        "kind": proofs[0].kind,
        "robot": proofs[0].robot,
        "scene": proofs[0].scene,
        "model": None if model is None else model.fault or "confirmed",
        "compared": [] if model is None else list(model.compared),
        "path": proved_path if options.path is not None else None,
        "joined": all(before.motion.asked_end == after.motion.start for before, after in pairwise(proofs)),
        "pairs": len(proofs[0].model.pairs),
        "padding": least_padding(proofs[0]) if any(found) else None,  # else the model may be malformed
        "robots": robots_of(proofs[0], columns) if any(found) else {},
        "held": held_joints(proofs[0]) if any(found) else {},
        "entries": sum(each.entries for each in found),
        "seconds": sum(each.seconds for each in found),
        "motions": [_motion(proof, each) for proof, each in zip(proofs, found, strict=True)],
    }


def _pairs_verified(path: Path, proofs: PairProofs, options: argparse.Namespace) -> dict[str, Any]:
    if options.path is not None or options.scene is not None:
        raise PlannercheckError("is about pairs of links: --path and --scene are for proofs of motions")
    found = verify_pairs(proofs)
    model = None if options.robot is None else pair_model_confirmed(proofs, _robot(options))
    return {
        "proof": str(path),
        "proved": all(found) and (model is None or bool(model)),
        "kind": "pairs",
        "robot": proofs.robot,
        "model": None if model is None else model.fault or "confirmed",
        "compared": [] if model is None else list(model.compared),
        "limits": [list(proofs.lower), list(proofs.upper)],
        "margin": proofs.margin,
        "seconds": sum(each.seconds for each in found),
        "pairs": [
            {
                "links": [pair.link_a, pair.link_b],
                "answer": pair.answer,
                "state": list(pair.state),
                "proved": each.proved,
                "fault": each.fault,
                "boxes": each.entries,
            }
            for pair, each in zip(proofs.pairs, found, strict=True)
        ],
    }


def _pair_lines(result: dict[str, Any]) -> list[str]:
    proved = sum(pair["proved"] for pair in result["pairs"])
    lines = [
        f"{_printable(result['proof'])}: {proved} of {_counted(len(result['pairs']), 'pair', 'pairs')} of links of "
        f"{result['robot']!r} proved within the limits, in {result['seconds']:.2f} s"
    ]
    for pair in result["pairs"]:
        state = f" at ({', '.join(f'{value:.9g}' for value in pair['state'])})" if pair["state"] else ""
        what = {"never": "never collide", "always": "always collide"}.get(pair["answer"], "collide") + state
        told = (
            f"{what}, {_counted(pair['boxes'], 'box', 'boxes')}" if pair["proved"] else f"not proved: {pair['fault']}"
        )
        lines.append(f"  {pair['links'][0]!r} and {pair['links'][1]!r}: {told}")
    return lines


def _joints(proof: Proof, options: argparse.Namespace) -> RobotJoints | None:
    """The joints of --robot, where something moves or a controller runs the path."""
    is_asked = clock_of([proof]) or options.controller is not None
    return joint_reader()(_robot(options)) if is_asked and options.robot is not None else None


def _robot_columns(proof: Proof, joints: RobotJoints | None) -> int | None:
    """How many columns are the robot's: all, or where something moves as many as --robot has; None without it."""
    if not clock_of([proof]):
        return proof.model.columns
    return None if joints is None else joints.columns


def _path(
    proofs: tuple[Proof, ...],
    found: list[Verification],
    options: argparse.Namespace,
    columns: int | None,
    joints: RobotJoints | None,
) -> dict[str, Any]:
    """Whether the confirmed proofs prove the path that is asked for."""
    confirmed = [proof for proof, each in zip(proofs, found, strict=True) if each]
    if options.path is None:
        return {"fault": None}
    if not confirmed:
        return {"file": _named(options), "motions": None, "missing": None, "fault": "no motion is proved"}
    tube = options.tube or (0.0,)
    if isinstance(options.path, list):
        parts, delays = parts_of(options), delays_of(options)
        known = cell_proved(confirmed, parts, delays, options.controller, tube[0], columns, joints)
    elif options.controller is not None:
        width = tube[0] if len(tube) == 1 else tube
        begin = 0.0 if options.start_time is None else options.start_time
        known = trajectory_proved(
            confirmed, options.path, options.controller, width, options.start, options.message, begin, columns, joints
        )
    else:
        robot = None if options.robot is None else _robot(options)
        known = path_proved(confirmed, options.path, options.straight, robot)
    missing = list(known.missing)
    told = {"file": _named(options), "motions": known.motions, "missing": missing, "fault": known.fault}
    clock = clock_of(confirmed)
    return told | ({"clock": [clock[0], clock[-1]]} if clock else {})


def _named(options: argparse.Namespace) -> str:
    """The path, or those of all robots with their starts."""
    if not isinstance(options.path, list):
        return str(options.path)
    delays = delays_of(options)
    return ", ".join(
        f"{name}={part} from {shown_seconds(delays.get(name, 0.0))} s" for name, part in parts_of(options).items()
    )


def _motion(proof: Proof, found: Verification) -> dict[str, Any]:
    return {
        "proved": found.proved,
        "fault": found.fault,
        **motion_of(proof),
        "entries": found.entries,
        "seconds": found.seconds,
    }


def _counted(count: int, one: str, many: str) -> str:
    return f"{count} {one if count == 1 else many}"


def _lines(result: dict[str, Any]) -> list[str]:
    if result["kind"] == "pairs":
        return [*_pair_lines(result), *_model_lines(result, "--robot")]
    count, proved = len(result["motions"]), sum(motion["proved"] for motion in result["motions"])
    what = f"{_counted(count, 'motion', 'motions')}{' in a row' if result['joined'] and count > 1 else ''}"
    of = f"of {result['robot']!r} in {result['scene']!r}"
    pairs, entries = _counted(result["pairs"], "pair", "pairs"), _counted(result["entries"], "entry", "entries")
    lines = [
        f"{_printable(result['proof'])}: {'' if proved == count else f'{proved} of '}{what} {of} proved: {pairs}, "
        f"{entries}, in {result['seconds']:.2f} s"
    ]
    for k, motion in enumerate(result["motions"]):
        lines.append(f"  motion {k}: {'proved' if motion['proved'] else 'not proved: ' + motion['fault']}")
        lines += [f"    {sentence_of(motion)}"] if motion["proved"] else []
    robots = ", ".join(
        f"{name!r} has columns {columns[0]} to {columns[-1]}" for name, columns in result["robots"].items()
    )
    lines += [f"  robots: {robots}"] if robots else []
    held = ", ".join(f"{name!r} = {' '.join(f'{x:.9g}' for x in values)}" for name, values in result["held"].items())
    lines += [f"  held: {held}"] if held else []
    lines += [f"  padding: {result['padding']:.9g} m"] if result["padding"] is not None else []
    if result["path"] is not None:
        path = result["path"]
        whole = "its only motion is proved" if path["motions"] == 1 else f"all {path['motions']} motions proved"
        lines.append(f"  path {path['file']!r}: {path['fault'] or whole + timed(path.get('clock', ()))}")
    return lines + _model_lines(result, "--robot, --scene")


def _model_lines(result: dict[str, Any], options: str) -> list[str]:
    compared = (f"    {sentence}" for sentence in result["compared"])
    return [f"  model: {result['model'] or f'not compared with files ({options})'}", *compared]


def _printable(name: str) -> str:
    return name if name.isprintable() else repr(name)
