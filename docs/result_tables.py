"""What each table of figures shows, in Markdown, from docs/results.

In: the name of a file of results. Out: text for `render_results.py`, under each table the command, the date, the commit
and the machine that its figures come from.
"""

from __future__ import annotations

import json
import textwrap
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "docs" / "results"
WIDTH = 120

Record = dict[str, Any]
Row = dict[str, Any]


def record(name: str) -> Record:
    """A file of results."""
    found: Record = json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))
    return found


# ----- parts of pages


def table(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table in Markdown."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "".join(f"| {' | '.join(map(str, line))} |\n" for line in lines)


def paragraph(text: str) -> str:
    """Text in lines of the usual length."""
    return textwrap.fill(text, WIDTH, break_long_words=False, break_on_hyphens=False) + "\n"


def provenance(found: Record) -> str:
    """What was run, when, at which commit, on what."""
    machine = found["machine"]
    load = machine["load"]
    shared = ", which other work shared" if load and float(load) > 1.2 else ""
    return paragraph(
        f"`{found['command']}`, {found['date']}, commit {found['commit']}: {machine['processor']}, "
        f"{machine['processors']} processors (load {load}{shared}), instruction set {machine['instruction set']}."
    )


def older(found: Record) -> str:
    """Figures that a page stated before, as it stated them."""
    head = f"*Stated in {found['source']} at commit {found['commit']}, {found['date']}. {found['machine']}.*"
    parts = [paragraph(head)]
    for block in found["blocks"]:
        if "columns" in block:
            parts.append(table(block["columns"], block["rows"]))
        elif "list" in block:
            parts.append("".join(f"- {item}\n" for item in block["list"]))
        else:
            parts.append(paragraph(block["text"]))
    return "\n".join(parts)


def number(value: float | None) -> str:
    """Two digits that count, or all before the point."""
    if value is None:
        return "–"
    if value == 0 or abs(value) >= 100:
        return f"{value:,.0f}"
    text = f"{value:.2g}"
    return f"{float(text):g}" if "e" in text else text


def times(value: float, ours: float) -> str:
    """A time, and how many times ours it is."""
    return f"{number(value)} ({number(value / ours)} ×)"


# ----- tables of results

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
            *(number(1e3 * states[name]["preparation"]) for name in (OURS, TREE, FCL)),
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
    listed = "".join(f"- {provenance(record(name))}" for name in names)
    return listed + f"- {record('older/vamp')['note']}\n"


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
    spent = {(row["robot"], row["scene"], row["method"]): row["preparation"] for row in rows}
    cases = list(dict.fromkeys((row["robot"], row["scene"]) for row in rows))
    header = ("ms", "ours", "coal", "FCL")
    return table(
        header,
        [
            (f"{robot}, {scene}", *(milliseconds(spent.get((robot, scene, name))) for name in (OURS, TREE, FCL)))
            for robot, scene in cases
        ],
    )


def milliseconds(seconds: float | None) -> str:
    """Seconds in ms."""
    return number(None if seconds is None else 1e3 * seconds)


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


def motions_cost() -> str:
    """A proved motion beside our own check of 32 states, and how it grows as the clearance shrinks."""
    found = record("motions_cost")
    compared = [row for row in found["rows"] if "which" in row]
    grown = [row for row in found["rows"] if "clearance" in row]
    first = table(
        ("scene", "motions", "proved, µs", "32 states, µs", "ratio"),
        [
            (
                row["scene"],
                f"{row['motions']} ({row['which']})",
                number(row["ours"]),
                number(row["sampled"]),
                f"{row['ours'] / row['sampled']:.2f}",
            )
            for row in compared
        ],
    )
    second = table(
        ("clearance, mm", "proved, µs", "32 states, µs"),
        [(f"{1e3 * row['clearance']:g}", number(row["ours"]), number(row["sampled"])) for row in grown],
    )
    return first + "\n" + second + "\n" + provenance(found)


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


def changing_scenes() -> str:
    """CPU ms of a changed scene."""
    found = record("changing_scenes")
    columns = list(found["rows"][0])
    return table(columns, [[row[name] for name in columns] for row in found["rows"]]) + "\n" + provenance(found)


def hierarchies() -> str:
    """Vertex blocks visited, worst of 1,000 queries, and the cost of preparation."""
    found = record("hierarchies")
    counted = [row for row in found["rows"] if row["family"] != "preparation"]
    first = table(
        (
            "bodies",
            "vertices",
            "levels: hull",
            "polar",
            "blocks a query: hull",
            "polar",
            "walk: blocks",
            "rounds",
            "games",
        ),
        [
            (
                row["family"],
                f"{row['vertices']:,}",
                *(row[name] for name in ("hull_levels", "polar_levels", "hull_blocks", "polar_blocks")),
                *(row[name] for name in ("walk_blocks", "walk_rounds", "walk_games")),
            )
            for row in counted
        ],
    )
    return first + "\n" + provenance(found)


def preparation() -> str:
    """What preparing a body takes."""
    found = record("hierarchies")
    lines = [
        (
            f"{row['vertices']:,}",
            number(row["microseconds_a_vertex"]),
            number(row["hull_given"]),
            number(row["bytes_a_vertex"]),
        )
        for row in found["rows"]
        if row["family"] == "preparation"
    ]
    header = ("vertices", "µs a vertex", "with the hull given", "bytes a vertex")
    return table(header, lines) + "\n" + provenance(found)


def complexity() -> str:
    """Visited vertices and rounds, worst and mean, by method."""
    found = record("complexity")
    lines = [
        (
            row["where"],
            row["family"],
            row["method"],
            f"{row['vertices']:,}",
            number(row["rounds_mean"]),
            row["rounds_worst"],
            f"{row['visited_mean']:,.0f}",
            f"{row['visited_worst']:,}",
        )
        for row in found["rows"]
    ]
    header = ("where", "bodies", "method", "vertices", "rounds: mean", "worst", "visited: mean", "worst")
    return table(header, lines) + "\n" + provenance(found)


def stages() -> str:
    """Which stage decides, and the mean time of what it decides."""
    found = record("stages")
    kinds = list(dict.fromkeys(row["kind"] for row in found["rows"]))
    names = list(dict.fromkeys(row["stage"] for row in found["rows"]))
    by_both = {(row["kind"], row["stage"]): row for row in found["rows"]}
    timed = [kind for kind in kinds if any(by_both[kind, name]["microseconds"] for name in names)]
    header = ["stage"]
    for kind in kinds:
        header += [kind, "µs"] if kind in timed else [kind]
    lines = []
    for name in names:
        cells = [name]
        for kind in kinds:
            row = by_both[kind, name]
            cells.append(f"{row['percent']:.1f} %")
            if kind in timed:
                cells.append(number(row["microseconds"]))
        lines.append(cells)
    return table(header, lines) + "\n" + provenance(found)


def planar() -> str:
    """Rounds and time of the algorithm in the plane, and beside shapely."""
    found = record("planar")
    grown = [row for row in found["rows"] if "rounds_worst" in row]
    beside = [row for row in found["rows"] if "shapely_ns" in row]
    first = table(
        ("vertices", "gap", "rounds: mean", "worst", "vertices read: mean", "worst", "ns"),
        [
            (
                f"{row['vertices']:,}",
                f"±{row['gap']:g}",
                f"{row['rounds_mean']:.1f}",
                row["rounds_worst"],
                f"{row['read_mean']:.0f}",
                row["read_worst"],
                number(row["nanoseconds"]),
            )
            for row in grown
        ],
    )
    second = table(
        (
            "vertices",
            "gap",
            "ours at poses, ns",
            "ours from arrays, ns",
            "shapely, prepared, ns",
            "verdicts that differ",
        ),
        [
            (
                f"{row['vertices']:,}",
                f"±{row['gap']:g}",
                number(row["poses_ns"]),
                number(row["arrays_ns"]),
                times(row["shapely_ns"], row["poses_ns"]),
                row["differ"],
            )
            for row in beside
        ],
    )
    return first + "\n" + second + "\n" + provenance(found)


def clearance() -> str:
    """Nanoseconds a distance, beside coal's."""
    found = record("clearance")
    lines = [
        (f"{row['vertices']:,}", f"{row['gap']:g}", number(row["ours"]), times(row["coal"], row["ours"]))
        for row in found["rows"]
    ]
    return table(("vertices", "gap, radii", "ours, ns", "coal, ns"), lines) + "\n" + provenance(found)


def switches() -> str:
    """What each way of skipping work brings."""
    found = record("switches")
    lines = [(row["states"], row["off"], number(row["microseconds"]), f"{row['ratio']:.2f}") for row in found["rows"]]
    return table(("states", "off", "µs a state", "×"), lines) + "\n" + provenance(found)


def scale() -> str:
    """Scenes of many boxes."""
    found = record("scale")
    lines = [
        (f"{row['boxes']:,}", f"{row['pairs']:,}", number(row["microseconds"]), f"{row['preparation']:.2f}")
        for row in found["rows"]
    ]
    return table(("boxes", "pairs", "µs a state", "prepared, s"), lines) + "\n" + provenance(found)


TABLES: dict[str, Callable[[], str]] = {
    make.__name__: make
    for make in (
        *(overview, overview_sources, states, set_up, motions, motions_cost, plans, pairs, changing_scenes),
        *(hierarchies, preparation, complexity, stages, planar, clearance, switches, scale),
    )
}
