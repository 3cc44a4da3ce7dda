"""Failing cases in files: two posed bodies; a case is made smaller before it is kept.

In and out: JSON with vertices and poses as hexadecimal floats, so that no bit is lost.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from plannercheck.common.checked_yaml import BROKEN_FILE
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.stress.contact_poses import Points, Solid

Bodies = tuple[Points, Points, Points, Points]


@dataclass(frozen=True, eq=False)
class Case:
    """Two bodies at their poses.

    Attributes:
        name: Name of the pair.
        bodies: Vertices of the first and second (n, 3), then their poses (4, 4), m.
        inflation_radii: Inflation radii of the first and second body, m.
    """

    name: str
    bodies: Bodies
    inflation_radii: tuple[float, float] = (0.0, 0.0)

    @staticmethod
    def of(p: Solid, r: Solid, pose_p: Points, pose_r: Points) -> Case:
        """The case of two solids at poses (4, 4), m."""
        return Case(f"{p.name} | {r.name}", (p.vertices, r.vertices, pose_p, pose_r))

    def save(self, path: Path) -> None:
        """Writes the case as JSON."""
        arrays = [[[x.hex() for x in row] for row in array.tolist()] for array in self.bodies]
        keys = ("vertices_p", "vertices_r", "pose_p", "pose_r")
        content = {"name": self.name, **dict(zip(keys, arrays, strict=True))}
        if any(self.inflation_radii):
            content["swells"] = [float(inflation_radius).hex() for inflation_radius in self.inflation_radii]
        path.write_text(json.dumps(content, indent=0))

    @staticmethod
    def load(path: Path) -> Case:
        """Reads a case."""
        try:
            return Case._of_document(json.loads(path.read_text(encoding="utf-8")))
        except BROKEN_FILE as error:
            raise PlannercheckError(f"file {str(path)!r} is no case of a pair: {error!s:.200}") from None

    @staticmethod
    def _of_document(content: dict[str, Any]) -> Case:
        p, r, pose_p, pose_r = (
            np.array([[float.fromhex(x) for x in row] for row in content[key]])
            for key in ("vertices_p", "vertices_r", "pose_p", "pose_r")
        )
        inflation_p, inflation_r = (float.fromhex(x) for x in content.get("swells", ("0x0p0", "0x0p0")))
        return Case(content["name"], (p, r, pose_p, pose_r), (inflation_p, inflation_r))


def shrunk(case: Case, fails: Callable[[Case], bool]) -> Case:
    """Drops vertices of both bodies for as long as a case still fails.

    Args:
        case: One that fails.
        fails: Whether a case fails.

    Returns:
        A case that fails and that no vertex can be dropped from.
    """
    for body in (0, 1):
        part = max(1, len(case.bodies[body]) // 2)
        while part >= 1:
            smaller = _without_some(case, body, part, fails)
            part = part if smaller is not case else part // 2
            case = smaller
    return case


def _without_some(case: Case, body: int, part: int, fails: Callable[[Case], bool]) -> Case:
    """The case without the first run of `part` vertices that it can do without; itself if there is none."""
    count = len(case.bodies[body])
    for first in range(0, count, part):
        kept = [*range(first), *range(first + part, count)]
        arrays = list(case.bodies)
        arrays[body] = arrays[body][kept]
        smaller = Case(case.name, (arrays[0], arrays[1], arrays[2], arrays[3]), case.inflation_radii)
        if kept and fails(smaller):
            return smaller
    return case
