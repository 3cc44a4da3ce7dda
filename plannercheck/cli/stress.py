"""`plannercheck stress`: hard pairs of bodies, every verdict compared with exact arithmetic; solids, sets, motions."""

from __future__ import annotations

import argparse
import itertools
import sys
import time
from functools import partial
from pathlib import Path
from typing import Any

from plannercheck.cli.common import check_folder
from plannercheck.cli.unused_options import check_used
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.evaluation.campaign.campaign import Campaign
from plannercheck.evaluation.campaign.campaign import run as run_campaign
from plannercheck.evaluation.campaign.cases import load, save
from plannercheck.evaluation.campaign.tallies import Tally

_EPILOG = """\
Families of bodies x size x ratio of sizes x distance from the origin x rotation x gap, drawn at random. Every pair is
decided by all methods of the core and by an oracle of its own, which tells what it has proved in whole numbers; every
fourth draw the core's certificates have to prove its verdicts, too. What is found depends on the seed and the number of
pairs alone. Exit code 1 if a verdict is wrong, an
exception is thrown, a body is refused or a query takes more than a second.

With --solids instead: pairs of concave solids, nested, interlocked, crossing themselves, open or without volume, also
against polytopes, balls, segments and points, about where they begin to share a point; or with --links pairs of links
of the shipped robots, turned as in random states. Exit code as above.

With --parts instead: clouds of points, lattices of cells and heights over a base, against hulls, each other and solids,
every part of one against every part of the other; half-spaces and ellipsoids. Exit code as above.

With --motions instead: random trees of all kinds of joints, the shipped robots, planar chains and curves, among bodies
that touch them by construction. Exit code 1 if a motion that collides is passed, one is refused without reason, a
verdict depends on what else was asked, or a proof is not verified. With --geometry solid: arms with their meshes as
they are, and free bodies in concave puzzles, held against coal's meshes at states in between, too; and how many motions
of RRT-Connect hulls, or with --pieces convex pieces (which CoACD makes first, in minutes), would have refused. With
--curves: trajectories of degree 1 to 7 through the same contacts, with which a corner of their tube may touch. With
--cells: two to four robots on one clock, each with its own trajectory, among bodies that move.
"""
# Options that count only with the one that asks for a campaign; others are of pairs.
_OF_CAMPAIGNS: dict[str, tuple[str, ...]] = {
    "--motions": ("--verified", "--families", "--geometry", "--pieces", "--curves", "--cells"),
    "--solids": ("--links",),
    "--parts": (),
}
_OF_RUNS = ("--seed", "--processes", "--cases")
# Seconds between two lines of progress.
_REPORT_SECONDS = 10.0
# More would only get in each other's way on any machine.
MOST_PROCESSES = 1024


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's options."""
    parser.epilog = _EPILOG
    parser.add_argument("--pairs", type=int, default=10_000, help="judge at least this many (default: %(default)s)")
    parser.add_argument("--solids", type=int, metavar="N", help="judge at least N pairs of solids instead")
    parser.add_argument("--links", action="store_true", help="with --solids: links of the shipped robots")
    parser.add_argument("--parts", type=int, metavar="N", help="judge at least N pairs with sets of parts instead")
    parser.add_argument("--motions", type=int, metavar="N", help="judge at least N motions instead of pairs")
    parser.add_argument("--verified", type=int, default=0, metavar="M", help="prove and verify about M of the motions")
    parser.add_argument(
        "--geometry", choices=("hull", "solid"), default="hull", help="what moves (default: hulls, among hulls)"
    )
    parser.add_argument("--pieces", action="store_true", help="with solids: count what convex pieces refuse, too")
    parser.add_argument("--curves", action="store_true", help="with --motions: curves, many of them with a tube")
    parser.add_argument("--cells", action="store_true", help="with --motions: cells of robots and bodies that move")
    parser.add_argument("--families", default="", metavar="NAME,...", help="families of motions to draw (default: all)")
    parser.add_argument("--case", type=Path, metavar="FILE", help="judge the motion or the pair in this file again")
    parser.add_argument("--seed", type=int, default=0, help="seed of the random numbers (default: %(default)s)")
    parser.add_argument("--processes", type=int, default=1, help="number of processes (default: %(default)s)")
    parser.add_argument("--peers", action="store_true", help="count the errors of python-fcl and coal, too")
    parser.add_argument("--cases", type=Path, metavar="FOLDER", help="keep failures, shrunk, as JSON files here")


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    name = next((each for each in _OF_CAMPAIGNS if getattr(options, each[2:]) is not None), "--pairs")
    _check_used(options, name)
    wanted: int = getattr(options, name[2:])
    for each, value, least in ((name, wanted, 1), ("--seed", options.seed, 0), ("--verified", options.verified, 0)):
        if value < least:
            raise PlannercheckError(f"{each} must be at least {least}, not {value}")
    if options.cases is not None:
        check_folder(options.cases / "case")
    if not 1 <= options.processes <= MOST_PROCESSES:
        raise PlannercheckError(f"--processes must be 1 to {MOST_PROCESSES}, not {options.processes}")
    if options.case is not None:
        return _run_case(options)
    campaign = _CAMPAIGNS[name[2:]](options)
    tally = run_campaign(campaign, wanted, options.processes, _Progress(campaign.unit, wanted))
    print("\n".join(campaign.lines(tally)))
    for number, case in enumerate(tally.cases):
        print(f"failed: {case.name}")
        if options.cases is not None:
            path = options.cases / f"{campaign.name}-{options.seed}-{number}.json"
            save(path, campaign.name, campaign.shrunk(case).document())
    return 1 if tally.failures else 0


def _check_used(options: argparse.Namespace, name: str) -> None:
    """Raises if options are given that would change nothing."""
    if options.case is not None:
        others = ("--pairs", *_OF_CAMPAIGNS, *itertools.chain(*_OF_CAMPAIGNS.values()), "--peers", *_OF_RUNS)
        check_used(options, others, "without --case, which is one motion or pair")
    check_used(options, [each for each in ("--pairs", *_OF_CAMPAIGNS) if each != name], f"without {name}")
    for other, those in _OF_CAMPAIGNS.items():
        if other != name:
            check_used(options, those, f"with {other}")
    if name in ("--motions", "--parts"):
        check_used(options, ["--peers"], f"without {name}")


def _run_case(options: argparse.Namespace) -> int:
    """Judges a kept case again; 1 if it still fails."""
    campaign, case = load(options.case, {name: partial(made, options) for name, made in _CAMPAIGNS.items()})
    faults = campaign.faults(case)
    print(case.name)
    print("\n".join(f"{who}: {outcome}" for who, outcome in faults.items()) or "nothing is wrong now")
    return 1 if faults else 0


def _pairs(options: argparse.Namespace) -> Campaign[Any]:
    from plannercheck.evaluation.stress.campaign import campaign
    from plannercheck.evaluation.stress.other_libraries import Coal, Fcl

    return campaign(options.seed, (Fcl, Coal) if options.peers else ())


def _solids(options: argparse.Namespace) -> Campaign[Any]:
    from plannercheck.evaluation.stress_solids.campaign import campaign
    from plannercheck.evaluation.stress_solids.other_libraries import CoalMeshes, FclMeshes

    return campaign(options.seed, (FclMeshes, CoalMeshes) if options.peers else (), options.links)


def _parts(options: argparse.Namespace) -> Campaign[Any]:
    from plannercheck.evaluation.stress_parts.campaign import campaign

    return campaign(options.seed)


def _motions(options: argparse.Namespace) -> Campaign[Any]:
    from plannercheck.evaluation.stress_motions.campaign import campaign, families_of  # needs OMPL

    if options.cells and (options.curves or options.geometry == "solid"):
        raise PlannercheckError("--cells is of trees of hulls on one clock: without --curves and --geometry")
    known = families_of(options.geometry == "solid", options.curves, options.cells)
    families = tuple(name for name in options.families.split(",") if name) or known
    for name in families:
        if name not in known:
            raise unknown_name("family", name, known)
    if options.pieces and options.geometry != "solid":
        raise PlannercheckError("--pieces is of planners' motions among solids, with --geometry solid")
    verified = options.verified / (options.motions or 1)
    return campaign(options.seed, families, verified, options.pieces, options.curves)


_CAMPAIGNS = {"pairs": _pairs, "solids": _solids, "parts": _parts, "motions": _motions}


class _Progress:
    """A line on the error stream now and then."""

    def __init__(self, unit: str, wanted: int) -> None:
        self._unit, self._wanted, self._began = unit, wanted, time.monotonic()
        self._next = self._began + _REPORT_SECONDS

    def __call__(self, tally: Tally[Any]) -> None:
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + _REPORT_SECONDS
        rate = tally.judged / (now - self._began)
        text = f"{tally.judged} of {self._wanted} {self._unit}, {rate:.0f} a second, {tally.failures} failures"
        print(text, file=sys.stderr, flush=True)
