"""Tables of what plannercheck itself does and takes, in Markdown, from docs/results.

In: files of results. Out: text for `render_results.py`, under each table the command, the date, the commit and the
machine that its figures come from.
"""

from __future__ import annotations

import re

from result_markdown import number, provenance, ratio, record, table, times


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
    """Visited vertices and rounds, worst and mean, by method: of the smallest and the largest bodies."""
    found = record("complexity")
    sizes: dict[tuple[str, ...], list[int]] = {}
    for row in found["rows"]:
        sizes.setdefault((row["where"], row["family"], row["method"]), []).append(row["vertices"])
    ends = {kind: (min(several), max(several)) for kind, several in sizes.items()}
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
        if row["vertices"] in ends[row["where"], row["family"], row["method"]]
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
        title = re.sub(r"\d{4,}", lambda digits: f"{int(digits[0]):,}", kind)
        header += [title, "µs"] if kind in timed else [title]
    lines = []
    for name in names:
        cells = [name]
        for kind in kinds:
            row = by_both[kind, name]
            cells.append(f"{row['percent']:.1f} %" if row["percent"] else "0")
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
    lines = [(row["states"], row["off"], number(row["microseconds"]), ratio(row)) for row in found["rows"]]
    return table(("states", "off", "µs a state", "×"), lines) + "\n" + provenance(found)


def levels() -> str:
    """µs on the widest instruction set, and the next one's time over it, by kind of work and robot."""
    found = record("levels")
    rows = {(row["work"], row["robot"]): list(row["microseconds"].values()) for row in found["rows"]}
    first, other = found["rows"][0]["microseconds"]
    robots = list(dict.fromkeys(robot for _, robot in rows))
    lines = [
        [work, *(f"{number(wide)} ({narrow / wide:.2f})" for wide, narrow in (rows[work, robot] for robot in robots))]
        for work in dict.fromkeys(work for work, _ in rows)
    ]
    return table([f"µs on {first} ({other} over it)", *robots], lines) + "\n" + provenance(found)


def scale() -> str:
    """Scenes of many boxes."""
    found = record("scale")
    lines = [
        (
            f"{row['boxes']:,}",
            f"{row['pairs']:,}",
            *(number(row[name]) for name in ("microseconds", "motion_microseconds")),
            f"{row['preparation']:.2f}",
        )
        for row in found["rows"]
    ]
    return (
        table(("boxes", "pairs", "µs a state", "µs a motion of 0.4 rad", "prepared, s"), lines)
        + "\n"
        + provenance(found)
    )


def ndim_rounds() -> str:
    """Rounds and visited vertices of the paper's trees in any dimension."""
    found = record("ndim_rounds")
    columns = list(found["rows"][0])
    return table(columns, [[row[name] for name in columns] for row in found["rows"]]) + "\n" + provenance(found)


def ndim_speed() -> str:
    """A query in any dimension beside a linear program."""
    found = record("ndim_speed")
    lines = [
        (
            row["d"],
            f"{row['n']:,}",
            f"{row['gap']:g}",
            number(row["oracle"]),
            times(row["trees"], row["oracle"]) if "trees" in row else "–",
            times(row["program"], row["oracle"]),
        )
        for row in found["rows"]
    ]
    return table(("d", "n", "gap", "oracle, ms", "trees, ms", "program, ms"), lines) + "\n" + provenance(found)


def motions_missed() -> str:
    """Proved motions against dense states, and what sampling misses."""
    return missed("motions_missed")


def planar_motions_missed() -> str:
    """The same in the plane."""
    return missed("planar_motions_missed")


def missed(name: str) -> str:
    """A column a family of motions, and one for all."""
    found = record(name)
    counted = [key for key in found["rows"][0] if key != "family"]
    lines = []
    for key in counted:
        values = [row[key] for row in found["rows"]]
        lines.append((key, *(f"{value:,}" for value in (*values, sum(values)))))
    header = ("", *(row["family"] for row in found["rows"]), "all")
    return table(header, lines) + "\n" + provenance(found)


def planar_motions_cost() -> str:
    """Planar motions proved, beside sampling."""
    found = record("planar_motions_cost")
    lines = [
        (
            f"{row['robot']}, {row['scene']}",
            row["curve"],
            f"{row['motions']} ({row['which']})",
            number(row["proved"]),
            times(row["1 cm"], row["proved"]),
            times(row["10 cm"], row["proved"]),
        )
        for row in found["rows"]
        if "which" in row
    ]
    header = ("robot, scene", "curve", "motions", "proved, µs", "1 cm, µs", "10 cm, µs")
    return table(header, lines) + "\n" + provenance(found)


def kinematic_rounding() -> str:
    """How far computed poses are off, and the proven bound."""
    found = record("kinematic_rounding")
    lines = [
        (row["robot"], row["joints"], f"{row['far']:.2f}", f"{row['measured']:.1e}", f"{row['bound']:.1e}")
        for row in found["rows"]
    ]
    header = ("robot", "joints", "farthest point, m", "measured, m", "proven bound, m")
    return table(header, lines) + "\n" + provenance(found)


def games() -> str:
    """The solver's games."""
    found = record("games")
    lines = [(row["game"], number(row["nanoseconds"]), number(row["one_more"])) for row in found["rows"]]
    header = ("game", "solved from nothing, ns", "one more row or column, ns")
    return table(header, lines) + "\n" + provenance(found)


def disabled_pairs() -> str:
    """Pairs that robots disable although they collide, a row a robot."""
    found = record("disabled_pairs")
    fields = ("robot", "declared_by", "link_pairs", "disabled", "colliding", "never", "most")
    header = ("robot", "declared by", "pairs of links", "disabled", "collide in some states, not adjacent")
    rows = [[row[field] for field in (*fields, "colliding_meshes", "most_meshes")] for row in found["rows"]]
    columns = (*header, 'of these "Never"', "most frequent", "as meshes", "most frequent")
    return table(columns, rows) + "\n" + provenance(found)
