"""`plannercheck bench`: run time against error, beside other methods and libraries.

In: a subcommand and its options. Out: a table on the terminal and, with --output, JSON and plots in a folder.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

from plannercheck.bodies.tuning import tuning_table
from plannercheck.cli import bench_clouds, bench_planning, bench_solids
from plannercheck.cli.bench_options import (
    Subcommand,
    add_scenes,
    add_seed,
    add_states,
    checker_in,
    keep,
    note,
    positive,
    ratio_of,
    show,
    show_how,
    sizes,
)
from plannercheck.cli.robot_options import robot_of
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench import ablation, complexity, pairs, plots, states
from plannercheck.evaluation.bench import scene_size as scale
from plannercheck.evaluation.bench import tables as output
from plannercheck.evaluation.bench.ablation import SwitchRow
from plannercheck.evaluation.bench.complexity import ComplexityRow, GrowthRow
from plannercheck.evaluation.bench.methods import KINDS, methods
from plannercheck.evaluation.bench.motion_sets import along_motions
from plannercheck.evaluation.bench.pair_peers import COAL_AT_BEST
from plannercheck.evaluation.bench.pairs import PairRow
from plannercheck.evaluation.bench.scene_size import ScaleRow
from plannercheck.evaluation.bench.states import StateRow
from plannercheck.scenes.scene import Scene

_EPILOG = """\
Contenders take turns in one process (A B ... B A) and the least time of each counts: ratios hold on a loaded machine,
absolute times do not. Libraries that are not installed are left out with a note.

Examples:
  plannercheck bench states --robot panda --scene bookshelf cage --output results
  plannercheck bench states --robot talos --scene none --methods coal
  plannercheck bench states --robot ur10 --scene none --geometry solid
  plannercheck bench pairs --vertices 8,150,10000
  plannercheck bench motions --scene bookshelf --problems bookshelf_small_panda.tar.bz2
  plannercheck bench setup --robot panda --scene bookshelf
  plannercheck bench clouds --points 1000,100000
  plannercheck bench plans --problems cage_panda.tar.bz2 --every 10
"""
# What is asked for in `bench states`, as the peer's time over ours.
_ASKED = {"coal's tree / batch": 18, "coal's tree / one by one": 6, "all pairs / batch": 50}
_ASKED_WITHOUT_SCENE = {"coal's tree / batch": 15}
_ASKED_ALONG_MOTIONS = {"coal at its best / batch": 8, "coal at its best / one by one": 2}
_ASKED_OF_SOLIDS = {"the faster way of Pinocchio + coal / batch": 8}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the subcommands."""
    parser.epilog = _EPILOG
    subcommands = parser.add_subparsers(required=True, metavar="WHAT")
    for name, subcommand in SUBCOMMANDS.items():
        sub = subcommands.add_parser(name, help=subcommand.summary, description=subcommand.summary)
        subcommand.add_arguments(sub)
        if rounds := subcommand.rounds:
            sub.add_argument(
                "--rounds", type=positive, default=rounds, help=f"turns of each contender (default: {rounds})"
            )
        sub.add_argument("--output", type=Path, metavar="FOLDER", help="write JSON and plots there")
        sub.set_defaults(measure=subcommand.run)


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    output.make_output_folder(options.output)
    options.measure(options)
    return 0


def _add_states(parser: argparse.ArgumentParser) -> None:
    add_states(parser, 10_000)
    add_scenes(parser)
    parser.add_argument("--along-motions", action="store_true", help="states along motions as well, 64 a motion")
    parser.add_argument(
        "--methods", nargs="+", choices=KINDS, help="beside the exact ones (default: all that take the bodies)"
    )


def _add_pairs(parser: argparse.ArgumentParser) -> None:
    listed = ",".join(map(str, pairs.SIZES))
    parser.add_argument("--vertices", type=sizes, default=list(pairs.SIZES), help=f"of the bodies (default: {listed})")
    parser.add_argument("--pairs", type=positive, default=1000, help="of each kind (default: %(default)s)")
    parser.add_argument("--ellipsoids", action="store_true", help="points on ellipsoids 1 : 0.7 : 0.5, not on spheres")


def _add_switches(parser: argparse.ArgumentParser) -> None:
    add_states(parser, 10_000)
    parser.add_argument("--scene", default="bookshelf", help="name or file; none for no obstacles")


def _add_scale(parser: argparse.ArgumentParser) -> None:
    add_states(parser, 10_000)
    parser.add_argument("--boxes", type=sizes, default=[100, 10_000], help="in each scene (default: 100,10000)")


def _add_complexity(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--most", type=positive, default=10_000, help="vertices of a body (default: %(default)s)")
    parser.add_argument("--queries", type=positive, default=100, help="of each body and size (default: %(default)s)")
    add_seed(parser)


def _run_states(options: argparse.Namespace) -> None:
    rows: list[StateRow] = []
    for scene in options.scene:
        checker = checker_in(robot_of(options), scene)
        random = checker.robot.random_configurations(options.states, options.seed)
        kinds = {"random": random} | ({"along motions": along_motions(random)} if options.along_motions else {})
        for which, q in kinds.items():
            found = states.measure(checker, list(methods(checker, options.methods)), q, options.rounds, note, which)
            _print_states(found)
            rows += found
    keep(options.output, "states", rows, _draw_random)


def _draw_random(rows: Sequence[StateRow], path: Path) -> None:
    plots.time_against_error([row for row in rows if row.which == "random"], path)


def _print_states(rows: Sequence[StateRow]) -> None:
    first = rows[0]
    kind = "random states" if first.which == "random" else f"states {first.which}"
    counts = f"{first.pairs} pairs, {first.states} {kind}, {first.valid:.0%} valid"
    print(f"\n{first.robot} in {first.scene}: {counts}")
    columns: dict[str, Callable[[StateRow], object]] = {
        "method": lambda row: row.method,
        "µs a state": lambda row: f"{row.microseconds:.2f}",
        "x": ratio_of,
        "false free %": lambda row: f"{100 * row.false_free:.3f}",
        "inside %": lambda row: "-" if row.false_free_inside is None else f"{100 * row.false_free_inside:.3f}",
        "false coll. %": lambda row: f"{100 * row.false_collision:.3f}",
        "error mm": lambda row: output.number(None if row.error is None else 1e3 * row.error),
        "kB": lambda row: output.size_of(row.resident),
        "prepared s": lambda row: f"{row.preparation:.2f}",
        "states": lambda row: row.states,
    }
    if first.false_free_inside is None:
        del columns["inside %"]
    show(rows, columns)
    if first.false_free_inside is not None:
        print("inside: false free since nothing but one body inside another collides; coal's meshes are surfaces")
    show_how(rows)
    for name, ratio, asked in _asked(rows):
        print(f"{name}: {ratio:.1f} times (asked for: {asked})")


def _asked(rows: Sequence[StateRow]) -> list[tuple[str, float, int]]:
    """What is asked for of coal's time over ours: what, measured, asked."""
    spent = {row.method: row.microseconds for row in rows}
    coal = [row for row in rows if row.kind == "coal" and row.error == 1e-6]
    tree = next((row.microseconds for row in coal if "tree" in row.method), None)
    every = next((row.microseconds for row in coal if "all pairs" in row.method), None)
    best, faster = spent.get(COAL_AT_BEST), min((row.microseconds for row in coal), default=None)
    batch, single = (spent.get(f"plannercheck, {name}") for name in ("batch", "one by one"))
    measured = {
        "coal's tree / batch": (tree, batch),
        "coal's tree / one by one": (tree, single),
        "all pairs / batch": (every, batch),
        "coal at its best / batch": (best, batch),
        "coal at its best / one by one": (best, single),
        "the faster way of Pinocchio + coal / batch": (faster, batch),
    }
    asked = _ASKED_ALONG_MOTIONS if rows[0].which != "random" else _ASKED_WITHOUT_SCENE
    asked = _ASKED if rows[0].which == "random" and rows[0].scene != "empty" else asked
    asked = asked if rows[0].false_free_inside is None else _ASKED_OF_SOLIDS
    return [
        (name, theirs / ours, asked[name])
        for name, (theirs, ours) in measured.items()
        if name in asked and theirs is not None and ours is not None
    ]


def _run_pairs(options: argparse.Namespace) -> None:
    if min(options.vertices) < 4:
        raise PlannercheckError("--vertices must be at least 4 each")
    rows = pairs.measure(options.vertices, options.pairs, options.rounds, note, options.ellipsoids)
    columns: dict[str, Callable[[PairRow], object]] = {
        "vertices": lambda row: row.vertices,
        "gap": lambda row: f"{row.gap:+g}",
        "method": lambda row: row.method,
        "µs a pair": lambda row: f"{row.microseconds:.3f}",
        "coal's time over it": lambda row: output.ratio(row.coal_ratio, row.noise),
        "asked for": lambda row: "-" if row.asked is None else row.asked,
        "wrong": lambda row: row.wrong,
        "of": lambda row: row.pairs,
    }
    show(rows, columns)
    show_how(rows)
    for method in dict.fromkeys(row.method for row in rows):
        grown = pairs.growth(rows, method)
        if grown is not None:
            print(f"{method}: near contact, from 150 to {max(options.vertices)} vertices time grows {grown:.1f}-fold")
    keep(options.output, "pairs", rows, plots.time_against_vertices)


def _run_switches(options: argparse.Namespace) -> None:
    robot = robot_of(options)
    scene = Scene("empty") if options.scene == "none" else Scene.load(options.scene)
    rows: list[SwitchRow] = ablation.measure(robot, scene, options.states, options.rounds, options.seed)
    purposes = {row.name: row.purpose for row in tuning_table()}
    columns: dict[str, Callable[[SwitchRow], object]] = {
        "states": lambda row: row.states,
        "off": lambda row: row.off,
        "µs a state": lambda row: f"{row.microseconds:.2f}",
        "x": ratio_of,
        "wrong": lambda row: row.wrong,
        "what it does": lambda row: purposes.get(row.off, ""),
    }
    show(rows, columns)
    keep(options.output, "switches", rows)


def _run_scale(options: argparse.Namespace) -> None:
    rows = scale.measure(robot_of(options), options.boxes, options.states, options.rounds, options.seed)
    columns: dict[str, Callable[[ScaleRow], object]] = {
        "boxes": lambda row: row.boxes,
        "pairs": lambda row: row.pairs,
        "µs a state": lambda row: f"{row.microseconds:.2f}",
        "x": ratio_of,
        f"µs a motion of {scale.LENGTH:g} rad": lambda row: f"{row.motion_microseconds:.2f}",
        "x of motions": lambda row: output.ratio(row.motion_ratio, row.noise),
        "prepared s": lambda row: f"{row.preparation:.2f}",
        "kB": lambda row: output.size_of(row.resident),
        "bodies kB": lambda row: output.size_of(row.prepared),
        "bytes a vertex": lambda row: f"{row.bytes_a_vertex:.0f}",
        "process kB": lambda row: output.size_of(row.process),
    }
    show(rows, columns)
    print(f"asked for: at most {scale.ASKED:g} times the first")
    keep(options.output, "scale", rows)


def _run_complexity(options: argparse.Namespace) -> None:
    if options.most < min(complexity.SIZES):
        raise PlannercheckError(f"--most must be at least {min(complexity.SIZES)}")
    rows = list(complexity.measure(options.most, options.queries, options.seed, note))
    counted: dict[str, Callable[[ComplexityRow], object]] = {
        "where": lambda row: row.where,
        "bodies": lambda row: row.family,
        "method": lambda row: row.method,
        "vertices": lambda row: row.vertices,
        "rounds: mean": lambda row: f"{row.rounds_mean:.1f}",
        "worst": lambda row: row.rounds_worst,
        "visited: mean": lambda row: f"{row.visited_mean:.0f}",
        "worst visited": lambda row: row.visited_worst,
        "shared": lambda row: f"{row.shared} of {row.queries}",
    }
    show(rows, counted)
    grown = complexity.growth(rows)
    if grown:
        print(
            "\nvisited vertices a doubling of n adds (mean); exponents of a power law through the means and the worst"
        )
        columns: dict[str, Callable[[GrowthRow], object]] = {
            "where": lambda row: row.where,
            "bodies": lambda row: row.family,
            "method": lambda row: row.method,
            "a doubling": lambda row: f"{row.per_doubling:.1f}",
            "exponent": lambda row: f"{row.exponent:.2f}",
            "of the worst": lambda row: f"{row.exponent_worst:.2f}",
        }
        show(grown, columns)
        keep(options.output, "complexity_growth", grown)
    keep(options.output, "complexity", rows, plots.visited_against_vertices)


# A further measurement is a further entry.
SUBCOMMANDS = {
    "states": Subcommand("run time against error on states of a robot in scenes", _add_states, _run_states),
    "pairs": Subcommand("time a pair of bodies against their vertices", _add_pairs, _run_pairs, 31),
    **bench_planning.SUBCOMMANDS,
    **bench_solids.SUBCOMMANDS,
    **bench_clouds.SUBCOMMANDS,
    "switches": Subcommand("what each stage of a check brings", _add_switches, _run_switches),
    "scale": Subcommand("a scene of 10,000 boxes against one of 100; memory", _add_scale, _run_scale),
    "complexity": Subcommand("rounds and visited vertices against n", _add_complexity, _run_complexity, 0),
}
