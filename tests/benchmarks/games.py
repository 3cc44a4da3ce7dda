"""Time of the solver's games: `python tests/benchmarks/games.py [--games 10000]`.

Random payoffs between −1 and 1. As in a search, a game gains rows and columns by turns and is solved again each time;
what the last two of these solutions take is half of what games of one size take longer than those of the size before.
Sizes take turns in one process; the least CPU time of each counts.
"""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path

import numpy as np

from plannercheck.common.core import core
from plannercheck.evaluation.bench.records import write_record
from plannercheck.evaluation.bench.timing import least_seconds

SIZES = range(1, 9)


def main() -> None:
    """Prints a row a size."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--games", type=int, default=10_000, help="of each size; default: 10000")
    parser.add_argument("--rounds", type=int, default=21)
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    rng = np.random.default_rng(0)
    games = {f"{k} x {k}": rng.uniform(-1, 1, (options.games, k, k)) for k in SIZES}
    spent = least_seconds(
        {name: partial(core.solve_games, payoffs, 1.0) for name, payoffs in games.items()}, options.rounds
    )
    print("game    all of it, ns   one more row or column, solved, ns")
    rows, before = [], None
    for name, seconds in spent.items():
        all_of_it = 1e9 * seconds / options.games
        more = "" if before is None else f"{(all_of_it - before) / 2:10.0f}"
        print(f"{name}  {all_of_it:14.0f}   {more}")
        rows.append({"game": name, "nanoseconds": all_of_it, "one_more": None if before is None else float(more)})
        before = all_of_it
    if options.output:
        write_record(options.output, rows)


if __name__ == "__main__":
    main()
