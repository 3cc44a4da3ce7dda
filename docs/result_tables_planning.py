"""Tables of what planners and their users wait for, in Markdown, from docs/results: motions, plans, set-up.

In: files of results, written by `plannercheck bench motions`, `plans` and `setup`, and by
tests/benchmarks/plan_sampling.py. Out: text for `render_results.py`, under each table the command, the date, the commit
and the machine that its figures come from.
"""

from __future__ import annotations

from typing import Any

from result_markdown import beside, faster, number, provenance, record, table

Row = dict[str, Any]

OURS = "plannercheck, batch"
SET_UPS = ("setup_panda", "setup_ur5", "setup_baxter", "setup_pr2", "setup_talos")


def motions() -> str:
    """µs a motion, ours proved, the peers' sampled; a column for each kind of motions."""
    found = record("motions")
    rows = found["rows"]
    kinds = list(dict.fromkeys((row["where"], row["kind"]) for row in rows))
    by_method = {(row["where"], row["kind"], row["method"]): row for row in rows}
    names = list(dict.fromkeys(row["method"] for row in rows))
    lines = [[name, *(_motion_cell(by_method, *kind, name) for kind in kinds)] for name in names]
    wrong = [[name, *(_wrong_cell(by_method, *kind, name) for kind in kinds)] for name in names if _is_peer(name)]
    heads = [f"{where}: {kind}" for where, kind in kinds]
    peers = [row for row in rows if _is_peer(row["method"])]
    told = faster((row["method"], f"{row['where']}, {row['kind']}", row["ratio"]) for row in peers)
    return (
        table(["µs a motion", *heads], lines)
        + f"\n{told}\n"
        + table(["false free %, false colliding %", *heads], wrong)
        + "\n"
        + provenance(found)
    )


def _is_peer(name: str) -> bool:
    return not name.startswith("plannercheck")


def _motion_cell(rows: dict[tuple[str, str, str], Row], where: str, kind: str, name: str) -> str:
    row, ours = rows.get((where, kind, name)), rows[where, kind, OURS]
    if row is None:
        return "–"
    return beside(row["microseconds"], ours["microseconds"]) if _is_peer(name) else number(row["microseconds"])


def _wrong_cell(rows: dict[tuple[str, str, str], Row], where: str, kind: str, name: str) -> str:
    row = rows.get((where, kind, name))
    return "–" if row is None else f"{number(100 * row['false_free'])}, {number(100 * row['false_collision'])}"


def plans() -> str:
    """Searches of RRTConnect: ours proved, coal's sampled as OMPL samples by default, VAMP's own."""
    found = record("plans")
    by_planner = {(row["set"], row["planner"]): row for row in found["rows"]}
    ours = {row["set"]: row for row in found["rows"] if row["planner"] == "plannercheck"}
    lines = []
    for (name, planner), row in by_planner.items():
        mine = ours[name]
        show = (lambda value, other: number(value)) if row is mine else beside
        call = "–" if row["call_median_ms"] is None else show(row["call_median_ms"], mine["call_median_ms"])
        lines.append(
            (
                name,
                planner,
                show(row["median_ms"], mine["median_ms"]),
                show(row["mean_ms"], mine["mean_ms"]),
                call,
                f"{row['solved']} of {row['tried']}",
                f"{row['colliding']} of {row['solved']}",
                number(row["deepest_median_mm"]),
                number(row["deepest_mm"]),
            )
        )
    told = faster(
        (planner, name, row["median_ms"] / ours[name]["median_ms"]) for (name, planner), row in by_planner.items()
    )
    header = ("set", "planner", "median ms", "mean ms", "whole call, median ms", "solved", "plans that collide")
    return table((*header, "deepest, median mm", "at most"), lines) + f"\n{told}\n" + provenance(found)


def plan_sampling() -> str:
    """Searches that sample everywhere, and near start and goal first, with several ranges; a column for each set."""
    found = record("plan_sampling")
    rows = {(row["sampling"], row["range"], row["set"]): row for row in found["rows"]}
    sets = list(dict.fromkeys(name for _, _, name in rows))
    settings = list(dict.fromkeys(key[:2] for key in rows))
    fields = ("median_ms", "mean_ms", "shortened")
    lines = [
        [samples, number(longest)]
        + [", ".join(number(rows[samples, longest, name][field]) for field in fields) for name in sets]
        for samples, longest in settings
    ]
    solved = [
        [samples, number(longest)]
        + [f"{row['solved']} of {row['tried']}" for name in sets for row in [rows[samples, longest, name]]]
        for samples, longest in settings
    ]
    heads = [name.removesuffix("_panda") for name in sets]
    return (
        table(["samples", "range, rad", *heads], lines)
        + "\n"
        + table(["solved: samples", "range, rad", *heads], solved)
        + "\n"
        + provenance(found)
    )


def waiting() -> str:
    """Milliseconds of each step until the first proved motion; a column for each robot and scene."""
    files = {name: record(name) for name in SET_UPS}
    rows = [row for found in files.values() for row in found["rows"]]
    cases = list(dict.fromkeys((row["robot"], row["scene"]) for row in rows))
    cells = {(row["robot"], row["scene"], row["what"]): _waited(row) for row in rows}
    lines = [
        [what, *(cells.get((*case, what), "–") for case in cases)]
        for what in dict.fromkeys(row["what"] for row in rows)
    ]
    header = ["ms: step + first verdict + first motion", *(f"{robot}, {scene}" for robot, scene in cases)]
    return table(header, lines) + "".join("\n" + provenance(found) for found in files.values())


def _waited(row: Row) -> str:
    parts = [row["milliseconds"], row["first_verdict"], row["first_motion"]]
    return " + ".join(number(part) for part in parts if part is not None)


def from_files() -> str:
    """Milliseconds from a planning-scene file and a request to a proved path."""
    found = record("from_files")
    lines = [
        (row["set"], f"{row['solved']} of {row['problems']}", *(number(row[name]) for name in _STEPS))
        for row in found["rows"]
    ]
    header = ("set", "solved", "read", "checker", "plan", "all, median ms", "mean")
    return table(header, lines) + "\n" + provenance(found)


_STEPS = ("read", "checker", "plan", "total", "total_mean")


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
    return table(header, lines) + "".join("\n" + provenance(found) for found in files.values())
