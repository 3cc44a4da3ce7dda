"""`plannercheck stress --motions`: hard motions, judged in every available way.

In: the command's options. Out: the table on standard output, failures as files, the exit code.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.evaluation.stress_motions.cases import MotionCase, shrunk
from plannercheck.evaluation.stress_motions.run import FAMILY_NAMES, SOLID_NAMES, MotionTally
from plannercheck.evaluation.stress_motions.run import run as run_suite
from plannercheck.evaluation.stress_motions.tables import lines

# Seconds between two lines of progress.
_REPORT_SECONDS = 10.0


def run_motions(options: argparse.Namespace) -> int:
    """Runs the stress of motions; 1 on any fault."""
    if options.motions < 1 or options.verified < 0:
        raise PlannercheckError(
            f"--motions must be at least 1 and --verified at least 0, not {options.motions}, {options.verified}"
        )
    known = SOLID_NAMES if options.geometry == "solid" else FAMILY_NAMES
    families = tuple(name for name in options.families.split(",") if name) or known
    for name in families:
        if name not in known:
            raise unknown_name("family", name, known)
    if options.pieces and options.geometry != "solid":
        raise PlannercheckError("--pieces is of planners' motions among solids, with --geometry solid")
    progress = _Progress(options.motions)
    tally = run_suite(
        options.motions, options.seed, options.verified, options.processes, families, progress, options.pieces
    )
    print("\n".join(lines(tally)))
    for number, case in enumerate(tally.cases):
        print(f"failed: {case.kind}: {case.name}")
        if options.cases is not None:
            shrunk(case).save(options.cases / f"motion-{options.seed}-{number}.json")
    return 1 if tally.failures else 0


def run_case(path: Path) -> int:
    """Judges a kept motion again; 1 if it still fails."""
    case = MotionCase.load(path)
    faults = case.faults()
    print(case.name)
    print("\n".join(f"{kind}: {what}" for kind, what in faults.items()) or "nothing is wrong now")
    return 1 if faults else 0


class _Progress:
    """A line on the error stream now and then."""

    def __init__(self, motions: int) -> None:
        self._motions, self._began = motions, time.monotonic()
        self._next = self._began + _REPORT_SECONDS

    def __call__(self, tally: MotionTally) -> None:
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + _REPORT_SECONDS
        rate = tally.motions / (now - self._began)
        text = f"{tally.motions} of {self._motions} motions, {rate:.0f} a second, {tally.failures} faults"
        print(text, file=sys.stderr, flush=True)
