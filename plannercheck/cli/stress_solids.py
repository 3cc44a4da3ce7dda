"""`plannercheck stress --solids`: pairs of concave bodies, every verdict held against exact arithmetic.

In: the command's options. Out: tables on standard output, failures as files, the exit code.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from plannercheck.cli.stress_progress import PairsProgress
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.stress.other_libraries import Peer
from plannercheck.evaluation.stress_solids.cases import SolidCase
from plannercheck.evaluation.stress_solids.draws import Draw
from plannercheck.evaluation.stress_solids.other_libraries import CoalMeshes, FclMeshes
from plannercheck.evaluation.stress_solids.run import faults_of
from plannercheck.evaluation.stress_solids.run import run as run_suite
from plannercheck.evaluation.stress_solids.tables import lines


def run_solids(options: argparse.Namespace) -> int:
    """Runs the stress of solids; 1 on any fault."""
    if options.solids < 1:
        raise PlannercheckError(f"--solids must be at least 1, not {options.solids}")
    peers: list[Peer[Draw]] = [FclMeshes(), CoalMeshes()] if options.peers else []
    progress = PairsProgress(options.solids)
    tally = run_suite(options.solids, options.seed, peers, progress, options.processes, options.links)
    print("\n".join(lines(tally, [peer.name for peer in peers])))
    for number, case in enumerate(tally.cases):
        print(f"failed: {case.name}")
        if options.cases is not None:
            case.save(options.cases / f"solids-{options.seed}-{number}.json")
    return 0 if tally.passed else 1


def run_solid_case(path: Path) -> int:
    """Judges a kept pair of solids again; 1 if it still fails."""
    case = SolidCase.load(path)
    faults = faults_of(case)
    print(case.name)
    print("\n".join(f"{who}: {outcome}" for who, outcome in faults.items()) or "nothing is wrong now")
    return 1 if faults else 0
