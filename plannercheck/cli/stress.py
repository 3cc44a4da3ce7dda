"""`plannercheck stress`: hard pairs of bodies, every verdict compared with exact arithmetic; solids, sets, motions."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from plannercheck.cli.common import check_folder
from plannercheck.cli.unheeded_options import check_heeded
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.stress.other_libraries import Coal, Fcl, Peer
from plannercheck.evaluation.stress.random_cases import Draw
from plannercheck.evaluation.stress.run import StressTally
from plannercheck.evaluation.stress.run import run as run_suite
from plannercheck.evaluation.stress.tables import lines

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
of RRT-Connect hulls, or with --pieces convex pieces (which CoACD makes first, in minutes), would have refused.
"""
# Options of pairs, of solids, of sets of parts, of motions, and of all kinds of runs.
_OF_PAIRS, _OF_SOLIDS, _OF_PARTS, _OF_MOTIONS = (
    ("--pairs",),
    ("--solids", "--links"),
    ("--parts",),
    ("--motions", "--verified", "--families", "--geometry", "--pieces"),
)
_OF_BODIES = ("--peers",)
_OF_RUNS = ("--seed", "--processes", "--cases")
# Pairs between two lines of progress.
_REPORT_EVERY = 20_000
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
    parser.add_argument("--families", default="", metavar="NAME,...", help="families of motions to draw (default: all)")
    parser.add_argument("--case", type=Path, metavar="FILE", help="judge the motion or the pair in this file again")
    parser.add_argument("--seed", type=int, default=0, help="seed of the random numbers (default: %(default)s)")
    parser.add_argument("--processes", type=int, default=1, help="number of processes (default: %(default)s)")
    parser.add_argument("--peers", action="store_true", help="count the errors of python-fcl and coal, too")
    parser.add_argument("--cases", type=Path, metavar="FOLDER", help="keep failures, shrunk, as JSON files here")


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    _check_heeded(options)
    if options.pairs < 1 or options.seed < 0:
        raise PlannercheckError(
            f"--pairs must be at least 1 and --seed at least 0, not {options.pairs}, {options.seed}"
        )
    if options.cases is not None:
        check_folder(options.cases / "case")
    if not 1 <= options.processes <= MOST_PROCESSES:
        raise PlannercheckError(f"--processes must be 1 to {MOST_PROCESSES}, not {options.processes}")
    if options.case is not None:
        return _run_case(options.case)
    if options.motions is not None:
        from plannercheck.cli.stress_motions import run_motions  # needs OMPL

        return run_motions(options)
    if options.solids is not None:
        from plannercheck.cli.stress_solids import run_solids

        return run_solids(options)
    if options.parts is not None:
        from plannercheck.cli.stress_parts import run_parts

        return run_parts(options)
    peers: list[Peer[Draw]] = [Fcl(), Coal()] if options.peers else []
    tally = run_suite(options.pairs, options.seed, peers, _Progress(), options.processes)
    print("\n".join(lines(tally, [peer.name for peer in peers])))
    for number, case in enumerate(tally.cases):
        print(f"failed: {case.name}")
        if options.cases is not None:
            case.save(options.cases / f"{options.seed}-{number}.json")
    return 0 if tally.passed else 1


def _check_heeded(options: argparse.Namespace) -> None:
    """Raises if options are given that would change nothing."""
    if options.case is not None:
        others = (*_OF_PAIRS, *_OF_SOLIDS, *_OF_PARTS, *_OF_MOTIONS, *_OF_BODIES, *_OF_RUNS)
        check_heeded(options, others, "without --case, which is one motion or pair")
    elif options.motions is not None:
        check_heeded(options, (*_OF_PAIRS, *_OF_SOLIDS, *_OF_PARTS, *_OF_BODIES), "without --motions")
    elif options.solids is not None:
        check_heeded(options, (*_OF_PAIRS, *_OF_PARTS), "without --solids")
        check_heeded(options, _OF_MOTIONS, "with --motions")
    elif options.parts is not None:
        check_heeded(options, (*_OF_PAIRS, *_OF_BODIES), "without --parts")
        check_heeded(options, _OF_SOLIDS, "with --solids")
        check_heeded(options, _OF_MOTIONS, "with --motions")
    else:
        check_heeded(options, _OF_SOLIDS, "with --solids")
        check_heeded(options, _OF_MOTIONS, "with --motions")


def _run_case(path: Path) -> int:
    from plannercheck.evaluation.stress_parts.cases import PartCase
    from plannercheck.evaluation.stress_solids.cases import SolidCase

    if PartCase.is_in(path):
        from plannercheck.cli.stress_parts import run_part_case

        return run_part_case(path)
    if SolidCase.is_in(path):
        from plannercheck.cli.stress_solids import run_solid_case

        return run_solid_case(path)
    from plannercheck.cli.stress_motions import run_case  # needs OMPL

    return run_case(path)


class _Progress:
    """Lines on the error stream now and then."""

    def __init__(self) -> None:
        self._next = _REPORT_EVERY

    def __call__(self, tally: StressTally) -> None:
        pairs = tally.pairs.total()
        if pairs >= self._next:
            self._next = (pairs // _REPORT_EVERY + 1) * _REPORT_EVERY
            print(f"{pairs} pairs, {len(tally.cases)} failures", file=sys.stderr, flush=True)
