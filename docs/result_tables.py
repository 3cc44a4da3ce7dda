"""Tables of figures beside other libraries, in Markdown, from docs/results.

In: files of results. Out: text for `render_results.py`, under each table the command, the date, the commit and the
machine that its figures come from.
"""

from __future__ import annotations

from typing import Any

from result_markdown import items, number, provenance, record, source, table, times

Row = dict[str, Any]

OURS, ONE_BY_ONE = "plannercheck, batch", "plannercheck, one by one"
TREE, ALL_PAIRS, FCL = (
    "Pinocchio + coal, AABB tree, tolerance 1e-06",
    "Pinocchio + coal, all pairs, tolerance 1e-06",
    "python-fcl",
)
PAIR_METHODS = {"plannercheck, oracle": "ours", "plannercheck, walk": "the paper's walk"}
PAIR_METHODS |= {"coal, C++ loop": "coal", "python-fcl": "FCL"}


def overview() -> str:
    """One table of all that matters: ours, coal, FCL, VAMP."""
    states, motions = chosen("states_panda", scene="bookshelf"), chosen("motions_against_peers", scene="bookshelf")
    pairs = {row["method"]: row for row in record("pairs")["rows"] if row["vertices"] == 150 and row["gap"] == 1e-4}
    plans = {row["side"]: row for row in record("plans")["rows"] if row["set"] == "all"}
    vamp = {row["what"]: row["vamp"] for row in record("older/vamp")["rows"]}
    every = states[OURS]["pairs"]
    lines = [
        (f"a state of a Panda in a bookshelf ({every} pairs), µs", *three(states, "microseconds"), vamp["state"]),
        (
            "a motion of 1 rad there, µs: ours proved, theirs 32 states",
            *three(motions, "microseconds", "coal, AABB tree"),
            vamp["motion"],
        ),
        (
            "a plan by RRTConnect, median of a search, ms",
            number(plans["ours"]["median_ms"]),
            times(plans["peer"]["median_ms"], plans["ours"]["median_ms"]),
            "–",
            vamp["plan"],
        ),
        (
            "a pair of hulls of 150 vertices near contact, µs",
            *three(pairs, "microseconds", "coal, C++ loop", "plannercheck, oracle"),
            "–",
        ),
        (
            "set-up of robot and scene, nothing cached, ms",
            *prepared(list(states.values())),
            "–",
        ),
    ]
    return table(("", "ours", "coal", "FCL", "VAMP"), lines)


def three(rows: dict[str, Row], field: str, coal: str = TREE, ours: str = OURS) -> tuple[str, str, str]:
    """Ours, coal's and FCL's."""
    mine = rows[ours][field]
    return number(mine), times(rows[coal][field], mine), times(rows[FCL][field], mine)


def chosen(name: str, **wanted: str) -> dict[str, Row]:
    """Rows of a record with some values, by method."""
    rows = record(name)["rows"]
    return {row["method"]: row for row in rows if all(row[key] == value for key, value in wanted.items())}


def overview_sources() -> str:
    """Where the overview's figures come from."""
    names = ("states_panda", "motions_against_peers", "plans", "pairs")
    return items([*(source(record(name)) for name in names), record("older/vamp")["note"]])


def states() -> str:
    """µs a state, by method, a column for each robot and scene."""
    files = ("states_panda", "states_ur5", "states_baxter", "states_talos")
    rows = [row for name in files for row in record(name)["rows"]]
    cases = list(dict.fromkeys((row["robot"], row["scene"], row["pairs"]) for row in rows))
    spent = {(row["robot"], row["scene"], row["method"]): row["microseconds"] for row in rows}
    names = [OURS, ONE_BY_ONE, "plannercheck, OMPL callback", TREE, ALL_PAIRS, FCL]
    lines = []
    for name in names:
        cells = []
        for robot, scene, _ in cases:
            value, ours = spent.get((robot, scene, name)), spent[robot, scene, OURS]
            peer = not name.startswith("plannercheck")
            cells.append("–" if value is None else times(value, ours) if peer else number(value))
        lines.append([name.replace(", tolerance 1e-06", ""), *cells])
    header = ["µs a state", *(f"{robot}, {scene} ({pairs:,} pairs)" for robot, scene, pairs in cases)]
    return table(header, lines) + "".join("\n" + provenance(record(name)) for name in files)


def set_up() -> str:
    """Milliseconds until the first state can be judged, by library."""
    files = ("states_panda", "states_ur5", "states_baxter", "states_talos")
    rows = [row for name in files for row in record(name)["rows"]]
    cases = list(dict.fromkeys((row["robot"], row["scene"]) for row in rows))
    lines = []
    for robot, scene in cases:
        here = [row for row in rows if (row["robot"], row["scene"]) == (robot, scene)]
        lines.append((f"{robot}, {scene}", *prepared(here)))
    return table(("ms", "ours", "coal", "FCL"), lines)


def prepared(rows: list[Row]) -> tuple[str, ...]:
    """The least ms that ours, coal and FCL were prepared in: each is built once or several times in a run."""
    least = {kind: [row["preparation"] for row in rows if row["kind"] == kind] for kind in ("exact", "coal", "fcl")}
    return tuple(number(1e3 * min(seconds)) if seconds else "–" for seconds in least.values())


def motions() -> str:
    """µs a motion of 1 rad, ours proved, the peers' sampled."""
    found = record("motions_against_peers")
    ours = {row["scene"]: row["microseconds"] for row in found["rows"] if row["method"] == OURS}
    lines = [
        (
            row["scene"],
            row["method"],
            number(row["microseconds"])
            if row["method"].startswith("plannercheck")
            else times(row["microseconds"], ours[row["scene"]]),
            f"{row['differ']} of {row['motions']}",
        )
        for row in found["rows"]
    ]
    return table(("scene", "method", "µs a motion", "verdicts that differ"), lines) + "\n" + provenance(found)


def plans() -> str:
    """Searches of RRTConnect: ours proved, the peer's sampled as OMPL samples by default."""
    found = record("plans")
    sets = list(dict.fromkeys(row["set"] for row in found["rows"]))
    by_side = {(row["set"], row["side"]): row for row in found["rows"]}
    lines = []
    for name in sets:
        ours, peer = by_side[name, "ours"], by_side[name, "peer"]
        lines.append(
            (
                name,
                number(ours["median_ms"]),
                times(peer["median_ms"], ours["median_ms"]),
                number(ours["mean_ms"]),
                times(peer["mean_ms"], ours["mean_ms"]),
                f"{ours['solved']} of {ours['tried']}",
                f"{peer['solved']} of {peer['tried']}",
                f"{peer['colliding']} of {peer['solved']}",
            )
        )
    header = ("set", "median ms, ours", "peer", "mean ms, ours", "peer", "solved, ours", "peer", "peer's that collide")
    return table(header, lines) + "\n" + provenance(found)


def pairs() -> str:
    """µs a pair, by vertices and gap."""
    found = record("pairs")
    present = [name for name in PAIR_METHODS if any(row["method"] == name for row in found["rows"])]
    spent = {(row["vertices"], row["gap"], row["method"]): row["microseconds"] for row in found["rows"]}
    lines = []
    for vertices, gap in dict.fromkeys((row["vertices"], row["gap"]) for row in found["rows"]):
        ours = spent[vertices, gap, present[0]]
        cells = [number(ours)]
        for name in present[1:]:
            value = spent.get((vertices, gap, name))
            cells.append("–" if value is None else times(value, ours))
        lines.append((f"{vertices:,}", f"{gap:+g}", *cells))
    return table(("vertices", "gap", *(PAIR_METHODS[name] for name in present)), lines) + "\n" + provenance(found)
