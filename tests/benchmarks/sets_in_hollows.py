"""Sets of parts in the hollows of solids, by every public call: no error, and no answer beside the truth.

In: how many random cases, and where they begin. Out: a table of cases and verdicts, and each fault with its seed.

    PYTHONPATH=tests/support python tests/benchmarks/sets_in_hollows.py --cases 2000
"""

import argparse
import contextlib
import io
import tempfile
import time
import warnings
from collections import Counter
from pathlib import Path

from nested_calls import MODES, faults_of_bodies, faults_of_checker, told
from nested_parts import draw

# One case of so many is planned for and given to the command line.
_THOROUGH = 20


def run(first: int, cases: int) -> int:
    """Judges the cases and prints what is found; how many faults there are."""
    counts, faults, began = Counter[tuple[str, str, bool]](), 0, time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(first, first + cases):
            case = draw(seed)
            counts[case.shape, case.kind, case.meets] += 1
            mode = MODES[seed // 7 % len(MODES)]
            thorough = seed % _THOROUGH == 0
            with contextlib.redirect_stdout(io.StringIO()):
                found = told(lambda c=case: faults_of_bodies(c))
                found += told(lambda c=case, m=mode, t=thorough: faults_of_checker(c, m, Path(folder), t))
            for fault in found:
                print(f"seed {seed}, {case.kind} in {case.shape}, {mode}: {fault}", flush=True)
            faults += len(found)
    for (shape, kind, meets), count in sorted(counts.items()):
        print(f"{shape:8} {kind:8} {'meet' if meets else 'apart':6} {count}")
    print(f"{cases} cases, {faults} faults, {time.monotonic() - began:.0f} s")
    return faults


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    raise SystemExit(bool(run(options.first, options.cases)))
