"""Whether the stress of motions finds the faults that it was written for: `python tests/mutants/found_faults.py`.

In: mutants of tests/mutants, by the fault that they put back. Out: for each, within how many motions it is found, and
the exit code 1 if one is not found in MOTIONS, or if the checkout itself fails. All is built and run in a copy (see
`mutants/mutated_checkout.py`); with `--only 2` one fault alone, with `--all` among motions of all families.
"""

import argparse
import contextlib
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from mutants import read_mutants
from mutated_checkout import CheckoutCopy, run

MOTIONS = 10_000
LIMIT = 900.0  # s for a run


class PutBack(NamedTuple):
    """A fault: what is put back, and the families of motions that are about it, as the command line takes them."""

    family: str
    mutants: tuple[str, ...]


FAULTS = {
    "1": PutBack("plane swing", ("planar-stored-direction-not-normalised", "motion-planes-of-earlier-motions-count")),
    "2": PutBack("placed,tree,chain", ("motions-own-displacement-from-the-child-forgotten",)),
    "3": PutBack("ompl", ("turns-ompls-angles-are-all-continuous-joints",)),
    "4": PutBack("far ends", ("turns-two-pi-is-a-double", "turns-rounding-of-given-ends-forgotten")),
    "5": PutBack("off unit", ("lengths-any-are-harmless", "lengths-do-not-add-up-along-chains")),
}


def stressed(copy: CheckoutCopy, families: str, seed: int) -> tuple[int | None, str]:
    """Exit code of the stress, and what it wrote."""
    options = ["--motions", str(MOTIONS), "--seed", str(seed), "--families", families]
    ran = run([sys.executable, "-m", "plannercheck", "stress", *options], copy.root, copy.environment, LIMIT)
    return ran.code, ran.text


def found(copy: CheckoutCopy, fault: PutBack, families: str, seed: int) -> str:
    """What the stress says of a fault that was put back; empty if nothing."""
    known = {mutant.name: mutant for mutant in read_mutants()}
    with contextlib.ExitStack() as stack:
        for name in fault.mutants:
            if said := stack.enter_context(copy.with_mutant(known[name])):
                return "" if "error" not in said else f"does not compile: {said[-300:]}"
        code, text = stressed(copy, families, seed)
    first = [line for line in text.splitlines() if line.startswith("first ")]
    return "; ".join(first) if code == 1 else ""


def main() -> int:
    """Runs it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", choices=FAULTS, action="append", help="this fault alone")
    parser.add_argument("--all", action="store_true", help="among motions of all families")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--level", default="v3")
    parser.add_argument("--folder", type=Path, default=Path(tempfile.gettempdir()) / "plannercheck-found-faults")
    options = parser.parse_args()
    copy = CheckoutCopy(options.folder, options.level)
    copy.build_original()
    missed = 0
    for name in options.only or FAULTS:
        families = "" if options.all else FAULTS[name].family
        clean, text = stressed(copy, families, options.seed)
        said = found(copy, FAULTS[name], families, options.seed)
        missed += not said or clean != 0
        print(f"fault {name} ({families or 'all families'}): {said or 'NOT FOUND'}", flush=True)
        if clean != 0:
            print(f"the checkout itself fails:\n{text[-2000:]}")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
