"""Tables of figures on sensed scenes, in Markdown, from docs/results.

In: files of results. Out: text for `render_results.py`, under each table the command, the date, the commit and the
machine that its figures come from.
"""

from __future__ import annotations

from typing import Any

from result_markdown import beside, faster, number, paragraph, provenance, record, table
from result_tables import ALL_PAIRS, FCL, MOTION_TREE, ONE_BY_ONE, OURS, TREE, VAMP

Row = dict[str, Any]

_JUDGES = {OURS: "ours", ONE_BY_ONE: "ours, one by one", TREE: "Pinocchio + coal, AABB tree"}
_JUDGES |= {ALL_PAIRS: "Pinocchio + coal, all pairs", FCL: FCL, VAMP: VAMP}
_MOVERS = {OURS: "ours", ONE_BY_ONE: "ours, one by one", MOTION_TREE: MOTION_TREE, FCL: FCL, VAMP: VAMP}


def sensed_states() -> str:
    """µs a random state before clouds, a row for each number of points."""
    return _by_method("clouds_states", "scene", "µs a state", _JUDGES)


def sensed_motions() -> str:
    """µs a motion that RRTConnect asks before clouds."""
    return _by_method("clouds_motions", "where", "µs a motion", _MOVERS)


def sensed_maps() -> str:
    """What a map takes, then µs a state and a motion in it."""
    found = record("maps_costs")
    lines = [(row["name"], f"{row['parts']:,}", number(row["build"]), number(row["own"])) for row in found["rows"]]
    costs = table(("map", "parts", "built in s", "bytes a part"), lines)
    states = _by_method("maps_states", "scene", "µs a state", _JUDGES)
    motions = _by_method("maps_motions", "where", "µs a motion", _MOVERS)
    return f"{costs}\n{provenance(found)}\n{states}\n{motions}"


def _by_method(name: str, where: str, what: str, methods: dict[str, str]) -> str:
    """A row for each scene, a column for each method, then where verdicts differ from ours."""
    found = record(name)
    spent = {(row[where], row["method"]): row for row in found["rows"]}
    scenes = list(dict.fromkeys(row[where] for row in found["rows"]))
    shown = {method: title for method, title in methods.items() if any(method == each for _, each in spent)}
    lines, told = [], []
    for scene in scenes:
        ours = spent[scene, OURS]["microseconds"]
        cells = [number(100 * spent[scene, OURS]["valid" if where == "scene" else "free"])]
        for method in shown:
            row, is_peer = spent.get((scene, method)), not method.startswith("plannercheck")
            value = None if row is None else row["microseconds"]
            cells.append("–" if value is None else beside(value, ours) if is_peer else number(value))
            if value is not None and is_peer:
                told.append((method, scene, value / ours))
        lines.append((scene, *cells))
    header = (what, "free, %", *shown.values())
    return f"{table(header, lines)}\n{faster(told)}\n{_wrong(spent, scenes, shown)}\n{provenance(found)}"


def _wrong(spent: dict[tuple[str, str], Row], scenes: list[str], shown: dict[str, str]) -> str:
    peers = [method for method in shown if not method.startswith("plannercheck")]
    rows = [(scene, *(_wrong_cell(spent.get((scene, method))) for method in peers)) for scene in scenes]
    return table(("free, but colliding; colliding, but free, %", *(shown[method] for method in peers)), rows)


def _wrong_cell(row: Row | None) -> str:
    return "–" if row is None else f"{number(100 * row['false_free'])}; {number(100 * row['false_collision'])}"


def sensed_costs() -> str:
    """What building, changing and holding clouds takes."""
    found = record("clouds_costs")
    lines = [
        (
            f"{row['points']:,}",
            row["method"],
            *(number(1e3 * row[field]) for field in ("build", "update")),
            *(number(row[field]) for field in ("bytes", "own")),
        )
        for row in found["rows"]
    ]
    header = (
        "points",
        "who",
        "built in ms",
        "until the first state, ms",
        "bytes a point, resident",
        "by its own account",
    )
    return table(header, lines) + "\n" + provenance(found)


def sensed_camera() -> str:
    """What each step takes after a frame of a moving camera."""
    found = record("camera")
    lines = [(row["step"], *(number(row[field]) for field in ("median", "late", "most"))) for row in found["rows"]]
    whole = found["rows"][-1]
    said = (
        f"{whole['frames']:,} frames of {whole['points']:,.0f} points, {whole['kept']:,.0f} of them not the robot's "
        f"own, and {whole['states']:,} states after each. {number(100 * whole['in_time'])} % of the frames were done "
        f"within a thirtieth of a second; {number(100 * whole['planned'])} % have a path."
    )
    return f"{table(('ms of the processor', 'median', '95 %', 'most'), lines)}\n{paragraph(said)}\n{provenance(found)}"


def sensed_proofs() -> str:
    """What proofs of a path before sets of parts take."""
    found = record("sensed_proofs")
    fields = ("build", "verify", "entries", "directions", "json", "npz")
    lines = [
        (row["scene"], f"{row['parts']:,}", row["motions"], *(number(row[field]) for field in fields))
        for row in found["rows"]
    ]
    header = ("scene", "parts", "motions", "s to build", "s to verify", "entries", "directions", "MB, JSON", "MB, npz")
    return table(header, lines) + "\n" + provenance(found)


def sensed_pages() -> str:
    """Size of pages of sensed scenes, and what a frame takes to draw."""
    found = record("sensed_pages")
    lines = [
        (
            row["scene"],
            f"{row['parts']:,}",
            *(number(row[field]) for field in ("megabytes", "seconds", "still", "sliced")),
            f"{row['slices']:.0f}",
            number(row["moving"]),
            f"{row['moving share']:.0%}",
        )
        for row in found["rows"]
    ]
    header = ("page of", "parts", "MB", "written in s", "all parts in one frame, ms of the processor")
    header += ("in slices", "slices", "a frame while it moves, ms", "of all parts")
    return table(header, lines) + "\n" + provenance(found)
