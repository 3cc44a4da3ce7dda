"""Where a planner samples, and how far it goes at once: what plans take, and how long their paths are.

`python tests/benchmarks/plan_sampling.py SET_panda.tar.bz2 ... --every 4 --seeds 4`: RRTConnect on MotionBenchMaker's
problems, everywhere with OMPL's own bounds and near start and goal first (plannercheck/ompl/near_first.py). Settings
take turns, plan by plan; the least time of two searches counts. A search that finds nothing in time counts with that
time, and has no length.
"""

import argparse
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from plannercheck import Robot, ompl
from plannercheck.cli.common import table
from plannercheck.evaluation.bench.problems import Task, name_of_set, tasks
from plannercheck.evaluation.bench.records import write_record
from plannercheck.ompl.near_first import Sampling
from plannercheck.ompl.plans import Plan

SEARCHES = 2
LIMIT = 3.0  # s


class Setting(NamedTuple):
    """How a planner searches."""

    sampling: Sampling
    longest: float  # rad


class Searched(NamedTuple):
    """What became of one problem with one seed: milliseconds; lengths as found and shortened, rad, NaN if unsolved."""

    ms: float
    found: float
    shortened: float


class Row(NamedTuple):
    """What one setting did on a set: numbers of searches; medians and means of milliseconds; median lengths, rad."""

    set: str
    sampling: Sampling
    range: float
    tried: int
    solved: int
    median_ms: float
    mean_ms: float
    found: float
    shortened: float


def searched(task: Task, setting: Setting, seed: int) -> Searched:
    """Plans without and with shortening."""

    def plan(simplify: bool) -> Plan:
        return ompl.plan(
            task.checker,
            task.start,
            task.goal,
            time_limit=LIMIT,
            simplify=simplify,
            seed=seed,
            longest_motion=setting.longest,
            sampling=setting.sampling,
        )

    plans = [plan(False) for _ in range(SEARCHES)]
    ms = 1e3 * min(each.time for each in plans)
    if not plans[0].solved:
        return Searched(ms, np.nan, np.nan)
    return Searched(ms, plans[0].length, plan(True).length)


def row(name: str, setting: Setting, all_found: list[Searched]) -> Row:
    """Medians of a set, and the mean time."""
    ms, found, shortened = np.array(all_found).T
    return Row(
        name,
        setting.sampling,
        setting.longest,
        len(ms),
        int(np.isfinite(found).sum()),
        float(np.median(ms)),
        float(ms.mean()),
        float(np.nanmedian(found)),
        float(np.nanmedian(shortened)),
    )


def main() -> None:
    """Runs it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("problems", nargs="+", type=Path, metavar="SET")
    parser.add_argument("--every", type=int, default=4)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--ranges", type=float, nargs="+", default=[0.5, 0.7, 1.0])
    parser.add_argument("--output", type=Path, metavar="FILE.json")
    options = parser.parse_args()
    settings = [Setting(*each) for each in product(("everywhere", "near"), options.ranges)]
    rows = []
    for path in options.problems:
        found: dict[Setting, list[Searched]] = {setting: [] for setting in settings}
        for task in tasks(path, Robot.load("panda"), options.every):
            for seed, setting in product(range(1, options.seeds + 1), settings):
                found[setting].append(searched(task, setting, seed))
        rows += [row(name_of_set(path), setting, all_found) for setting, all_found in found.items()]
    heads = ("set", "samples", "range", "tried", "solved", "median ms", "mean ms", "rad, found", "rad, shortened")
    print(table(heads, [(*each[:5], *(f"{value:.3g}" for value in each[5:])) for each in rows]))
    if options.output is not None:
        write_record(options.output, [each._asdict() for each in rows])


if __name__ == "__main__":
    main()
