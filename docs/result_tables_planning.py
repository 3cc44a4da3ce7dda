"""Tables of what planners and their users wait for, in Markdown, from docs/results: motions, plans, set-up.

In: files of results, written by `plannercheck bench motions`, `plans` and `setup`, and by plan_sampling.py and
rounded_plans.py of tests/benchmarks. Out: text for `render_results.py`, under each table the command, the date, the
commit and the machine that its figures come from.
"""

from __future__ import annotations

from typing import Any

from result_markdown import beside, number, provenance, record, table
from result_tables import AT_BEST, ONE_BY_ONE, OURS, VAMP

Row = dict[str, Any]

SET_UPS = ("setup_panda", "setup_ur5", "setup_baxter", "setup_pr2", "setup_talos")
_SHOWN = ("setup_panda", "setup_talos")


def motions() -> str:
    """µs a motion, ours proved, the peers' sampled; a row for each kind of motions."""
    found = record("motions")
    by_method = {(row["kind"], row["method"]): row for row in found["rows"]}
    lines = []
    for kind in dict.fromkeys(kind for kind, _ in by_method):
        here = {method: by_method.get((kind, method)) for method in _BESIDE}
        spent = {method: row and row["microseconds"] for method, row in here.items()}
        own = [number(spent[method]) for method in (OURS, ONE_BY_ONE)]
        others = [_beside(spent[method], spent[_BESIDE[method]]) for method in (VAMP, AT_BEST)]
        lines.append((kind, *own, *others, *(_false_free(here[method]) for method in (VAMP, AT_BEST))))
    header = ("motions", "batch", "a call each", "VAMP, a call each", "coal at its best")
    header += ("false free %: VAMP", "coal")
    return table(header, lines) + "\n" + provenance(found)


# What each method stands beside: VAMP answers a motion a call.
_BESIDE = {OURS: OURS, ONE_BY_ONE: OURS, VAMP: ONE_BY_ONE, AT_BEST: OURS}


def _beside(value: float | None, ours: float | None) -> str:
    return "–" if value is None or ours is None else beside(value, ours)


def _false_free(row: Row | None) -> str:
    return "–" if row is None else number(100 * row["false_free"])


def plans() -> str:
    """Searches of RRTConnect: ours proved, coal's sampled as OMPL samples by default, VAMP's own."""
    found = record("plans")
    rows = {(row["planner"], row["set"]): row for row in found["rows"]}
    sets = list(dict.fromkeys(name for _, name in rows))
    lines = []
    for planner in dict.fromkeys(planner for planner, _ in rows):
        all_sets = rows[planner, "all"]
        spent = [(rows[planner, name]["median_ms"], rows["plannercheck", name]["median_ms"]) for name in sets]
        cells = [number(value) if value == ours else beside(value, ours) for value, ours in spent]
        counts = f"{all_sets['solved']} of {all_sets['tried']}", f"{all_sets['colliding']} of {all_sets['solved']}"
        lines.append((planner, *cells, number(all_sets["call_median_ms"]), *counts, number(all_sets["deepest_mm"])))
    heads = (name.removesuffix("_panda") for name in sets)
    header = ("search, median ms", *heads, "whole call", "solved", "plans that collide", "deepest, mm")
    return table(header, lines) + "\n" + provenance(found)


def plan_sampling() -> str:
    """Searches that sample everywhere, and near start and goal first, at the default range; a column for each set."""
    found = record("plan_sampling")
    rows = {(row["sampling"], row["set"]): row for row in found["rows"] if row["range"] == 0.7}
    sets = list(dict.fromkeys(name for _, name in rows))
    lines = [
        [samples] + [", ".join(number(rows[samples, name][field]) for field in _SAMPLED) for name in sets]
        for samples in dict.fromkeys(samples for samples, _ in rows)
    ]
    return table(["samples", *(name.removesuffix("_panda") for name in sets)], lines) + "\n" + provenance(found)


_SAMPLED = ("median_ms", "mean_ms", "shortened")


def rounded_plans() -> str:
    """What becomes of plans that are executed with rounded corners, as splines, and timed; a row for each set."""
    found = record("rounded_plans")
    lines = []
    for row in found["rows"]:
        parts = [f"{100 * row[field] / row['plans']:.0f} %" for field in _EXECUTED]
        saved, cut, stops = f"{100 * row['saved']:.0f} %", row["cut"], row["stops"]
        lines.append((row["set"].replace("_panda", ", set"), row["plans"], *parts, saved, row["corners"], cut, stops))
    header = ("set", "plans", "rounded collides", "missed", "spline collides", "spline proved", "timed: proved")
    return table((*header, "time saved", "corners", "cut", "stops"), lines) + "\n" + provenance(found)


_EXECUTED = ("rounded_collide", "missed", "spline_collides", "spline_proved", "proved")


def waiting() -> str:
    """Milliseconds of each step with its first verdict and first proved motion; a column for each robot and scene."""
    files = [record(name) for name in _SHOWN]
    rows = [row for found in files for row in found["rows"]]
    cases = list(dict.fromkeys((row["robot"], row["scene"]) for row in rows))
    cells = {(row["robot"], row["scene"], row["what"]): number(_waited(row)) for row in rows}
    lines = [
        [what, *(cells.get((*case, what), "–") for case in cases)]
        for what in dict.fromkeys(row["what"] for row in rows)
        if what not in _UNSHOWN
    ]
    header = ["ms until the first proved motion", *(f"{robot}, {scene}" for robot, scene in cases)]
    return table(header, lines) + "\n" + provenance(files[0])


_UNSHOWN = ("fresh process: import pinocchio", "fresh process: Scene.load", "fresh process: Scene.load, nothing cached")
_UNSHOWN += ("fresh process: import, Robot.load, nothing cached", "fresh process: Checker(...), nothing cached")
_UNSHOWN += ("with_scene, one object gone", "with_scene while another is attached, one moved")


def _waited(row: Row) -> float:
    return sum(row[name] or 0 for name in ("milliseconds", "first_verdict", "first_motion"))


def changing_scenes() -> str:
    """CPU ms of a changed scene."""
    files = {name: record(name) for name in SET_UPS}
    steps = {
        "Checker(...)": "from scratch",
        "with_scene, one object moved": "moved",
        "with_scene, one box more": "added",
        "with_scene, one object gone": "gone",
        "attach": "attached",
        "with_scene while another is attached, one moved": "moved while attached",
    }
    lines = []
    for found in files.values():
        for robot, scene in dict.fromkeys((row["robot"], row["scene"]) for row in found["rows"]):
            here = {row["what"]: row for row in found["rows"] if (row["robot"], row["scene"]) == (robot, scene)}
            prepared = sum(row["prepared"] or 0 for row in here.values())
            spent = (number(here[what]["milliseconds"]) if what in here else "–" for what in steps)
            lines.append((robot, scene, f"{here['Checker(...)']['pairs']:,}", *spent, prepared))
    header = ("robot", "scene", "pairs", *steps.values(), "prepared")
    return table(header, lines) + "\n" + provenance(files["setup_panda"])
