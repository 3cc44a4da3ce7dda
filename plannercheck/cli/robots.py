"""`plannercheck robots`: the shipped robots, or given ones, in a table."""

from __future__ import annotations

import argparse

from plannercheck import planar
from plannercheck.cli.common import table
from plannercheck.cli.robot_options import ROBOT_HELP
from plannercheck.motions.checker import Checker
from plannercheck.planar.robot_files import is_planar, shipped_planar
from plannercheck.robots.description import shipped_robots
from plannercheck.robots.robot import Robot

_EPILOG = """\
Links and bodies are those with collision geometry; hull vertices those of all bodies that some self pair
needs; pairs are the self pairs of bodies that are tested. The first run prepares all bodies (some seconds),
later ones find them in the cache.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's options."""
    parser.epilog = _EPILOG
    parser.add_argument("robots", nargs="*", metavar="ROBOT", help=f"each {ROBOT_HELP}; default: all shipped")


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    rows = [_row(name) for name in options.robots or [*shipped_robots(), *shipped_planar("robots")]]
    print(table(("robot", "group", "joints", "links", "bodies", "hull vertices", "self pairs"), rows))
    return 0


def _row(name: str) -> tuple[object, ...]:
    if is_planar(name, "robots"):
        return _planar_row(name)
    robot = Robot.load(name)
    checker = Checker(robot)
    links = len({body.link for body in robot.bodies})
    vertices = sum(len(polytope.vertices) for polytope in checker.polytopes if polytope is not None)
    group = robot.group or "(all joints)"
    return robot.name, group, len(robot.joint_names), links, len(robot.bodies), vertices, len(checker.pairs)


def _planar_row(name: str) -> tuple[object, ...]:
    robot = planar.Robot.load(name)
    vertices = sum(len(body.vertices) for body in robot.bodies)
    numbers = robot.name, "(planar)", len(robot.joint_names), len(robot.links), len(robot.bodies), vertices
    return *numbers, len(robot.self_pairs())
