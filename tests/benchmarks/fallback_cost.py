"""What the stages behind the filter cost on robot states: `python tests/benchmarks/fallback_cost.py FOLDER`.

FOLDER holds a core that is built without nearest points, double-double and exact arithmetic, whose verdicts are guesses
where the solver does not decide:

    cmake -S plannercheck/cpp -B FOLDER -DPLANNERCHECK_NO_FALLBACK=ON -DPLANNERCHECK_LEVELS=v3
    cmake --build FOLDER

One process loads that core and the usual one and lets them judge the same random states of the Panda in blocks, in
turns (A B C, C B A); of each block the least time counts. C is a second checker of the usual core: its ratio shows the
noise. Printed are the ratios of the sums, the queries behind the filter, and the states whose verdicts differ.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import sys
import time
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

# Blocks are short, so that some run of each meets no other load.
STATES, BLOCK, ROUNDS = 20_000, 200, 20
BEHIND = ("nearest_points", "double_double", "exact")


def import_anew() -> ModuleType:
    """The package, imported once more; what was imported before lives on."""
    for name in [name for name in sys.modules if name.split(".")[0] == "plannercheck" and "._core_" not in name]:
        del sys.modules[name]
    return importlib.import_module("plannercheck")


def preload(folder: Path, name: str) -> None:
    """Loads an extension module from a folder under the name by which the package imports its own."""
    file = next(folder.glob(f"{name}.*"))
    spec = importlib.util.spec_from_file_location(f"plannercheck.{name}", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    sys.modules[f"plannercheck.{name}"] = module


def checker_of(package: ModuleType, scene: str) -> Any:
    """The Panda in a scene."""
    return package.Checker(package.Robot.load("panda"), package.Scene.load(scene))


def seconds(checker: Any, q: np.ndarray) -> float:
    """Time of one batch."""
    start = time.perf_counter()
    checker.check_states(q)
    return time.perf_counter() - start


def ratios(checkers: list[Any], q: np.ndarray) -> np.ndarray:
    """Time of the first checker over that of each."""
    blocks = [np.ascontiguousarray(q[k : k + BLOCK]) for k in range(0, len(q), BLOCK)]
    least = np.full((len(checkers), len(blocks)), np.inf)
    for turn in range(ROUNDS):
        for k, block in enumerate(blocks):
            order = range(len(checkers)) if turn % 2 == 0 else reversed(range(len(checkers)))
            for which in order:
                least[which, k] = min(least[which, k], seconds(checkers[which], block))
    spent = least.sum(axis=1)
    return np.asarray(spent[0] / spent)


def main() -> None:
    """Prints a line a scene."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="where the core without the stages is")
    parser.add_argument("--scenes", nargs="+", default=["bookshelf"])
    options = parser.parse_args()
    package = importlib.import_module("plannercheck")
    name = f"_core_{importlib.import_module('plannercheck.common.core').core.level}"
    preload(options.folder, name)
    other = import_anew()
    for scene in options.scenes:
        usual, again, without = checker_of(package, scene), checker_of(package, scene), checker_of(other, scene)
        q = usual.robot.random_configurations(STATES, 0)
        differ = int((usual.check_states(q) != without.check_states(q)).sum())
        statistics = usual.statistics()
        behind = ", ".join(f"{statistics[stage]} {stage.replace('_', ' ')}" for stage in BEHIND)
        _, to_without, to_itself = ratios([usual, without, again], q)
        print(f"{scene}: {to_without:.3f} (noise: {to_itself:.3f}); {STATES} states, {statistics['pairs']} pairs")
        print(f"  decided behind the filter: {behind}; {differ} verdicts differ without")


if __name__ == "__main__":
    main()
