"""What the subcommands of `plannercheck bench` share: options, the checker they ask for, notes, and files of results.

In: parsed options, rows. Out: checkers; JSON and plots in a folder.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from plannercheck.bodies.half_spaces import HalfSpace
from plannercheck.bodies.part_sets import PartSet
from plannercheck.cli.common import table_of
from plannercheck.cli.robot_options import ROBOT_HELP, add_urdf_arguments
from plannercheck.common.errors import PlannercheckError, with_article
from plannercheck.common.package_data import is_folder
from plannercheck.evaluation.bench import tables as output
from plannercheck.evaluation.bench.pair_peers import COAL_AT_BEST
from plannercheck.evaluation.bench.problems import checker_of
from plannercheck.evaluation.bench.records import write_record
from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot
from plannercheck.scenes.motion_bench_maker import load_problems
from plannercheck.scenes.scene import Scene


class Subcommand(NamedTuple):
    """One measurement.

    Attributes:
        summary: For the help.
        add_arguments: Adds its options, beyond those that all have.
        run: Measures, and prints.
        rounds: Turns of each contender by default; more where work is so short that the machine may be slow for all of
            a few rounds; 0 if nothing takes turns.
    """

    summary: str
    add_arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], None]
    rounds: int = 11


def positive(text: str) -> int:
    """A whole number of at least 1."""
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} is not at least 1")
    return value


def sizes(text: str) -> list[int]:
    """Whole numbers of at least 1, separated by commas."""
    return [positive(part) for part in text.split(",")]


def positive_number(text: str) -> float:
    """A finite number above 0."""
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not a number above 0")
    return value


def add_robot(parser: argparse.ArgumentParser) -> None:
    """Adds --robot and what belongs to it."""
    parser.add_argument("--robot", default="panda", help=f"{ROBOT_HELP} (default: %(default)s)")
    add_urdf_arguments(parser)


def add_seed(parser: argparse.ArgumentParser) -> None:
    """Adds --seed."""
    parser.add_argument("--seed", type=int, default=0, help="seed of the random numbers (default: %(default)s)")


def add_states(parser: argparse.ArgumentParser, states: int) -> None:
    """Adds the robot, and how many random states it takes."""
    add_robot(parser)
    parser.add_argument("--states", type=positive, default=states, help="uniformly random (default: %(default)s)")
    add_seed(parser)


def add_scenes(parser: argparse.ArgumentParser) -> None:
    """Adds --scene, with several values."""
    parser.add_argument(
        "--scene",
        nargs="+",
        default=["bookshelf"],
        help="names, files, or sets of MotionBenchMaker problems (their first scene); none for no obstacles",
    )


def add_problems(parser: argparse.ArgumentParser, note: str, required: bool = False) -> None:
    """Adds --problems, as `plannercheck plan` has it, and which of them are taken."""
    parser.add_argument(
        "--problems",
        nargs="+",
        type=Path,
        default=[],
        required=required,
        metavar="SET",
        help=f"folders or tar archives of MotionBenchMaker problems{note}",
    )
    parser.add_argument("--every", type=positive, default=1, metavar="N", help="take every N-th problem of a set")
    parser.add_argument("--first", type=positive, metavar="N", help="at most N problems of each set")


def note(text: str) -> None:
    """Tells what was left out."""
    print(f"plannercheck: note: {text}", file=sys.stderr, flush=True)


def show_how(rows: Sequence[Any]) -> None:
    """Says how coal was asked where it is at its best, once for each way."""
    for text in dict.fromkeys(row.note for row in rows if row.method == COAL_AT_BEST):
        print(f"{COAL_AT_BEST}: {text}")


def show(rows: Sequence[Any], columns: Mapping[str, Callable[[Any], object]]) -> None:
    """Prints rows as a table, and the null control of those that have one."""
    print(table_of(rows, columns), flush=True)
    if rows and hasattr(rows[0], "noise"):
        print(output.null_control(rows), flush=True)


def ratio_of(row: Any) -> str:
    """The cell of a row's ratio."""
    return output.ratio(row.ratio, row.noise)


def checker_in(loaded: Robot, scene: str) -> Checker:
    """The checker in a scene by name or file, in the first of a problem set, or in none."""
    if scene == "none":
        return Checker(loaded)
    path = Path(scene)
    if is_folder(path) or ".tar" in path.suffixes:
        return checker_of(next(iter(load_problems(path))), loaded)
    checker = Checker(loaded, Scene.load(scene))
    _refuse_sets(checker)
    return checker


def _refuse_sets(checker: Checker) -> None:
    """Raises if what stands in for a body, here or in a library, would be another body."""
    for body in checker.bodies:
        if isinstance(body.shape, PartSet | HalfSpace):
            kind = with_article(type(body.shape).__name__)
            raise PlannercheckError(
                f"others are compared on hulls and meshes, and {body.label} is {kind}: "
                "`bench clouds` and `bench maps` have scenes of clouds and grids"
            )


def keep(
    folder: Path | None, name: str, rows: Sequence[Any], draw: Callable[[Sequence[Any], Path], object] | None = None
) -> None:
    """Writes the rows and, if they have one, their plot."""
    if folder is None or not rows:
        return
    write_record(folder / f"{name}.json", rows)
    try:
        if draw is not None:
            draw(rows, folder / name)
    except PlannercheckError as error:
        note(str(error))
