"""`plannercheck stress --parts`: sets of parts, half-spaces and ellipsoids, held against exact arithmetic.

In: the command's options. Out: tables on standard output, failures as files, the exit code.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from plannercheck.cli.stress_progress import PairsProgress
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.stress_parts.cases import PartCase
from plannercheck.evaluation.stress_parts.run import faults_of
from plannercheck.evaluation.stress_parts.run import run as run_suite
from plannercheck.evaluation.stress_parts.tables import lines


def run_parts(options: argparse.Namespace) -> int:
    """Runs the stress of sets of parts; 1 on any fault."""
    if options.parts < 1:
        raise PlannercheckError(f"--parts must be at least 1, not {options.parts}")
    tally = run_suite(options.parts, options.seed, PairsProgress(options.parts), options.processes)
    print("\n".join(lines(tally)))
    for number, case in enumerate(tally.cases):
        print(f"failed: {case.name}")
        if options.cases is not None:
            case.save(options.cases / f"parts-{options.seed}-{number}.json")
    return 0 if tally.passed else 1


def run_part_case(path: Path) -> int:
    """Judges a kept pair again; 1 if it still fails."""
    case = PartCase.load(path)
    faults = faults_of(case)
    print(case.name)
    print("\n".join(f"{who}: {outcome}" for who, outcome in faults.items()) or "nothing is wrong now")
    return 1 if faults else 0
