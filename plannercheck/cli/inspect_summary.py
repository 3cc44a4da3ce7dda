"""The first screen of `plannercheck inspect`: what is tested, what is left out and why, and how many states are valid.

In: a checker and random configurations. Out: lines about robot, scene, pairs and states, and a table of the joints.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from plannercheck import planar
from plannercheck.checking.left_out_pairs import left_out_pairs
from plannercheck.cli.common import percentage, table
from plannercheck.common.array_types import Floats
from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot

# States of which all pairs are tested, and pairs that are named.
_MOST_STATES, _SHOWN_PAIRS = 1000, 3
_INDENT = " " * 8


def show_summary(checker: Checker | planar.Checker, q: Floats) -> tuple[int, dict[str, Any]]:
    """Prints the first screen, of random configurations (n, nq) within the limits.

    How many of them are valid, and what settled their pairs, as of `Checker.statistics`.
    """
    print(f"robot   {_robot(checker.robot)}")
    scene = checker.scene
    print(f"scene   {scene.name or 'without a name'}: {len(scene.object_names)} objects, {len(scene.bodies)} bodies")
    own = _own_pairs(checker)
    others = len(checker.pairs) - own
    print(f"pairs   {len(checker.pairs)} of bodies are tested: {own} self pairs, {others} with the scene")
    if isinstance(checker, Checker):
        _show_left_out(checker)
    valid, statistics = int(checker.check_states(q).sum()), checker.statistics()
    began = time.perf_counter()
    checker.check_states(q)  # again: the first call prepares what later ones find, some 0.1 s with meshes
    spent = time.perf_counter() - began
    print(
        f"states  {len(q)} random configurations within the limits: {valid} valid ({percentage(valid, len(q))}), "
        f"{1e6 * spent / len(q):.2f} µs each"
    )
    _show_colliding_pairs(checker, q[:_MOST_STATES])
    print(f"\n{_joints(checker.robot)}")
    return valid, statistics


def _robot(robot: Robot | planar.Robot) -> str:
    group = f" of group {robot.group!r}" if isinstance(robot, Robot) and robot.group else ""
    links = len({body.link for body in robot.bodies})
    return f"{robot.name}: {len(robot.joint_names)} joints{group}, {len(robot.bodies)} bodies on {links} links"


def _own_pairs(checker: Checker | planar.Checker) -> int:
    """Pairs of two bodies of the robot, or that it carries."""
    if isinstance(checker, Checker):
        moving = [body.link is not None for body in checker.bodies]
    else:
        moving = [body.link >= 0 for body in checker.bodies]
    return int(np.array(moving, dtype=bool)[checker.pairs].all(axis=1).sum())


def _show_left_out(checker: Checker) -> None:
    """Pairs that are not tested, and pairs that are settled before any state is tested."""
    for each in left_out_pairs(checker):
        if each.number:
            print(f"{_INDENT}{each.number} {'not tested' if each.defines else 'settled beforehand'}: {each.why}")


def _show_colliding_pairs(checker: Checker | planar.Checker, q: Floats) -> None:
    """The pairs of links and objects that collide most often."""
    colliding = checker.colliding_pairs(q)
    columns: dict[tuple[str, str], list[int]] = {}
    for k in np.flatnonzero(colliding.any(axis=0)).tolist():
        columns.setdefault(checker.pair_names(k), []).append(k)
    times = {names: int(colliding[:, found].any(axis=1).sum()) for names, found in columns.items()}
    most = sorted(times, key=times.__getitem__, reverse=True)[:_SHOWN_PAIRS]
    if most:
        shown = ", ".join(f"{a} – {b} ({percentage(times[a, b], len(q))})" for a, b in most)
        print(f"{_INDENT}pairs that collide most often: {shown}")


def _joints(robot: Robot | planar.Robot) -> str:
    """A row for each number of a configuration."""
    starts = robot.configuration_map.starts if isinstance(robot, Robot) else range(robot.nq)
    widths = np.diff([*starts, robot.nq]).tolist()
    names = [name for joint, width in zip(robot.joint_names, widths, strict=True) for name in _columns(joint, width)]
    limits = zip(names, robot.lower, robot.upper, strict=True)
    rows = [(k, name, f"{low:.6g}", f"{high:.6g}") for k, (name, low, high) in enumerate(limits)]
    return table(("column", "joint", "lower, rad or m", "upper"), rows)


def _columns(joint: str, width: int) -> list[str]:
    """The names of a joint's numbers; two are the cosine and sine of a continuous joint."""
    return [f"{joint} (cosine)", f"{joint} (sine)"] if width == 2 else [joint] * width
