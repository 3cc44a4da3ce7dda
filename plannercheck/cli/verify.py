"""`plannercheck verify`: confirms proofs of motions in ball arithmetic, without the checker that made them.

In: proof files, and on request the robot and the scene that they should be of. Out: a line for each file and for each
motion that is not proved, or JSON.
"""

from __future__ import annotations

import argparse
import json
from itertools import pairwise
from pathlib import Path
from typing import Any, get_args

from plannercheck.cli.robot_options import ROBOT_HELP, add_urdf_arguments, described, given_options
from plannercheck.cli.unheeded_options import check_heeded
from plannercheck.common.errors import PlannercheckError
from plannercheck.proofs import Proof, Verification, load_proofs
from plannercheck.proofs.verify import model_confirmed
from plannercheck.scenes.scene_paths import MeshKind

_EPILOG = """\
Exit codes: 0 all motions proved, 1 some are not, 2 bad input, such as a file that is no proof.

Examples:
  plannercheck validate --robot panda --scene bookshelf --path plan.json --certify
  plannercheck verify plan.proof.json --robot panda --scene bookshelf
  plannercheck verify plan.proof.json --robot ur10 --geometry solid --scene cell.yaml --scene-meshes solid
"""


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
    parser.add_argument("--format", choices=("table", "json"), default="table", help="format of what is printed")


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    if options.scene is not None and options.robot is None:
        raise PlannercheckError("--scene needs --robot: a proof is of a robot in a scene")
    if options.robot is None and given_options(options):
        check_heeded(options, given_options(options), "with --robot")
    if options.scene is None:
        check_heeded(options, ("--scene-meshes",), "with --scene")
    results = [_verified(path, options) for path in options.files]
    if options.format == "json":
        print(json.dumps(results, indent=1))
    else:
        for result in results:
            print("\n".join(_lines(result)))
    return 0 if all(result["proved"] for result in results) else 1


def _robot(options: argparse.Namespace) -> Any:
    """The robot's name or file, or with options its description."""
    return described(options) if given_options(options) else options.robot


def _verified(path: Path, options: argparse.Namespace) -> dict[str, Any]:
    proofs = load_proofs(path)
    found = [proof.verify() for proof in proofs]
    model = (
        None
        if options.robot is None
        else model_confirmed(
            proofs[0], _robot(options), options.scene, options.scene_meshes, mesh_units=options.mesh_units
        )
    )
    return {
        "proof": str(path),
        "proved": all(found) and (model is None or bool(model)),
        "kind": proofs[0].kind,
        "robot": proofs[0].robot,
        "scene": proofs[0].scene,
        "model": None if model is None else model.fault or "confirmed",
        "joined": _joined(proofs),
        "pairs": len(proofs[0].model.pairs),
        "padding": _least_padding(proofs[0]) if any(found) else None,  # else the model may be malformed
        "held": _held(proofs[0]) if any(found) else {},
        "entries": sum(each.entries for each in found),
        "seconds": sum(each.seconds for each in found),
        "motions": [_motion(proof, each) for proof, each in zip(proofs, found, strict=True)],
    }


def _least_padding(proof: Proof) -> float | None:
    """What every pair keeps besides not touching, m; None in the plane."""
    model: Any = proof.model
    if proof.kind != "space":
        return None
    return min((model.bodies[a].padding + model.bodies[b].padding for a, b in model.pairs), default=0.0)


def _held(proof: Proof) -> dict[str, list[float]]:
    """The joints that stand still, which no file says: by name, where."""
    model: Any = proof.model
    joints = model.joints if proof.kind == "space" else ()
    return {joint.name: list(joint.offsets) for joint in joints if max(joint.columns) < 0}


def _motion(proof: Proof, found: Verification) -> dict[str, Any]:
    return {
        "proved": found.proved,
        "fault": found.fault,
        "start": list(proof.motion.start),
        "end": list(_end(proof)),
        "margin": proof.margin,
        "entries": found.entries,
        "seconds": found.seconds,
    }


def _joined(proofs: tuple[Proof, ...]) -> bool:
    """Whether each motion starts where the one before was to end."""
    return all(_end(before) == after.motion.start for before, after in pairwise(proofs))


def _end(proof: Proof) -> tuple[float, ...]:
    """The end that was asked for."""
    motion: Any = proof.motion
    return tuple(getattr(motion, "asked_end", motion.end))


def _counted(count: int, one: str, many: str) -> str:
    return f"{count} {one if count == 1 else many}"


def _lines(result: dict[str, Any]) -> list[str]:
    count, proved = len(result["motions"]), sum(motion["proved"] for motion in result["motions"])
    what = f"{_counted(count, 'motion', 'motions')}{' in a row' if result['joined'] and count > 1 else ''}"
    of = f"of {result['robot']} in {result['scene']}"
    pairs, entries = _counted(result["pairs"], "pair", "pairs"), _counted(result["entries"], "entry", "entries")
    lines = [
        f"{result['proof']}: {'' if proved == count else f'{proved} of '}{what} {of} proved: {pairs}, {entries}, in "
        f"{result['seconds']:.2f} s"
    ]
    lines += [
        f"  motion {k}: not proved: {motion['fault']}" for k, motion in enumerate(result["motions"]) if motion["fault"]
    ]
    model = result["model"] or "not compared with files (--robot, --scene)"
    held = ", ".join(f"{name} = {' '.join(f'{x:.6g}' for x in values)}" for name, values in result["held"].items())
    lines += [f"  held: {held}"] if held else []
    lines += [f"  padding: {result['padding']:.6g} m"] if result["padding"] else []
    return [*lines, f"  model: {model}"]
