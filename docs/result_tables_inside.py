"""Tables of what plannercheck itself does and takes, in Markdown, from docs/results.

In: files of results. Out: text for `render_results.py`, under each table the command, the date, the commit and the
machine that its figures come from.
"""

from __future__ import annotations

import re

from result_markdown import beside, number, paragraph, provenance, record, table, times


def clearance_of_motions() -> str:
    """How a proved motion grows as the clearance shrinks, beside our own check of 32 states."""
    found = record("motions_cost")
    lines = [
        (f"{1e3 * row['clearance']:g}", number(row["ours"]), number(row["sampled"]))
        for row in found["rows"]
        if row.get("clearance") in (0.3, 0.03, 0.003, 0.0005, 0.00011)
    ]
    return table(("clearance, mm", "proved, µs", "32 states, µs"), lines) + "\n" + provenance(found)


def hierarchies() -> str:
    """Vertex blocks that the worst of 1,000 queries visits, a row a family."""
    found = record("hierarchies")
    families: dict[str, list[dict[str, int]]] = {}
    for row in found["rows"]:
        if row["family"] != "preparation":
            families.setdefault(row["family"], []).append(row)
    fields = ("hull_blocks", "walk_blocks", "walk_rounds")
    lines = [
        (family, *(", ".join(str(row[field]) for row in rows) for field in fields)) for family, rows in families.items()
    ]
    header = ("bodies of 100, 1,000, 10,000 vertices", "blocks a query", "blocks a walk", "rounds a walk")
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
    """Time of the algorithm in the plane, beside shapely."""
    found = record("planar")
    lines = [
        (
            f"{row['vertices']:,}",
            f"±{row['gap']:g}",
            number(row["poses_ns"]),
            number(row["arrays_ns"]),
            times(row["shapely_ns"], row["poses_ns"]),
        )
        for row in found["rows"]
        if "shapely_ns" in row and row["gap"] < 0.5
    ]
    header = ("vertices", "gap", "ours at poses, ns", "ours from arrays, ns", "shapely, prepared, ns")
    return table(header, lines) + "\n" + provenance(found)


def clearance() -> str:
    """Nanoseconds a distance, beside coal's."""
    found = record("clearance")
    lines = [
        (f"{row['vertices']:,}", f"{row['gap']:g}", number(row["ours"]), times(row["coal"], row["ours"]))
        for row in found["rows"]
        if row["gap"] == 0.1
    ]
    return table(("vertices", "gap, radii", "ours, ns", "coal, ns"), lines) + "\n" + provenance(found)


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
        if row["boxes"] in (100, 10_000, 100_000)
    ]
    return (
        table(("boxes", "pairs", "µs a state", "µs a motion of 0.4 rad", "prepared, s"), lines)
        + "\n"
        + provenance(found)
    )


def ndim_rounds() -> str:
    """Rounds and visited vertices of the paper's trees, of the largest bodies of each family and dimension."""
    found = record("ndim_rounds")
    largest = {(row["d"], row["bodies"]): row for row in found["rows"]}  # by size, so the largest stays
    columns = [name for name in found["rows"][0] if name not in ("m (polar)", "visited: mean")]
    return table(columns, [[row[name] for name in columns] for row in largest.values()]) + "\n" + provenance(found)


def ndim_speed() -> str:
    """A query in any dimension beside a linear program: at gaps of 1e-4 and 0."""
    found = record("ndim_speed")
    rows = {(row["d"], row["n"], row["gap"]): row for row in found["rows"]}
    lines = []
    for d, n in dict.fromkeys((d, n) for d, n, gap in rows if gap == 0 and n != 1_000):
        cells = []
        for gap in (1e-4, 0):
            row = rows[d, n, gap]
            cells += [number(row["oracle"]), number(row.get("trees")), beside(row["program"], row["oracle"])]
        lines.append((d, f"{n:,}", *cells))
    header = ("d", "n", "gap 1e-4: oracle, ms", "trees", "program", "gap 0: oracle, ms", "trees", "program")
    return table(header, lines) + "\n" + provenance(found)


def motions_missed() -> str:
    """Proved motions against dense states, and what sampling misses, in space and in the plane."""
    files = [record("motions_missed"), record("planar_motions_missed")]
    counted = [key for key in files[0]["rows"][0] if key in files[1]["rows"][0] and key != "family"]
    lines = [[key, *(f"{sum(row[key] for row in found['rows']):,}" for found in files)] for key in counted]
    return table(("", "in space", "in the plane"), lines) + "".join("\n" + provenance(found) for found in files)


def kinematic_rounding() -> str:
    """How far computed poses are off, and the proven bounds, in one sentence."""
    found = record("kinematic_rounding")
    measured, bounds = ([row[field] for row in found["rows"]] for field in ("measured", "bound"))
    said = f"On {len(bounds)} robots it is at most {max(measured):.1e} m; the bounds are {min(bounds):.1e} to "
    return paragraph(f"{said}{max(bounds):.1e} m.") + "\n" + provenance(found)


def disabled_pairs() -> str:
    """Pairs that robots disable although they collide, a row for each robot that has some."""
    found = record("disabled_pairs")
    fields = ("robot", "declared_by", "disabled", "colliding", "never", "most", "colliding_meshes", "most_meshes")
    rows = [[row[field] for field in fields] for row in found["rows"] if row["colliding"]]
    header = ("robot", "declared by", "disabled", "of these collide", 'declared "Never"', "most frequent", "as meshes")
    return table((*header, "most frequent"), rows) + "\n" + provenance(found)


def long_runs() -> str:
    """Runs that hold verdicts against oracles."""
    lines = [
        (row["what"], f"{row['count']:,}", row["found"], row["wrong"], f"`{row['command']}`")
        for row in record("long_runs")["rows"]
    ]
    return table(("verdicts on", "count", "of these", "wrong", "command"), lines)


def hard_pairs() -> str:
    """Wrong verdicts in percent of the pairs that were asked, by the size of the gap."""
    found = record("hard_pairs")
    sizes: dict[str, list[dict[str, int]]] = {}
    for row in found["rows"]:
        if row["by"] == "gap":
            sizes.setdefault(row["of"].lstrip("+-"), []).append(row)
    lines = [(size, *_wrong(rows)) for size, rows in sizes.items() if not size.endswith(("1", "3", "5", "7", "9"))]
    return table(("gap", *_WRONG), lines) + "\n" + provenance(found)


def hard_solids() -> str:
    """The same of concave bodies and of robots' links, over all gaps."""
    files = {"concave bodies": record("hard_solids"), "links of robots": record("hard_links")}
    lines = []
    for what, found in files.items():
        row = next(row for row in found["rows"] if row["of"] == "all")
        lines.append((what, f"{row['pairs']:,}", f"{row['sharing']:,}", f"{row['inside']:,}", *_wrong([row])))
    header = ("", "pairs", "share a point", "one inside the other", *_WRONG)
    return table(header, lines) + "".join("\n" + provenance(found) for found in files.values())


_WRONG = ("ours wrong", "FCL misses, %", "FCL invents, %", "coal misses, %", "coal invents, %")


def _wrong(rows: list[dict[str, int]]) -> list[str]:
    asked = sum(row["fcl_asked"] for row in rows)
    theirs = ("fcl_missed", "fcl_false", "coal_missed", "coal_false")
    shares = (100 * sum(row[field] for row in rows) / asked for field in theirs)
    return [str(sum(row["wrong"] for row in rows)), *(number(share) for share in shares)]
