"""What convex pieces bring and cost beside hulls and the meshes themselves: valid states, and time a state.

Run: python tests/benchmarks/decomposition.py ur5 ur10 ... Links whose pieces neither come with plannercheck nor are
cached keep their hulls. Verdicts by meshes are exact, open meshes being closed by caps. Times are CPU µs a
state, by turns.
"""

import argparse
from functools import partial
from pathlib import Path

import plannercheck as pc
from plannercheck.evaluation.bench.records import write_record
from plannercheck.evaluation.bench.timing import least_seconds
from plannercheck.robots.description import description_of
from plannercheck.robots.geometry_choices import of_hulls, of_known_pieces, of_meshes

ROUNDS = 5


def main() -> None:
    """Prints the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("robots", nargs="*", default=["ur3", "ur5", "ur10", "pr2", "kinova", "baxter", "tiago"])
    parser.add_argument("--states", type=int, default=20_000)
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    rows: list[dict[str, object]] = []
    for robot in options.robots:
        rows += rows_of(robot, options.states)
        if options.output:
            write_record(options.output, rows)


def rows_of(name: str, states: int) -> list[dict[str, object]]:
    """A row for each geometry of a robot."""
    description = description_of(name)
    pieces, unknown = of_known_pieces(description)
    robots = {"hulls": of_hulls(description), "pieces": pieces, "meshes": of_meshes(description)}
    if not pieces.pieces:
        del robots["pieces"]
    checkers = {geometry: pc.Checker(robot) for geometry, robot in robots.items()}
    q = robots["hulls"].random_configurations(states, 0)
    spent = least_seconds({geometry: partial(each.check_states, q) for geometry, each in checkers.items()}, ROUNDS)
    valid = {geometry: checker.check_states(q) for geometry, checker in checkers.items()}
    rows = []
    for geometry, by in valid.items():
        row: dict[str, object] = {
            "robot": name,
            "geometry": geometry,
            "links_kept_as_hulls": list(unknown) if geometry == "pieces" else [],
            "states": states,
            "pairs": len(checkers[geometry].pairs),
            "valid": float(by.mean()),
            "refused_by_filling": float((valid["meshes"] & ~by).mean()),
            "valid_but_meshes_collide": float((by & ~valid["meshes"]).mean()),
            "microseconds": 1e6 * spent[geometry] / states,
        }
        print(
            "  ".join(
                f"{key} {value:.4g}" if isinstance(value, float) else f"{key} {value}" for key, value in row.items()
            )
        )
        rows.append(row)
    return rows


if __name__ == "__main__":
    main()
