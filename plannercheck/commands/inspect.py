"""`plannercheck inspect`: bodies and pairs of a robot in a scene, and what checking them takes."""

from __future__ import annotations

import argparse
import functools
import math
import time
import warnings
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from plannercheck import planar
from plannercheck.checker import Checker
from plannercheck.commands.common import (
    add_checker_arguments,
    add_robot_argument,
    add_scene_argument,
    load_checker,
    percentage,
    table,
)
from plannercheck.errors import PlannercheckError
from plannercheck.protocols import AnyChecker

_EPILOG = """\
Example:
  plannercheck inspect --robot ur5 --scene kitchen --without
"""

# Ways of skipping work that a checker can be built without, and what they are.
SKIPS = {
    "reach": "pairs that limits keep apart",
    "bounds": "balls, tree of obstacles",
    "boxes": "planes along boxes",
    "cached_plane": "last separating plane",
    "centre_axis": "axis between centres",
    "learning": "likeliest pair first",
}
_ROUNDS = 5


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's options."""
    parser.epilog = _EPILOG
    add_robot_argument(parser)
    add_scene_argument(parser)
    add_checker_arguments(parser)
    parser.add_argument("--states", type=int, default=10_000, help="random configurations to check; default: 10000")
    parser.add_argument(
        "--without", action="store_true", help="also time the states without each way of skipping work, one at a time"
    )
    parser.add_argument("--seed", type=int, default=0, help="of the random configurations; default: 0")


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    if options.states < 1 or options.seed < 0:
        raise PlannercheckError("--states must be at least 1 and --seed at least 0")
    began = time.perf_counter()
    checker = load_checker(options)
    print(f"{checker!r}, prepared in {time.perf_counter() - began:.2f} s\n")
    _show_bodies(checker) if isinstance(checker, Checker) else _show_polygons(checker)
    _show_sample(checker, options.states, options.seed)
    if options.without:
        if not isinstance(checker, Checker):
            raise PlannercheckError("--without times the skips of checkers in space; planar ones have others")
        q = checker.robot.random_configurations(options.states, options.seed)
        _show_without(checker, not options.no_self_collision, q)
    return 0


def _show_bodies(checker: Checker) -> None:
    pairs = np.bincount(checker.pairs.ravel(), minlength=len(checker.bodies)).tolist()
    rows = []
    for body, polytope, count in zip(checker.bodies, checker.prepared, pairs, strict=True):
        sizes: tuple[object, ...] = (0, 0, 0)  # a body that no pair needs within the limits is not prepared
        if polytope is not None:
            numbers = polytope.statistics()
            sizes = numbers["vertices"], numbers["facets"], numbers["bytes"] // 1024
        rows.append((body.name, body.link or "(scene)", type(body.shape).__name__.lower(), *sizes, count))
    print(table(("body", "link", "shape", "vertices", "facets", "kB", "pairs"), rows))
    moving = np.array([body.link is not None for body in checker.bodies], dtype=bool)
    own = int(moving[checker.pairs].all(axis=1).sum())
    total = sum({id(p): p.nbytes for p in checker.prepared if p is not None}.values())
    print(f"\n{len(checker.pairs)} pairs: {own} self pairs, {len(checker.pairs) - own} with the scene")
    by_limits, at_rest = (int((checker.unreachable & part).sum()) for part in (~checker.resting, checker.resting))
    print(
        f"dropped within the joint limits: {by_limits} pairs that cannot reach each other, and {at_rest} of the "
        f"{int(checker.resting.sum())} that no joint of the group moves, since they are apart"
    )
    print(f"prepared bodies take {total / 2**20:.1f} MB, equal shapes counted once")


def _show_polygons(checker: AnyChecker) -> None:
    assert isinstance(checker, planar.Checker)
    pairs = np.bincount(checker.pairs.ravel(), minlength=len(checker.bodies)).tolist()
    links = checker.robot.link_names
    rows = [
        (body.name, "(scene)" if body.link < 0 else links[body.link], len(body.vertices), count)
        for body, count in zip(checker.bodies, pairs, strict=True)
    ]
    print(table(("body", "link", "vertices", "pairs"), rows))


def _show_sample(checker: AnyChecker, states: int, seed: int) -> None:
    q = checker.robot.random_configurations(states, seed)
    began = time.perf_counter()
    valid = int(checker.check_states(q).sum())
    spent = time.perf_counter() - began
    print(
        f"\n{states} random configurations within the limits: {valid} valid ({percentage(valid, states)}), "
        f"{1e6 * spent / states:.2f} µs each\n"
    )
    statistics = checker.statistics()
    queries = statistics.pop("queries")
    pairs = statistics["pairs"]
    settled = [(_words(name), n, f"{n / states:.2f}", percentage(n, pairs)) for name, n in statistics.items()]
    print(table(("pairs settled by", "total", "each configuration", "of all pairs"), settled[1:]))
    print()
    tests = [(_words(name), n, f"{n / states:.2f}") for name, n in queries.items()]
    print(table(("pair test", "total", "each configuration"), tests))


def _words(name: str) -> str:
    return name.replace("_", " ")


def _show_without(checker: Checker, self_collision: bool, q: NDArray[np.float64]) -> None:
    build = functools.partial(Checker, checker.robot, checker.scene, self_collision)
    spent = times_without(build, q, _ROUNDS)
    rows = [
        (_words(name), SKIPS.get(name, ""), f"{1e6 * seconds / len(q):.2f}", f"{seconds / spent['nothing']:.2f}")
        for name, seconds in spent.items()
    ]
    print()
    print(table(("without", "what that is", "µs each", "times as long"), rows))


def times_without(build: Callable[..., Checker], q: NDArray[np.float64], rounds: int) -> dict[str, float]:
    """Least CPU seconds for a set of configurations, with all ways of skipping work and without each of `SKIPS`.

    Args:
        build: Makes a checker from switches.
        q: (n, nq) rad and m.
        rounds: How often all take turns, forwards and backwards.

    Returns:
        By what is left out, "nothing" first.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of links that rest on obstacles: they were given before
        checkers = {"nothing": build(), **{skip: build(**{skip: False}) for skip in SKIPS}}
    best = dict.fromkeys(checkers, math.inf)
    for turn in range(rounds):
        for name in list(checkers) if turn % 2 == 0 else reversed(list(checkers)):
            began = time.thread_time()
            checkers[name].check_states(q)
            best[name] = min(best[name], time.thread_time() - began)
    return best
