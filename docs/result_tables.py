"""Tables of figures beside other libraries, in Markdown, from docs/results.

In: files of results. Out: text for `render_results.py`, under each table the command, the date, the commit and the
machine that its figures come from.
"""

from __future__ import annotations

from statistics import median
from typing import Any

from result_markdown import beside, faster, items, number, paragraph, provenance, record, source, table, times

Row = dict[str, Any]
Faster = tuple[str, str, float]

OURS, ONE_BY_ONE = "plannercheck, batch", "plannercheck, one by one"
TREE, ALL_PAIRS, FCL = (
    "Pinocchio + coal, AABB tree, tolerance 1e-06",
    "Pinocchio + coal, all pairs, tolerance 1e-06",
    "python-fcl",
)
AT_BEST, MOTION_TREE = "coal at its best", "Pinocchio + coal, AABB tree"
VAMP, MUJOCO = "VAMP, in C++", "MuJoCo, mj_geomDistance"
FROM_PYTHON, IN_ONE_CALL = "plannercheck, intersects from Python", "plannercheck, intersects in one call"
PAIR_METHODS = {"plannercheck, oracle": "ours", "plannercheck, walk": "the paper's walk"}
PAIR_METHODS |= {IN_ONE_CALL: "ours, a call for all", FROM_PYTHON: "ours from Python"}
PAIR_METHODS |= {AT_BEST: AT_BEST, "coal, C++ loop": "coal by Pinocchio", "python-fcl": "FCL from Python"}
PAIR_METHODS |= {MUJOCO: "MuJoCo from Python"}
STATE_FILES = ("states_panda", "states_ur5", "states_baxter", "states_talos")


RRT = "RRTConnect, range 0.5 rad"


def overview() -> str:
    """One table of all that matters: ours, coal, FCL, VAMP."""
    kinds = dict.fromkeys(row["kind"] for row in record("motions")["rows"] if row["method"] == OURS)
    return _beside_others([*_states_beside(), *(_motion_beside(kind) for kind in kinds), *_plans_beside(), *_rest()])


def summary() -> str:
    """The rows of the overview that README has."""
    return _beside_others([*_states_beside(), _motion_beside(RRT), _plans_beside()[0], *_rest()[:2]])


def _beside_others(rows: list[tuple[str, ...]]) -> str:
    return table(("", "ours", "coal", "FCL", "VAMP"), rows) + "\n" + paragraph(_BOLD)


def _states_beside() -> list[tuple[str, ...]]:
    random, along = (chosen("states_panda", scene="bookshelf", which=which) for which in ("random", "along motions"))
    every = random[OURS]["pairs"]
    return [
        (f"a random state of a Panda in a bookshelf ({every} pairs), in a batch, µs", *contenders(random, OURS, TREE)),
        ("the same, one by one from Python, µs", number(random[ONE_BY_ONE]["microseconds"]), "–", "–", "–"),
        ("a state along motions, in a batch, µs", *contenders(along, OURS, TREE)),
    ]


def _motion_beside(kind: str) -> tuple[str, ...]:
    return f"a motion ({kind}), in a batch, µs", *contenders(chosen("motions", kind=kind), OURS, MOTION_TREE)


def _plans_beside() -> list[tuple[str, ...]]:
    rows = {row["planner"]: row for row in record("plans")["rows"] if row["set"] == "all"}
    return [
        ("a search by RRTConnect, median, ms", *of_plans(rows, "median_ms")),
        ("a whole call of `pc.ompl.plan`, median, ms", *of_plans(rows, "call_median_ms")),
    ]


def _rest() -> list[tuple[str, ...]]:
    pairs = {row["method"]: row for row in record("pairs")["rows"] if row["vertices"] == 150 and row["gap"] == 1e-4}
    steps = {row["what"]: row for row in record("setup_panda")["rows"] if row["scene"] == "bookshelf"}
    files = median([row["total"] for row in record("from_files")["rows"]])
    return [
        (
            "a pair of hulls of 150 vertices near contact, µs",
            *contenders(pairs, "plannercheck, oracle", "coal, C++ loop"),
        ),
        ("a checker of a loaded robot and scene, until the first proved motion, ms", *of_steps(steps, "Checker(...)")),
        ("adding a box, until the first proved motion, ms", *of_steps(steps, "with_scene, one box more")),
        ("scene file and request to a proved path, ms", number(files), "–", "–", "–"),
    ]


_BOLD = (
    "In brackets: the library's time divided by ours; bold is faster than ours. Motions and plans: ours are proved, "
    'theirs are sampled. "At its best": coal in a C++ loop, the time of kinematics not counted. VAMP tests spheres of '
    "its own in single precision. The set-up of others ends with their first verdict, not with a proof."
)


def contenders(rows: dict[str, Row], ours: str, coal: str) -> tuple[str, str, str, str]:
    """µs of ours, coal at its best and otherwise, FCL's and VAMP's."""
    mine = rows[ours]["microseconds"]
    spent = {name: beside(row["microseconds"], mine) for name, row in rows.items()}
    cells = [f"{spent[AT_BEST]} at its best"] if AT_BEST in spent else []
    cells += [f"{spent[coal]} by Pinocchio"] if coal in spent else []
    return number(mine), ", ".join(cells) or "–", spent.get(FCL, "–"), spent.get(VAMP, "–")


def of_plans(rows: dict[str, Row], field: str) -> tuple[str, str, str, str]:
    """Milliseconds of ours, coal's and VAMP's plans."""
    mine = rows["plannercheck"][field]
    spent = {name: beside(row[field], mine) for name, row in rows.items() if row[field] is not None}
    return number(mine), spent.get("Pinocchio + coal", "–"), "–", spent.get("VAMP", "–")


def of_steps(rows: dict[str, Row], step: str) -> tuple[str, str, str, str]:
    """Milliseconds of a step with the first verdict and motion; of coal's and VAMP's builds with the first verdict."""
    spent = {
        what: sum(row[name] or 0 for name in ("milliseconds", "first_verdict", "first_motion"))
        for what, row in rows.items()
    }
    mine = spent[step]
    peers = (spent.get("Pinocchio + coal: geometry and AABB tree"), spent.get("VAMP: its environment"))
    coal, vamp = ("–" if value is None else beside(value, mine) for value in peers)
    return number(mine), coal, "–", vamp


def chosen(name: str, **wanted: str) -> dict[str, Row]:
    """Rows of a record with some values, by method; where there are several, the first."""
    rows = record(name)["rows"]
    found = [row for row in rows if all(row[key] == value for key, value in wanted.items())]
    return {row["method"]: row for row in reversed(found)}


def overview_sources() -> str:
    """Where the overview's figures come from."""
    names = ("states_panda", "motions", "plans", "pairs", "setup_panda", "from_files")
    return items(source(record(name)) for name in names)


def states() -> str:
    """µs a random state, by method, a column for each robot and scene."""
    return _states("random") + "".join("\n" + provenance(record(name)) for name in STATE_FILES)


def states_along_motions() -> str:
    """The same along motions, from the same runs, and how coal was asked."""
    asked = dict.fromkeys(
        f"{row['robot']}, {row['scene']}, {row['which']}: {row['note'].partition(': ')[2]}"
        for name in STATE_FILES
        for row in record(name)["rows"]
        if row["method"] == AT_BEST
    )
    return _states("along motions") + "\nHow coal is asked at its best:\n\n" + items(asked)


def vamp_verdicts() -> str:
    """Shares of states in which VAMP differs from the hulls."""
    rows = [row for name in STATE_FILES for row in record(name)["rows"] if row["method"] == VAMP]
    lines = [
        (
            row["robot"],
            row["scene"],
            row["which"],
            number(100 * row["false_free"]),
            number(100 * row["false_collision"]),
        )
        for row in rows
    ]
    return table(("robot", "scene", "states", "free, but colliding, %", "colliding, but free, %"), lines)


def _states(which: str) -> str:
    rows = [row for name in STATE_FILES for row in record(name)["rows"] if row["which"] == which]
    cases = list(dict.fromkeys((row["robot"], row["scene"], row["pairs"]) for row in rows))
    spent = {(row["robot"], row["scene"], row["method"]): row["microseconds"] for row in rows}
    names = [
        OURS,
        ONE_BY_ONE,
        "plannercheck, lists",
        "plannercheck, OMPL callback",
        AT_BEST,
        TREE,
        ALL_PAIRS,
        FCL,
        VAMP,
        "VAMP, from Python",
    ]
    lines = []
    for name in (name for name in names if any(method == name for *_, method in spent)):
        cells = []
        for robot, scene, _ in cases:
            value, ours = spent.get((robot, scene, name)), spent[robot, scene, OURS]
            peer = not name.startswith("plannercheck")
            cells.append("–" if value is None else beside(value, ours) if peer else number(value))
        lines.append([name.replace(", tolerance 1e-06", ""), *cells])
    header = [f"µs a state, {which}", *(f"{robot}, {scene} ({pairs:,} pairs)" for robot, scene, pairs in cases)]
    return table(header, lines) + f"\n{faster(_single_calls(spent, cases))}"


def _single_calls(spent: dict[tuple[str, str, str], float], cases: list[tuple[str, str, int]]) -> list[Faster]:
    """Where a peer's state takes less than ours in a batch, or than one call of ours."""
    found = []
    for ours, said in ((OURS, "in a batch"), (ONE_BY_ONE, "one by one")):
        for (robot, scene, name), value in spent.items():
            mine = spent[robot, scene, ours]
            if not name.startswith("plannercheck") and "0.001" not in name:
                found.append((name, f"{robot}, {scene}, {said}", value / mine))
    return found


def set_up() -> str:
    """Milliseconds until the first state can be judged, by library."""
    rows = [row for name in STATE_FILES for row in record(name)["rows"] if row["which"] == "random"]
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
            show = times if name.startswith("plannercheck") else beside
            cells.append("–" if value is None else show(value, ours))
        lines.append((f"{vertices:,}", f"{gap:+g}", *cells))
    told = faster(_faster_pairs(spent))
    header = ("vertices", "gap", *(PAIR_METHODS[name] for name in present))
    return table(header, lines) + f"\n{told}\n" + provenance(found)


def _faster_pairs(spent: dict[tuple[int, float, str], float]) -> list[Faster]:
    """Where a library takes less than ours asked alike: from C++ or from Python."""
    found = []
    for (vertices, gap, name), value in spent.items():
        ours = FROM_PYTHON if name in (FCL, MUJOCO) else "plannercheck, oracle"
        mine = spent.get((vertices, gap, ours))
        if not name.startswith("plannercheck") and mine is not None:
            asked = ", both from Python" if ours == FROM_PYTHON else ""
            found.append((name, f"{vertices:,} vertices{asked}", value / mine))
    return found
