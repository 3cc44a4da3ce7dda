"""`plannercheck inspect`: bodies and pairs of a robot in a scene, and what checking them takes."""

from __future__ import annotations

import argparse
import time
from typing import Any

import numpy as np

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
  plannercheck inspect --robot ur5 --scene kitchen
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's options."""
    parser.epilog = _EPILOG
    add_robot_argument(parser)
    add_scene_argument(parser)
    add_checker_arguments(parser)
    parser.add_argument("--states", type=int, default=10_000, help="random configurations to check; default: 10000")
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
    return 0


def _show_bodies(checker: Checker) -> None:
    pairs = np.bincount(checker.pairs.ravel(), minlength=len(checker.bodies)).tolist()
    rows = []
    for body, polytope, count in zip(checker.bodies, checker.polytopes, pairs, strict=True):
        sizes: tuple[object, ...] = (0, 0, 0)  # a body that no pair needs is not prepared
        if polytope is not None:
            numbers = polytope.statistics()
            sizes = numbers["vertices"], numbers["facets"], numbers["bytes"] // 1024
        rows.append((body.name, body.link or "(scene)", type(body.shape).__name__.lower(), *sizes, count))
    print(table(("body", "link", "shape", "vertices", "facets", "kB", "pairs"), rows))
    fixed = len(checker.robot.bodies)
    own = int((checker.pairs < fixed).all(axis=1).sum())
    total = sum({id(p): p.nbytes for p in checker.polytopes if p is not None}.values())
    print(f"\n{len(checker.pairs)} pairs: {own} self pairs, {len(checker.pairs) - own} with the scene")
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
    print(table(("counter", "total", "each configuration"), _counters(checker.statistics(), states)))


def _counters(statistics: dict[str, Any], states: int) -> list[tuple[str, int, str]]:
    flat: dict[str, Any] = {}
    for name, value in statistics.items():
        nested = value if isinstance(value, dict) else {name: value}
        flat.update({key: item for key, item in nested.items() if isinstance(item, int)})
    return [(name.replace("_", " "), value, f"{value / states:.2f}") for name, value in flat.items()]
