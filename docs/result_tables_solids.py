"""Tables of figures on solids, in Markdown, from docs/results.

In: files of results. Out: text for `render_results.py`, under each table the command, the date, the commit and the
machine that its figures come from.
"""

from __future__ import annotations

from typing import Any

from result_markdown import beside, number, paragraph, provenance, record, table, times
from result_tables import AT_BEST, ONE_BY_ONE, OURS, TREE

Row = dict[str, Any]

_ROBOTS = ("states_solid_ur3", "states_solid_ur5", "states_solid_ur10", "states_solid_pr2")
_ROBOTS += ("states_solid_baxter", "states_solid_talos", "states_solid_xarm7", "states_solid_panda")
HULLS = "plannercheck, hulls"


def solid_states() -> str:
    """µs a random state by method, a row a robot, and how verdicts differ."""
    files = [record(name) for name in _ROBOTS]
    lines = []
    for found in files:
        rows = {row["method"]: row for row in found["rows"]}
        ours, hulls, single = (rows[name]["microseconds"] for name in (OURS, HULLS, ONE_BY_ONE))
        coal = [beside(rows[name]["microseconds"], ours) for name in (AT_BEST, TREE)]
        lines.append(
            (f"{rows[OURS]['robot']} ({rows[OURS]['pairs']:,} pairs)", times(ours, hulls), number(single), *coal)
        )
    header = ("µs a state", "ours, in a batch (× that of hulls)", "a call each", AT_BEST, "Pinocchio + coal")
    return f"{table(header, lines)}\n{provenance(files[0])}"


def pieces() -> str:
    """Valid states and their cost by hulls, convex pieces and meshes, a row a robot."""
    found = record("pieces")
    robots: dict[str, dict[str, Row]] = {}
    for row in found["rows"]:
        robots.setdefault(row["robot"], {})[row["geometry"]] = row
    lines = []
    for robot, rows in robots.items():
        found_by = [rows.get(name) for name in ("hulls", "pieces", "meshes")]
        shares = [_share(row, "valid") for row in found_by]
        shares += [_share(row, "refused_by_filling") for row in found_by[:2]]
        shares.append(_share(found_by[1], "valid_but_meshes_collide"))
        lines.append((robot, *shares, *("–" if row is None else number(row["microseconds"]) for row in found_by)))
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


def solid_fidelity() -> str:
    """How often verdicts of solids differ from coal's on meshes, in one sentence."""
    found = record("solid_fidelity")
    rows = [row for row in found["rows"] if row["geometry"] == "all meshes"]
    total = {name: sum(row[name] for row in rows) for name in _COUNTED}
    said = (
        f"Of {total['refused_by_both'] + total['inside']:,} pairs that collide in random states of {len(rows)} robots, "
        f"coal misses {total['inside']:,} in which one body is inside the other. Otherwise verdicts differ in "
        f"{total['near']} pairs nearer than 0.1 mm to contact, and {total['refused_apart'] + total['missed']} others."
    )
    return paragraph(said) + "\n" + provenance(found)


_COUNTED = ("refused_by_both", "inside", "near", "refused_apart", "missed")
