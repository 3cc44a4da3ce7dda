"""Tables of figures beside other libraries, in Markdown, from docs/results.

In: files of results. Out: text for `render_results.py`, under each table the command, the date, the commit and the
machine that its figures come from. A library that answers one call at a time stands beside our single calls.
"""

from __future__ import annotations

from statistics import median
from typing import Any

from result_markdown import beside, number, provenance, record, table, times

Row = dict[str, Any]

OURS, ONE_BY_ONE = "plannercheck, batch", "plannercheck, one by one"
TREE, FCL = "Pinocchio + coal, AABB tree, tolerance 1e-06", "python-fcl"
AT_BEST, MOTION_TREE, VAMP = "coal at its best", "Pinocchio + coal, AABB tree", "VAMP, in C++"
STATE_FILES = ("states_panda", "states_ur5", "states_baxter", "states_talos")
RRT = "RRTConnect, range 0.5 rad"
PAIR_METHODS = {"plannercheck, oracle": "ours", "plannercheck, walk": "the paper's walk"}
PAIR_METHODS |= {"plannercheck, intersects from Python": "ours from Python", AT_BEST: AT_BEST}
PAIR_METHODS |= {FCL: "FCL from Python", "MuJoCo, mj_geomDistance": "MuJoCo from Python"}


def summary() -> str:
    """README's table: µs on two machines, ours and how many times as long the others take."""
    return table(("", "AVX2 (AMD)", "AVX-512 (Intel)"), _lines())


def _lines() -> list[tuple[str, str, str]]:
    """What is measured, and a cell a machine."""
    random, along = (chosen("states_panda", scene="bookshelf", which=which) for which in ("random", "along motions"))
    motions = chosen("motions", kind=RRT)
    newer = {(row["case"], row["which"], row["method"]): row for row in record("avx512")["rows"]}
    shelf, driven = "panda, bookshelf", (RRT, "motion")
    return [
        ("random state, in a batch, µs", _cell(random, OURS, coal=AT_BEST, FCL=FCL), _newer(newer, shelf, "random")),
        ("random state, a call each, µs", _cell(random, ONE_BY_ONE, VAMP=VAMP), _newer(newer, shelf, "random", True)),
        (
            "state along motions, in a batch, µs",
            _cell(along, OURS, coal=AT_BEST, FCL=FCL),
            _newer(newer, shelf, "along motions"),
        ),
        (
            "state along motions, a call each, µs",
            _cell(along, ONE_BY_ONE, VAMP=VAMP),
            _newer(newer, shelf, "along motions", True),
        ),
        ("motion of RRTConnect, in a batch, µs", _cell(motions, OURS, coal=AT_BEST, FCL=FCL), _newer(newer, *driven)),
        ("motion of RRTConnect, a call each, µs", _cell(motions, ONE_BY_ONE, VAMP=VAMP), _newer(newer, *driven, True)),
        *_longer(newer),
    ]


def _longer(newer: dict[tuple[str, str, str], Row]) -> list[tuple[str, str, str]]:
    """Searches and set-up."""
    plans = {row["planner"]: row for row in record("plans")["rows"] if row["set"] == "all"}
    searched = {name: {"spent": row["median_ms"]} for name, row in plans.items()}
    steps = {
        row["what"]: {"spent": sum(row[name] or 0 for name in _WAITED)}
        for row in record("setup_panda")["rows"]
        if row["scene"] == "bookshelf"
    }
    tree, spheres = "Pinocchio + coal: geometry and AABB tree", "VAMP: its environment"
    files, shelf = median(row["total"] for row in record("from_files")["rows"]), "panda, bookshelf"
    ready = newer[shelf, "checker until the first proved motion", "plannercheck"]["microseconds"]
    return [
        (
            "search by RRTConnect, median, ms",
            _cell(searched, "plannercheck", coal="Pinocchio + coal", VAMP="VAMP"),
            _searches(newer),
        ),
        (
            "checker, until the first proved motion, ms",
            _cell(steps, "Checker(...)", coal=tree, VAMP=spheres),
            number(1e-3 * ready),
        ),
        (
            "scene file and request to a proved path, ms",
            number(files),
            number(1e-3 * newer[shelf, _FILES, "plannercheck"]["microseconds"]),
        ),
    ]


def _searches(newer: dict[tuple[str, str, str], Row]) -> str:
    """The least and the largest median of the problem sets."""
    ours, coal = (
        [
            1e-3 * newer[case, _SEARCH, who]["microseconds"]
            for case, which, name in newer
            if which == _SEARCH and name == who
        ]
        for who in ("plannercheck", "coal")
    )
    ratios = [theirs / mine for mine, theirs in zip(ours, coal, strict=True)]
    return f"{number(min(ours))} to {number(max(ours))}; coal {number(min(ratios))} to {number(max(ratios))} ×"


_SEARCH, _FILES = "search, median", "scene file and request to a proved path"


_WAITED = ("milliseconds", "first_verdict", "first_motion")


def _cell(rows: dict[str, Row], ours: str, **peers: str) -> str:
    """Our time, then each library with its time over ours; bold where the library is faster."""
    spent = {name: row.get("spent", row.get("microseconds")) for name, row in rows.items()}
    return "; ".join([number(spent[ours]), *(_ratio(name, spent[row] / spent[ours]) for name, row in peers.items())])


def _ratio(name: str, ratio: float) -> str:
    return f"**{name} {number(ratio)} ×**" if ratio < 1 else f"{name} {number(ratio)} ×"


def _newer(rows: dict[tuple[str, str, str], Row], case: str, which: str, single: bool = False) -> str:
    """The cell of the second machine, on which VAMP could not be built; its ratios are those of the unrounded times."""
    mine = number(rows[case, which, ONE_BY_ONE if single else OURS]["microseconds"])
    return mine if single else f"{mine}; {_ratio('coal', rows[case, which, AT_BEST]['ratio'])}"


def chosen(name: str, **wanted: str) -> dict[str, Row]:
    """Rows of a record with some values, by method; where there are several, the first."""
    rows = record(name)["rows"]
    found = [row for row in rows if all(row[key] == value for key, value in wanted.items())]
    return {row["method"]: row for row in reversed(found)}


def states() -> str:
    """µs a state by method, a row for each robot, scene and kind of states."""
    rows = [row for name in STATE_FILES for row in record(name)["rows"]]
    cases = dict.fromkeys((row["which"], row["robot"], row["scene"], row["pairs"]) for row in rows)
    spent = {(row["which"], row["robot"], row["scene"], row["method"]): row["microseconds"] for row in rows}
    lines = []
    for which, robot, scene, pairs in sorted(cases, key=lambda case: case[0] != "random"):
        if scene == "cage":
            continue
        here = {method: spent.get((which, robot, scene, method)) for method in _METHODS}
        own = [number(here[method]) for method in (OURS, ONE_BY_ONE)]
        others = [_beside(here[method], here[_METHODS[method]]) for method in (AT_BEST, FCL, VAMP)]
        lines.append((which, f"{robot}, {scene} ({pairs:,})", *own, *others))
    header = ("states", "robot, scene (pairs)", "batch", "a call each")
    header += ("coal at its best", "FCL", "VAMP, a call each")
    return table(header, lines) + "\n" + provenance(record(STATE_FILES[0]))


# What each method stands beside.
_METHODS = {OURS: OURS, ONE_BY_ONE: OURS, AT_BEST: OURS, FCL: OURS, VAMP: ONE_BY_ONE}


def _beside(value: float | None, ours: float | None) -> str:
    return "–" if value is None or ours is None else beside(value, ours)


def pairs() -> str:
    """µs a pair, by vertices and gap."""
    found = record("pairs")
    spent = {(row["vertices"], row["gap"], row["method"]): row["microseconds"] for row in found["rows"]}
    lines = []
    for vertices, gap in dict.fromkeys((row["vertices"], row["gap"]) for row in found["rows"]):
        if vertices not in _SIZES or (gap > 0.1 and vertices > 8):
            continue
        ours, walk, called, coal, *python = (spent[vertices, gap, name] for name in PAIR_METHODS)
        cells = (number(ours), times(walk, ours), number(called), _beside(coal, ours))
        lines.append((f"{vertices:,}", f"{gap:+g}", *cells, *(_beside(value, called) for value in python)))
    return table(("vertices", "gap", *PAIR_METHODS.values()), lines) + "\n" + provenance(found)


_SIZES = (8, 150, 10_000)
