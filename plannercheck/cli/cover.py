"""`plannercheck cover`: audits sphere models of a robot, grows them until they cover it, and fits new ones."""

from __future__ import annotations

import argparse
from pathlib import Path

from plannercheck.cli.common import add_robot_argument, check_folder, save_json, table
from plannercheck.cli.robot_options import robot_of
from plannercheck.cli.unused_options import check_used
from plannercheck.common.errors import PlannercheckError
from plannercheck.coverings.audits import HEADER, Audit
from plannercheck.coverings.covering import Covering
from plannercheck.planar.robot_files import is_planar

_EPILOG = """\
audit proves for each link that a model covers it, or shows the point that is furthest outside. Models are cuRobo's .yml
or .xrdf, a .urdf whose collision elements are spheres (VAMP, foam), or .json. --output writes the model, every radius
grown by the least length at which it covers all links.

fit covers the robot by so many spheres, or by as few as stick out by at most --excess. --output writes them.

Meshes are taken as they are unless --geometry says otherwise. Exit codes: 0 all links are covered, 1 some are not, 2
bad input.

Examples:
  plannercheck cover audit --robot panda --model franka.yml
  plannercheck cover audit --robot panda --model franka.yml --output grown.yml
  plannercheck cover fit --robot panda --spheres 64 --output panda_spheres.urdf
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's options."""
    parser.epilog = _EPILOG
    parser.add_argument("action", choices=("audit", "fit"), help="what to do")
    add_robot_argument(parser)
    parser.add_argument("--model", type=Path, metavar="FILE", help="the model to audit")
    parser.add_argument("--neighbours", action="store_true", help="count what neighbouring links hold at all times")
    parser.add_argument("--spheres", type=int, default=64, metavar="N", help="how many to fit, at most; default: 64")
    parser.add_argument("--excess", type=float, metavar="M", help="how far they may stick out of links, m")
    parser.add_argument("--output", type=Path, metavar="FILE", help="where the model goes: .yml, .urdf or .json")
    parser.add_argument("--findings", type=Path, metavar="FILE", help="where the audit goes (JSON)")


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    check_folder(options.output)
    check_folder(options.findings)
    if is_planar(options.robot, "robots"):
        raise PlannercheckError("cover is for robots in space: planar robots have no sphere models")
    if options.action == "audit":
        check_used(options, ("--spheres", "--excess"), "with fit")
        if options.model is None:
            raise PlannercheckError("audit needs the model: --model FILE")
    else:
        check_used(options, ("--model", "--neighbours"), "with audit")
    robot = robot_of(options)
    geometry = "solid" if options.geometry is None else None  # None: as --geometry has loaded the robot
    if options.action == "fit":
        covering = Covering.fit(robot, options.spheres, options.excess, geometry)
    else:
        covering = Covering.load(options.model, robot)
    found = covering.audit(geometry=geometry, neighbours=options.neighbours)
    print(table(HEADER, found.rows()))
    print(_words(found))
    if options.findings is not None:
        save_json(options.findings, found.as_json())
    if options.output is not None:
        grown = covering if options.action == "fit" else covering.inflated(geometry=geometry)
        grown.save(options.output)
        print(f"{options.output}: covers all links, every radius {1e3 * grown.growth:.3f} mm larger")
    return 0 if found.covered else 1


def _words(found: Audit) -> str:
    if found.covered:
        return "all links are covered, proved"
    low, high = (1e3 * each for each in found.outside)
    return f"not all links are covered: {low:.2f} to {high:.2f} mm are outside"
