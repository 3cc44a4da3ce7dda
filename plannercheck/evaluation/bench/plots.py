"""Plots of measurements as PNG and SVG: time against error, time against vertices, any count against a size.

In: rows. Out: two files beside each other. matplotlib is an extra (`pip install 'plannercheck[bench]'`) and is imported
when a plot is drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.optional_imports import extra_module
from plannercheck.evaluation.bench.complexity import ComplexityRow
from plannercheck.evaluation.bench.pairs import GAPS, PairRow
from plannercheck.evaluation.bench.states import StateRow

_SUFFIXES = (".png", ".svg")
# Errors below this, in mm, are drawn between it and 0: a tenth of coal's tolerance.
_LINEAR_BELOW = 1e-4
# Shares of wrong states below this, in per cent, likewise.
_LINEAR_BELOW_SHARE = 1e-2

# Marker, colour, whether points are joined, legend.
_STYLES: Mapping[str, tuple[str, str, bool, str]] = {
    "exact": ("*", "#d43d2f", False, "plannercheck (exact)"),
    "hulls": ("p", "#8c8c3b", False, "hulls of solids"),
    "inner": ("v", "#3b76af", True, "hierarchy cut off: inner bodies"),
    "outer": ("^", "#519e3e", True, "hierarchy cut off: outer bodies"),
    "spheres": ("o", "#ef8636", True, "bounding spheres"),
    "capsules": ("P", "#8d69b8", False, "bounding capsules"),
    "boxes": ("s", "#84584e", False, "bounding boxes"),
    "coal": ("D", "#555555", False, "Pinocchio + coal"),
    "coal loop": ("d", "#999999", False, "coal at its best"),
    "fcl": ("X", "#111111", False, "python-fcl"),
    "vamp": ("h", "#2a9d8f", False, "VAMP"),
}


def time_against_error(rows: Sequence[StateRow], path: Path) -> list[Path]:
    """Draws time a state against the geometric error, and against the share of wrong states, scene by scene.

    The path is without a suffix; the files are returned.
    """
    cases = list(dict.fromkeys((row.robot, row.scene) for row in rows))
    figure = _figure(5.2 * len(cases), 8.4)
    axes = figure.subplots(2, len(cases), squeeze=False)
    for column, case in enumerate(cases):
        chosen = [row for row in rows if (row.robot, row.scene) == case]
        _draw_states(axes[0, column], chosen, lambda row: None if row.error is None else 1e3 * row.error)
        _draw_states(axes[1, column], chosen, lambda row: 100 * (row.false_free + row.false_collision))
        axes[0, column].set(title=f"{case[0]} in {case[1]}", xlabel="largest geometric error (mm); coal: its tolerance")
        axes[1, column].set(xlabel="wrong states (%)")
        for axis, smallest in ((axes[0, column], _LINEAR_BELOW), (axes[1, column], _LINEAR_BELOW_SHARE)):
            axis.set_xscale("symlog", linthresh=smallest)
            axis.set_xlim(-smallest / 2, 2 * axis.get_xlim()[1])
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize="small")
    return _saved(figure, path)


def _draw_states(axes: Any, rows: Sequence[StateRow], across: Callable[[StateRow], float | None]) -> None:
    """Points by kind; one whose error is unknown is a line across."""
    axes.set(yscale="log", ylabel="time a state (µs)")
    axes.grid(True, which="major", alpha=0.3)
    for kind, (marker, colour, joined, label) in _STYLES.items():
        points = sorted((x, row.microseconds) for row in rows if row.kind == kind and (x := across(row)) is not None)
        for row in (row for row in rows if row.kind == kind and across(row) is None):
            axes.axhline(row.microseconds, color=colour, linestyle=":", label=f"{label} (error unknown)")
        if points:
            line = "-" if joined else "none"
            axes.plot(*zip(*points, strict=True), marker=marker, color=colour, linestyle=line, label=label)


def time_against_vertices(rows: Sequence[PairRow], path: Path) -> list[Path]:
    """Draws time a pair against the vertices of bodies, a panel a gap; path and files as of `time_against_error`."""
    series: dict[str, dict[str, list[tuple[float, float]]]] = {_gap_title(gap): {} for gap in GAPS}
    for row in rows:
        series[_gap_title(row.gap)].setdefault(row.method, []).append((row.vertices, row.microseconds))
    return against_size({"time a pair (µs)": series}, "vertices of each body", path)


def _gap_title(gap: float) -> str:
    return f"gap {100 * gap:+g} % of the size"


# Panels of the plot of visited vertices: where, bodies, title.
_COMPLEXITY_PANELS = (
    ("space", "round", "space: round bodies"),
    ("space", "doubling", "space: degree doubling"),
    ("plane", "crowded", "plane: crowded vertices"),
    ("trees, d = 3", "round", "trees, d = 3: round bodies"),
)


def visited_against_vertices(rows: Sequence[ComplexityRow], path: Path) -> list[Path]:
    """Draws the worst query's visited vertices and rounds against n, a column an algorithm, one more for hard bodies.

    Path and files as of `time_against_error`.
    """
    counts: Mapping[str, Callable[[ComplexityRow], float]] = {
        "visited vertices, worst query": lambda row: row.visited_worst,
        "rounds, worst query": lambda row: row.rounds_worst,
    }
    return against_size({up: _panels(rows, count) for up, count in counts.items()}, "vertices of each body", path)


def _panels(
    rows: Sequence[ComplexityRow], count: Callable[[ComplexityRow], float]
) -> dict[str, dict[str, list[tuple[float, float]]]]:
    """Curves of the four panels, less what takes a single round."""
    series: dict[str, dict[str, list[tuple[float, float]]]] = {title: {} for _, _, title in _COMPLEXITY_PANELS}
    for where, family, title in _COMPLEXITY_PANELS:
        for row in rows:
            if (row.where, row.family) == (where, family) and count(row) > 1:
                series[title].setdefault(row.method, []).append((row.vertices, count(row)))
    return series


def against_size(
    rows: Mapping[str, Mapping[str, Mapping[str, Sequence[tuple[float, float]]]]], across: str, path: Path
) -> list[Path]:
    """Draws curves on logarithmic axes into files: a row for each quantity, panels side by side, a colour a name.

    By label of the y axis, then title, then name, curves are points (x, y), both positive; `across` is the label of the
    x axis. The path is without suffix.
    """
    columns = len(next(iter(rows.values())))
    figure = _figure(4.6 * columns, 4.4 * len(rows))
    grid = figure.subplots(len(rows), columns, squeeze=False, sharey="row", sharex="col")
    names = list(dict.fromkeys(name for panels in rows.values() for curves in panels.values() for name in curves))
    for row, (up, panels) in enumerate(rows.items()):
        grid[row, 0].set_ylabel(up)
        for column, (title, curves) in enumerate(panels.items()):
            axis = grid[row, column]
            axis.set(title="" if row else title, xscale="log", yscale="log")
            axis.grid(True, which="major", alpha=0.3)
            for name, points in curves.items():
                colour = f"C{names.index(name)}"
                axis.plot(*zip(*points, strict=True), marker="o", markersize=4, label=name, color=colour)
            if row == 0 and (column == 0 or not curves.keys() <= panels[next(iter(panels))].keys()):
                axis.legend(fontsize="small")
    for axis in grid[-1]:
        axis.set_xlabel(across)
    return _saved(figure, path)


def _figure(width: float, height: float) -> Any:
    """An empty figure of a size in inches."""
    Figure = extra_module("matplotlib.figure", "bench", "plots").Figure
    return Figure(figsize=(width, height), layout="constrained")


def _saved(figure: Any, path: Path) -> list[Path]:
    files = [path.with_suffix(suffix) for suffix in _SUFFIXES]
    for file in files:
        write_atomically(file, partial(figure.savefig, dpi=110, format=file.suffix[1:]))
    return files
