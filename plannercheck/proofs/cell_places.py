"""Where the robots of a cell stand, read by the verifier itself: the poses of its YAML in exact numbers.

In: a cell's YAML. Out: the placement of each robot's base, by name. It shares no function with
`plannercheck.robots` and `plannercheck.bodies`: scalars are taken as the texts that they are, and texts as decimals.
"""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import yaml

from plannercheck.common.checked_yaml import parse_yaml
from plannercheck.common.errors import PlannercheckError
from plannercheck.proofs.exact_placements import Placement, at_rest, decimals, enough_digits, placed

# The rows of a matrix that moves nothing.
_STILL = [[Fraction(int(row == column)) for column in range(4)] for row in range(4)]

# The key of a mapping whose keys another mapping takes over, which PyYAML's plain loader does not know.
_MERGE = "<<"


@enough_digits()
def base_placements(cell: str | Path) -> dict[str, Placement]:
    """The placement of each robot's base in the world, by name; a robot without a pose is at rest at the origin.

    Raises:
        PlannercheckError: If the file can't be read, or a pose is not as scene files write it.
    """
    try:
        text = Path(cell).read_bytes()
        parse_yaml(text)  # refuses keys that stand twice
        robots = yaml.load(text, Loader=yaml.BaseLoader)["robots"]
        if any(_MERGE in node for node in (robots, *robots.values())):
            raise ValueError(f"{_MERGE} could bring in poses: write them out")
        return {name: _placement(node.get("pose")) for name, node in robots.items()}
    except (OSError, yaml.YAMLError, UnicodeDecodeError, AttributeError, KeyError, TypeError, ValueError) as error:
        raise PlannercheckError(f"cell {str(cell)!r} can't be read by the verifier: {error}") from None


def _placement(pose: dict[str, Any] | None) -> Placement:
    """A pose's placement; of those that are given one by one, the shift and then the turn."""
    if not pose:
        return at_rest()
    if set(pose) == {"matrix"}:
        rows = [_numbers(row, 4, "a row of matrix") for row in pose["matrix"]]
        if len(rows) != 4 or rows[3] != _STILL[3]:
            raise ValueError("matrix must be 4 rows, of which the last is 0 0 0 1")
        return Placement.of_rows(rows)
    turns = sorted(set(pose) - {"position"})
    if turns not in ([], ["quaternion"], ["rpy"]):
        raise ValueError(f"a pose is a position with a quaternion or rpy, or a matrix, not {', '.join(pose)}")
    shift = _numbers(pose.get("position", ["0"] * 3), 3, "position")
    angles = _numbers(pose["rpy"], 3, "rpy") if "rpy" in pose else [Fraction(0)] * 3
    quaternion = _numbers(pose["quaternion"], 4, "quaternion") if "quaternion" in pose else None
    return placed(shift, angles, quaternion)


def _numbers(given: str | list[str], count: int, what: str) -> list[Fraction]:
    return decimals(" ".join(given) if isinstance(given, list) else given, count, what)
