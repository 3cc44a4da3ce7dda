"""`plannercheck robots`: the shipped robots, or given ones, in a table."""

from __future__ import annotations

import argparse

from plannercheck.checker import Checker
from plannercheck.commands.common import table
from plannercheck.robot import Robot
from plannercheck.robot_files import shipped_robots

_EPILOG = """\
Links and bodies are those with collision geometry; hull vertices those of all bodies that some self pair
needs; pairs are the self pairs of bodies that are tested. The first run prepares all bodies (some seconds),
later ones find them in the cache.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's options."""
    parser.epilog = _EPILOG
    parser.add_argument("robots", nargs="*", metavar="ROBOT", help="names or files; default: all shipped")


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    rows = [_row(name) for name in options.robots or shipped_robots()]
    print(table(("robot", "group", "joints", "links", "bodies", "hull vertices", "self pairs"), rows))
    return 0


def _row(name: str) -> tuple[object, ...]:
    robot = Robot.load(name)
    checker = Checker(robot)
    links = len({body.link for body in robot.bodies})
    vertices = sum(len(polytope.vertices) for polytope in checker.polytopes if polytope is not None)
    group = robot.group or "(all joints)"
    return robot.name, group, len(robot.joint_names), links, len(robot.bodies), vertices, len(checker.pairs)
