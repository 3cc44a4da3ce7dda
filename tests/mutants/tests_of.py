"""Prints the tests that notice faults of a source: `python tests/mutants/tests_of.py motions/motion_bounds.cpp`.

In: sources, or parts of their names. Out: for each source how many of its mutants a test kills, most first.
"""

import sys
from collections import Counter, defaultdict

from mutants import read_mutants


def killing_tests(part: str) -> dict[str, Counter[str]]:
    """How many mutants each test kills, by the sources in whose paths a text is."""
    found: defaultdict[str, Counter[str]] = defaultdict(Counter)
    for mutant in read_mutants():
        if part in mutant.file:
            found[mutant.file].update(mutant.tests)
    return dict(found)


def main() -> None:
    """See the top."""
    for part in sys.argv[1:]:
        for source, tests in sorted(killing_tests(part).items()) or [(f"no mutant of {part}", Counter())]:
            print(source, *(f"{count:5} {test}" for test, count in tests.most_common()), sep="\n")


if __name__ == "__main__":
    main()
