"""`plannercheck stress`: hard pairs of bodies against exact arithmetic; hard motions against all that we have."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from plannercheck.commands.common import check_folder
from plannercheck.errors import PlannercheckError, unknown_name
from plannercheck.stress.peers import Coal, Fcl, Peer
from plannercheck.stress.run import StressTally
from plannercheck.stress.run import run as run_suite
from plannercheck.stress.tables import lines

if TYPE_CHECKING:
    from plannercheck.stress.motion_run import MotionTally

_EPILOG = """\
Families of bodies x size x ratio of sizes x distance from the origin x rotation x gap, drawn at random. Every pair is
decided by all methods of the core and by an oracle of its own, which tells what it has proved in whole numbers; every
fourth draw the core's certificates have to prove its verdicts, too. What is found depends on the seed and the number of
pairs alone. Exit code 1 if a verdict is wrong, an exception is thrown, a body is refused or a query takes more than a
second.

With --motions: random trees of joints of all kinds, the shipped robots, planar chains and curves, among bodies that
touch them by construction. Exit code 1 if a motion that collides is passed, one is refused without reason, a verdict
depends on what was asked before or along with it, or a proof does not verify.
"""
# Pairs between two lines of progress.
_REPORT_EVERY = 20_000
# More would only get in each other's way on any machine.
MOST_PROCESSES = 1024
# Seconds between two lines of progress of motions.
_REPORT_SECONDS = 10.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's options."""
    parser.epilog = _EPILOG
    parser.add_argument("--pairs", type=int, default=10_000, help="how many at least (default: %(default)s)")
    parser.add_argument("--motions", type=int, metavar="N", help="judge at least N motions instead of pairs")
    parser.add_argument(
        "--verified", type=int, default=0, metavar="M", help="of them, prove and verify about M apart from the core"
    )
    parser.add_argument("--families", default="", metavar="NAME,…", help="of motions; all if not given")
    parser.add_argument("--case", type=Path, metavar="FILE", help="judge a kept motion again")
    parser.add_argument("--seed", type=int, default=0, help="of the random numbers (default: %(default)s)")
    parser.add_argument("--processes", type=int, default=1, help="how many to use (default: %(default)s)")
    parser.add_argument("--peers", action="store_true", help="count the errors of python-fcl and coal, too")
    parser.add_argument("--cases", type=Path, metavar="FOLDER", help="keep failures, shrunk, as JSON files here")


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    if options.pairs < 1 or options.seed < 0:
        raise PlannercheckError(
            f"--pairs must be at least 1 and --seed at least 0, not {options.pairs}, {options.seed}"
        )
    if options.cases is not None:
        check_folder(options.cases / "case")
    if not 1 <= options.processes <= MOST_PROCESSES:
        raise PlannercheckError(f"--processes must be 1 to {MOST_PROCESSES}, not {options.processes}")
    if options.case is not None:
        return _judge_case(options.case)
    if options.motions is not None:
        return _run_motions(options)
    peers: list[Peer] = [Fcl(), Coal()] if options.peers else []
    tally = run_suite(options.pairs, options.seed, peers, _Progress(), options.processes)
    print("\n".join(lines(tally, [peer.name for peer in peers])))
    for number, case in enumerate(tally.cases):
        print(f"failed: {case.name}")
        if options.cases is not None:
            case.save(options.cases / f"{options.seed}-{number}.json")
    return 0 if tally.passed else 1


def _run_motions(options: argparse.Namespace) -> int:
    """Runs the stress of motions, which needs OMPL."""
    from plannercheck.stress.motion_cases import shrunk
    from plannercheck.stress.motion_run import FAMILY_NAMES
    from plannercheck.stress.motion_run import run as run_motions
    from plannercheck.stress.motion_tables import lines as motion_lines

    if min(options.motions, options.processes) < 1 or options.verified < 0:
        raise PlannercheckError("--motions and --processes must be at least 1, and --verified at least 0")
    families = tuple(name for name in options.families.split(",") if name) or FAMILY_NAMES
    for name in families:
        if name not in FAMILY_NAMES:
            raise unknown_name("family", name, FAMILY_NAMES)
    report = _MotionProgress(options.motions)
    tally = run_motions(options.motions, options.seed, options.verified, options.processes, families, report)
    print("\n".join(motion_lines(tally)))
    for number, case in enumerate(tally.cases):
        print(f"failed: {case.kind}: {case.name}")
        if options.cases is not None:
            shrunk(case).save(options.cases / f"motion-{options.seed}-{number}.json")
    return 1 if tally.failures else 0


def _judge_case(path: Path) -> int:
    """Judges a kept motion again."""
    from plannercheck.stress.motion_cases import MotionCase

    case = MotionCase.load(path)
    faults = case.faults()
    print(f"{case.name}: {faults or 'nothing is wrong'}")
    return 1 if faults else 0


class _MotionProgress:
    """A line on the error stream now and then."""

    def __init__(self, motions: int) -> None:
        self._motions, self._began = motions, time.monotonic()
        self._next = self._began + _REPORT_SECONDS

    def __call__(self, tally: MotionTally) -> None:
        now = time.monotonic()
        if now >= self._next:
            self._next = now + _REPORT_SECONDS
            rate = tally.motions / (now - self._began)
            text = f"{tally.motions} of {self._motions} motions, {rate:.0f} a second, {tally.failures} faults"
            print(text, file=sys.stderr, flush=True)


class _Progress:
    """Lines on the error stream now and then."""

    def __init__(self) -> None:
        self._next = _REPORT_EVERY

    def __call__(self, tally: StressTally) -> None:
        pairs = tally.pairs.total()
        if pairs >= self._next:
            self._next = (pairs // _REPORT_EVERY + 1) * _REPORT_EVERY
            print(f"{pairs} pairs, {len(tally.cases)} failures", file=sys.stderr, flush=True)
