"""All places where a pair of bodies may be left out, in the order in which they apply, each with its number of pairs.

Candidates are all pairs among the robot's bodies and carried objects, and all pairs of one of these with an obstacle.
Places that leave out pairs:

1. robots/description.py: the robot's YAML names both links in `disabled_pairs`.
2. robots/self_pairs.py: both bodies are on one joint; the SRDF disables their links or, without an SRDF, the links are
   neighbours; in an MJCF file, MuJoCo does not test them (bodies/mjcf_pairs.py).
3. robots/carried_objects.py: a carried object and the link that carries it, one of its touch links, or another object
   on that link.
4. checking/pair_table.py: the checker has no self-collision, the scene allows the pair to collide, the SRDF disables
   the link by default and the other body is an obstacle or is carried, or the body is on a link that is fixed to the
   world and the other one is an obstacle.
5. checking/unreachable_pairs.py: lever arms prove that the bodies can't meet at any configuration within the limits.
6. checking/pair_proofs.py: no joint of the group moves one body against the other, and they are apart.
7. checking/compiled_tables.py: what 5 and 6 prove takes effect: configurations within the limits are judged by a table
   without these pairs, those beyond by the table of all pairs.
8. cpp/checking/checker.cpp: both bodies are static, so that one test decides for every configuration.
9. cpp/broad_phase: cells of one or two joints (checking/apart_cells.py) or bounds show that the bodies are apart at the
   configuration, or, where any collision decides, another pair collides already.

1 to 4 define the verdict; 5 to 9 save work and never change it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from plannercheck.checking.state_checker import StateChecker

# The first places of the list define the verdict.
_DEFINING = 4


class LeftOut(NamedTuple):
    """The pairs that one place leaves out.

    Attributes:
        where: The file or folder.
        why: The reason, in a few words.
        defines: Whether it decides what a verdict is about; else it saves work and changes no verdict.
        number: How many pairs it leaves out; None where another place counts them, or where the number depends on the
            configuration.
        left: How many pairs remain.
    """

    where: str
    why: str
    defines: bool
    number: int | None
    left: int


def left_out_pairs(checker: StateChecker) -> tuple[LeftOut, ...]:
    """What each place leaves out of a checker's pairs, in the order of the module's list."""
    checker = checker.with_all_columns
    robot, obstacles = checker.robot, len(checker.scene.bodies)
    own = sum(body.carried is None for body in robot.bodies)
    carried = len(robot.bodies) - own
    is_own = (robot.self_pairs < own).all(axis=1)
    disabled, apart, static = _disabled_pairs(checker), checker.unreachable, checker.static
    compiled = checker._tables.within_limits
    of_robot = own * (own - 1) // 2
    of_carried = carried * own + carried * (carried - 1) // 2
    of_obstacles = len(robot.bodies) * obstacles
    numbers: list[tuple[str, str, int | None]] = [
        ("robots/description.py", "disabled by the robot's YAML", disabled),
        (
            "robots/self_pairs.py",
            "on one joint, or disabled by the SRDF, or neighbours where there is no SRDF",
            of_robot - disabled - int(is_own.sum()),
        ),
        (
            "robots/carried_objects.py",
            "carried objects and the links that may touch them",
            of_carried - int((~is_own).sum()),
        ),
        (
            "checking/pair_table.py",
            "allowed by the scene or the SRDF, or both fixed to the world",
            len(robot.self_pairs) + of_obstacles - len(checker.pairs),
        ),
        ("checking/unreachable_pairs.py", "never meet within the joint limits, by proof", int((apart & ~static).sum())),
        (
            "checking/pair_proofs.py",
            "no joint moves one against the other, and they are apart",
            int((apart & static).sum()),
        ),
        ("checking/compiled_tables.py", "both of these, within the limits", None),
        ("cpp/checking/checker.cpp", "neither ever moves, so one test decides", int(compiled.is_still.sum())),
        ("cpp/broad_phase", "far apart at a configuration", None),
    ]
    left = of_robot + of_carried + of_obstacles
    found = []
    for k, (where, why, number) in enumerate(numbers):
        left -= number or 0
        found.append(LeftOut(where, why, k < _DEFINING, number, left))
    return tuple(found)


def _disabled_pairs(checker: StateChecker) -> int:
    """How many pairs of the robot's own bodies its YAML disables."""
    links = np.array([body.link for body in checker.robot.bodies if body.carried is None], dtype=object)
    named = {frozenset((pair.link_a, pair.link_b)) for pair in checker.robot.disabled_pairs}
    counts = {link: int((links == link).sum()) for link in {link for pair in named for link in pair}}
    return sum(counts[a] * counts[b] for a, b in (sorted(pair) for pair in named if len(pair) == 2))
