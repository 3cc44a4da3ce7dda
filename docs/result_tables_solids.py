"""Tables of figures on solids, in Markdown, from docs/results.

In: files of results. Out: text for `render_results.py`, under each table the command, the date, the commit and the
machine that its figures come from.
"""

from __future__ import annotations

from typing import Any

from result_markdown import beside, items, number, provenance, ratio, record, source, table, times
from result_tables import ALL_PAIRS, AT_BEST, ONE_BY_ONE, OURS, TREE

Row = dict[str, Any]

_STATE_FILES = (
    *("states_solid_ur3", "states_solid_ur5", "states_solid_ur10", "states_solid_pr2"),
    *("states_solid_baxter", "states_solid_talos", "states_solid_xarm7", "states_solid_panda"),
)
HULLS = "plannercheck, hulls"
_METHODS = {OURS: "ours", HULLS: "ours, of hulls", ONE_BY_ONE: "ours, one by one", AT_BEST: AT_BEST}
_METHODS |= {TREE: "Pinocchio + coal, AABB tree", ALL_PAIRS: "Pinocchio + coal, all pairs"}


def solid_states() -> str:
    """µs a random state by method, a row a robot, and how verdicts differ."""
    found = [record(name) for name in _STATE_FILES]
    lines, verdicts = [], []
    for each in found:
        rows = {row["method"]: row for row in each["rows"]}
        ours = rows[OURS]["microseconds"]
        cells = [times(ours, rows[HULLS]["microseconds"])]
        for name in list(_METHODS)[1:]:
            value = None if name not in rows else rows[name]["microseconds"]
            cells.append("–" if value is None else beside(value, ours) if "coal" in name else number(value))
        lines.append([f"{rows[OURS]['robot']} ({rows[OURS]['pairs']:,} pairs)", *cells])
        verdicts.append([rows[OURS]["robot"], *_differences(rows)])
    first = table(("µs a state", "ours (× that of hulls)", *list(_METHODS.values())[1:]), lines)
    header = ("robot", "coal's", "free, but colliding, %", "of them inside", "colliding, but free, %")
    return f"{first}\n{table(header, verdicts)}\n{items(source(each) for each in found)}"


def _differences(rows: dict[str, Row]) -> list[str]:
    """Of the way of coal that judged most states."""
    coals = [row for row in rows.values() if row["kind"].startswith("coal")]
    most = max(coals, key=lambda row: row["states"])
    return [
        f"{most['states']:,} states",
        *(number(100 * most[field]) for field in ("false_free", "false_free_inside", "false_collision")),
    ]


def solid_link_pairs() -> str:
    """µs a pair of links' meshes whose hulls meet, a row a robot."""
    found = record("solid_link_pairs")
    lines = []
    for robot in dict.fromkeys(row["robot"] for row in found["rows"]):
        rows = [row for row in found["rows"] if row["robot"] == robot]
        groups = (rows, [row for row in rows if row["meet"]], [row for row in rows if not row["meet"]])
        queries = sum(row["queries"] for row in rows)
        counts = [sum(row[field] for row in rows) for field in ("inside", "false_free", "false_collision")]
        lines.append((robot, f"{queries:,}", *(cell for group in groups for cell in _mean(group)), *counts))
    header = ("robot", "queries", "ours, µs", "coal", "meeting: ours", "coal", "apart: ours", "coal")
    counted = ("inside", "coal's false free", "false collisions")
    return table((*header, *counted), lines) + "\n" + provenance(found)


def _mean(rows: list[Row]) -> tuple[str, str]:
    queries = sum(row["queries"] for row in rows)
    if not queries:
        return "–", "–"
    ours, coal = (sum(row[field] * row["queries"] for row in rows) / queries for field in ("microseconds", "coal"))
    return number(ours), beside(coal, ours)


def solid_triangles() -> str:
    """µs a pair near contact, and what preparation takes, by number of triangles."""
    found = record("solid_triangles")
    lines = []
    for shape, triangles in dict.fromkeys((row["shape"], row["triangles"]) for row in found["rows"]):
        rows = [row for row in found["rows"] if (row["shape"], row["triangles"]) == (shape, triangles)]
        cells = []
        for gap in dict.fromkeys(row["gap"] for row in rows):
            spent = {row["method"]: row["microseconds"] for row in rows if row["gap"] == gap}
            ours, coal = spent["plannercheck"], spent.get(AT_BEST)
            cells += [number(ours), "–" if coal is None else beside(coal, ours)]
        for method in ("plannercheck", AT_BEST):
            costs = [(row["preparation"], row["bytes_a_triangle"]) for row in rows if row["method"] == method]
            cells += [f"{number(costs[0][0])} s, {number(costs[0][1])} B"] if costs else ["–"]
        lines.append((shape, f"{triangles:,}", *cells))
    gaps = [f"{gap:+g}" for gap in dict.fromkeys(row["gap"] for row in found["rows"])]
    header = [cell for gap in gaps for cell in (f"gap {gap}: ours, µs", "coal")]
    columns = ("shape", "triangles", *header, "prepared, and bytes a triangle: ours", "coal")
    return table(columns, lines) + "\n" + provenance(found)


def pieces() -> str:
    """Valid states and their cost by hulls, convex pieces and meshes, a row a robot."""
    found = record("pieces")
    robots: dict[str, dict[str, Row]] = {}
    for row in found["rows"]:
        robots.setdefault(row["robot"], {})[row["geometry"]] = row
    lines = []
    for robot, rows in robots.items():
        ways = [rows.get(way) for way in ("hulls", "pieces", "meshes")]
        shares = [_share(row, "valid") for row in ways]
        shares += [_share(row, "refused_by_filling") for row in ways[:2]]
        shares.append(_share(ways[1], "valid_but_meshes_collide"))
        lines.append((robot, *shares, *("–" if row is None else number(row["microseconds"]) for row in ways)))
    header = (
        "valid by hulls",
        "pieces",
        "meshes",
        "only hulls refuse",
        "pieces refuse, not meshes",
        "meshes, not pieces",
    )
    return table(("robot", *header, "µs by hulls", "pieces", "meshes"), lines) + "\n" + provenance(found)


def _share(row: Row | None, field: str) -> str:
    return "–" if row is None else f"{100 * row[field]:.1f} %"


def solid_costs() -> str:
    """µs by hulls and by solids of robots whose meshes are nearly convex, a row a robot and kind of work."""
    found = record("solid_costs")
    lines = [
        (
            f"{row['robot']} ({row['dented']} dented, {row['concave']} concave)",
            row["work"],
            *(number(row[field]) for field in ("of_hulls", "of_solids")),
            ratio(row, 3),
        )
        for row in found["rows"]
    ]
    return table(("robot", "µs each", "by hulls", "by solids", "×"), lines) + "\n" + provenance(found)


def solid_fidelity() -> str:
    """What hulls refuse that meshes would not, a row a robot, and where coal's surfaces disagree."""
    found = record("solid_fidelity")
    lines = [
        (
            row["robot"],
            row["geometry"],
            *(f"{100 * row[field]:.1f} %" for field in ("valid_hulls", "valid", "filling")),
            *(f"{row[field]:,}" for field in ("refused_by_both", "inside", "near", "refused_apart", "missed")),
        )
        for row in found["rows"]
    ]
    shares = ("valid by hulls", "valid by meshes", "only hulls refuse")
    counts = ("pairs refused by both", "inside", "near", "refused by ours alone", "by coal alone")
    return table(("robot", "meshes", *shares, *counts), lines) + "\n" + provenance(found)
