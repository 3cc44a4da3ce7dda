"""`plannercheck bench fidelity`, `solid-costs`, `link-pairs`, `triangles`: solids against hulls and coal's meshes.

In: options. Out: tables on the terminal and, with --output, JSON and a plot in a folder.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import median

from plannercheck.cli.bench_options import Subcommand, add_seed, keep, note, positive, ratio_of, show, sizes
from plannercheck.cli.common import table
from plannercheck.cli.robot_options import ROBOT_HELP
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench import fidelity, link_pairs, plots, solid_costs, solid_sizes
from plannercheck.evaluation.bench import tables as output
from plannercheck.evaluation.bench.fidelity import FidelityRow
from plannercheck.evaluation.bench.link_pairs import LinkPairRow, mean
from plannercheck.evaluation.bench.solid_checkers import checker_of_meshes
from plannercheck.evaluation.bench.solid_costs import SolidCostRow
from plannercheck.evaluation.bench.solid_sizes import SolidSizeRow
from plannercheck.evaluation.bench.tables import number

_ROBOTS = ("ur3", "ur5", "ur10", "pr2", "baxter", "talos", "xarm7", "panda")
_ALL_ROBOTS = (*_ROBOTS, "g1", "tiago", "kinova", "go2")
# Robots whose meshes are convex, or nearly so.
_CONVEX_ROBOTS = ("panda", "go2", "talos")
# Bodies have four triangles at least.
_FEWEST = 100


def _add_robots(parser: argparse.ArgumentParser, default: Sequence[str], states: int) -> None:
    listed = ", ".join(default)
    parser.add_argument("--robot", nargs="+", default=list(default), help=f"{ROBOT_HELP} (default: {listed})")
    parser.add_argument("--states", type=positive, default=states, help="uniformly random (default: %(default)s)")
    add_seed(parser)


def _add_fidelity(parser: argparse.ArgumentParser) -> None:
    _add_robots(parser, _ALL_ROBOTS, 20_000)


def _add_solid_costs(parser: argparse.ArgumentParser) -> None:
    _add_robots(parser, _CONVEX_ROBOTS, 4000)


def _add_link_pairs(parser: argparse.ArgumentParser) -> None:
    _add_robots(parser, _ROBOTS, 2000)
    parser.add_argument("--most", type=positive, default=200, help="queries of a pair at most (default: %(default)s)")


def _add_triangles(parser: argparse.ArgumentParser) -> None:
    listed = ",".join(map(str, solid_sizes.SIZES))
    parser.add_argument(
        "--triangles", type=sizes, default=list(solid_sizes.SIZES), help=f"of the bodies (default: {listed})"
    )
    parser.add_argument(
        "--shapes", nargs="+", choices=solid_sizes.SHAPES, default=list(solid_sizes.SHAPES), help="default: all"
    )
    parser.add_argument("--pairs", type=positive, default=200, help="of each kind (default: %(default)s)")


def _run_fidelity(options: argparse.Namespace) -> None:
    rows: list[FidelityRow] = []
    for robot in options.robot:
        found = fidelity.measure(robot, options.states, options.seed)
        _print_fidelity(found)
        rows += found
    keep(options.output, "solid_fidelity", rows)


def _print_fidelity(rows: Sequence[FidelityRow]) -> None:
    first = rows[0]
    print(f"\n{first.robot}: {first.states} random states, {first.open_meshes} open meshes")
    columns: dict[str, Callable[[FidelityRow], object]] = {
        "geometry": lambda row: row.geometry,
        "concave": lambda row: row.solids,
        "valid by hulls %": lambda row: f"{100 * row.valid_hulls:.2f}",
        "valid %": lambda row: f"{100 * row.valid:.2f}",
        "only hulls refuse %": lambda row: f"{100 * row.filling:.2f}",
        "refused by both": lambda row: row.refused_by_both,
        "inside": lambda row: row.inside,
        "near": lambda row: row.near,
        "refused, apart": lambda row: row.refused_apart,
        "missed": lambda row: row.missed,
    }
    show(rows, columns)
    print(
        "counts are pairs in states on which ours and coal's surfaces differ: one body inside the other; nearer than "
        f"{fidelity.NEAR:g} m to contact; refused by us alone; free for us alone",
        flush=True,
    )


def _run_solid_costs(options: argparse.Namespace) -> None:
    rows: list[SolidCostRow] = []
    for robot in options.robot:
        note(robot)
        rows += solid_costs.measure(robot, options.states, options.seed, options.rounds)
    columns: dict[str, Callable[[SolidCostRow], object]] = {
        "robot": lambda row: row.robot,
        "µs each": lambda row: row.work,
        "by hulls": lambda row: number(row.of_hulls),
        "by solids": lambda row: number(row.of_solids),
        "x": ratio_of,
        "verdicts differ": lambda row: row.differ,
        "dented": lambda row: row.dented,
        "deepest": lambda row: f"{row.deepest:.1e}",
        "concave": lambda row: row.concave,
    }
    show(rows, columns)
    keep(options.output, "solid_costs", rows)


def _run_link_pairs(options: argparse.Namespace) -> None:
    rows: list[LinkPairRow] = []
    for robot in options.robot:
        checker = checker_of_meshes(robot)
        q = checker.robot.random_configurations(options.states, options.seed)
        found = link_pairs.measure(checker, q, options.most, options.rounds, note)
        _print_link_pairs(robot, found)
        rows += found
    keep(options.output, "solid_link_pairs", rows)


def _print_link_pairs(robot: str, rows: Sequence[LinkPairRow]) -> None:
    print(
        f"\n{robot}: {len({(row.first, row.second) for row in rows})} pairs of links whose hulls meet, not all convex"
    )
    header = ("verdict", "queries", "µs a query", "coal's µs", "x", "asked for", "inside", "false free", "false coll.")
    groups = {
        "all": list(rows),
        "meet": [row for row in rows if row.meet],
        "apart": [row for row in rows if not row.meet],
    }
    print(table(header, [_verdict_cells(name, group) for name, group in groups.items() if group]))
    ratios = [row.coal / row.microseconds for row in rows if row.coal is not None]
    if ratios:
        print(f"coal's time over ours, by pair: median {median(ratios):.1f}, least {min(ratios):.1f}")
    of_pair = ("pair", "triangles", "verdict", "queries", "µs a query", "coal's µs", "x")
    most = sorted(rows, key=lambda row: -row.microseconds * row.queries)[:6]
    print("where our time goes:")
    print(table(of_pair, [_pair_cells(row) for row in most]))
    print(output.null_control(rows), flush=True)


def _verdict_cells(name: str, rows: Sequence[LinkPairRow]) -> tuple[object, ...]:
    ours, coal = mean(rows, lambda row: row.microseconds), mean(rows, lambda row: row.coal)
    assert ours is not None
    counts = (sum(getattr(row, field) for row in rows) for field in ("inside", "false_free", "false_collision"))
    ratio = output.ratio(None if coal is None else coal / ours, max(row.noise for row in rows))
    return name, sum(row.queries for row in rows), number(ours), number(coal), ratio, link_pairs.ASKED, *counts


def _pair_cells(row: LinkPairRow) -> tuple[object, ...]:
    ratio = output.ratio(None if row.coal is None else row.coal / row.microseconds, row.noise)
    names, triangles = f"{row.first} / {row.second}", " / ".join(map(str, row.triangles))
    verdict = "meet" if row.meet else "apart"
    return names, triangles, verdict, row.queries, number(row.microseconds), number(row.coal), ratio


def _run_triangles(options: argparse.Namespace) -> None:
    if min(options.triangles) < _FEWEST:
        raise PlannercheckError(f"--triangles must be at least {_FEWEST} each")
    rows = solid_sizes.measure(options.triangles, options.shapes, options.pairs, options.rounds, note)
    columns: dict[str, Callable[[SolidSizeRow], object]] = {
        "shape": lambda row: row.shape,
        "triangles": lambda row: row.triangles,
        "gap": lambda row: f"{row.gap:+g}",
        "method": lambda row: row.method,
        "µs a pair": lambda row: number(row.microseconds),
        "x": ratio_of,
        "meet %": lambda row: f"{100 * row.meet:.0f}",
        "differ": lambda row: row.wrong,
        "pairs": lambda row: row.pairs,
        "prepared s": lambda row: number(row.preparation),
        "its hull s": lambda row: number(row.of_hull),
        "bytes a triangle": lambda row: "-" if row.bytes_a_triangle is None else f"{row.bytes_a_triangle:.0f}",
    }
    show(rows, columns)
    for shape, gap, method in dict.fromkeys((row.shape, row.gap, row.method) for row in rows):
        grown = solid_sizes.growth(rows, shape, gap, method)
        if grown is not None:
            print(f"{shape}, gap {gap:+g}, {method}: time grows {grown:.1f}-fold (asked for: {solid_sizes.ASKED})")
    keep(options.output, "solid_triangles", rows, _draw_triangles)


def _draw_triangles(rows: Sequence[SolidSizeRow], path: Path) -> None:
    series: dict[str, dict[str, list[tuple[float, float]]]] = {}
    for row in rows:
        curves = series.setdefault(f"{row.shape}, gap {row.gap:+g}", {})
        curves.setdefault(row.method, []).append((row.triangles, row.microseconds))
    plots.against_size({"time a pair (µs)": series}, "triangles of each body", path)


SUBCOMMANDS = {
    "fidelity": Subcommand(
        "what hulls refuse that meshes would not; solids against coal", _add_fidelity, _run_fidelity, 0
    ),
    "solid-costs": Subcommand("robots' meshes as they are against their hulls", _add_solid_costs, _run_solid_costs, 25),
    "link-pairs": Subcommand("pairs of links' meshes whose hulls meet", _add_link_pairs, _run_link_pairs, 7),
    "triangles": Subcommand("solids near contact, and their preparation", _add_triangles, _run_triangles, 7),
}
