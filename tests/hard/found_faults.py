"""Whether the stress of motions finds the faults that an audit found: each is put back in, alone, by a mutant.

    python tests/hard/found_faults.py --motions 10000 --seed 1

In: mutants by name. Out: a line each, with the kinds of fault that were found and after how many motions; exit code 1
if one was not found. See tests/mutation.py for the copy of the checkout that the mutants go into.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from mutants import read_mutants
from mutated_checkout import CheckoutCopy, run

# Of the audit: what it was, and the mutant that brings it back.
FAULTS = {
    "1, a line's direction that is not normalised": "planar-stored-direction-not-normalised",
    "2, a planar or floating joint seen from its child": "motions-own-displacement-from-the-child-forgotten",
    "4, far ends of continuous joints": "turns-two-pi-is-a-double",
    "5, lengths off 1 along a chain": "lengths-do-not-add-up-along-chains",
}
_TIME_LIMIT = 1800.0


def main() -> int:
    """Puts each fault in and runs the stress."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--motions", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--level", default="v3")
    options = parser.parse_args()
    mutants = {mutant.name: mutant for mutant in read_mutants()}
    copy = CheckoutCopy(Path(tempfile.gettempdir()) / "plannercheck-found-faults", options.level)
    command = [sys.executable, "-m", "plannercheck", "stress", "--motions", str(options.motions)]
    missed = 0
    for fault, name in FAULTS.items():
        with copy.with_mutant(mutants[name]) as said:
            if said:
                raise SystemExit(f"{name} does not compile: {said[-1000:]}")
            ran = run([*command, "--seed", str(options.seed)], copy.root, copy.environment, _TIME_LIMIT)
        found = [line for line in ran.text.splitlines() if line.startswith("first ")]
        missed += ran.code != 1 or not found
        print(f"fault {fault}: {'; '.join(found) or f'NOT FOUND, exit code {ran.code}'}", flush=True)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
