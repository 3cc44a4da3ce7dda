"""What the benchmarks of motions in space and in the plane share: least times, and their table of misses."""

import time
from collections import Counter
from collections.abc import Callable, Sequence

ROUNDS = 5


def least_times(judges: dict[str, Callable[[], object]]) -> dict[str, float]:
    """The least process time of each, s; all in turns, so that load hits each alike."""
    best = dict.fromkeys(judges, float("inf"))
    for turn in range(ROUNDS):
        for name in list(judges) if turn % 2 == 0 else reversed(list(judges)):
            began = time.process_time()
            judges[name]()
            best[name] = min(best[name], time.process_time() - began)
    return best


def print_misses(counts: Counter[tuple[str, str]], rows: Sequence[str]) -> None:
    """A table with a column for each family and one for all, from counts by (family, row)."""
    families = sorted({family for family, _ in counts})
    print(f"{'':30s}" + "".join(f"{family:>10s}" for family in (*families, "all")))
    for row in rows:
        values = [counts[family, row] for family in families]
        print(f"{row:30s}" + "".join(f"{value:10d}" for value in (*values, sum(values))))
