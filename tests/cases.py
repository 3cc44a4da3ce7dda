"""Two posed bodies as a file: a case that once failed, to be kept by name in tests/hard.

In and out: JSON with vertices and poses as hexadecimal floats, so that no bit is lost.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from contacts import Points, Solid

HARD = Path(__file__).parent / "hard"


@dataclass(frozen=True, eq=False)
class Case:
    """Two bodies at their poses.

    Attributes:
        name: What they are.
        bodies: Vertices of the first and second (n, 3), then their poses (4, 4), m.
    """

    name: str
    bodies: tuple[Points, Points, Points, Points]

    @staticmethod
    def of(p: Solid, r: Solid, pose_p: Points, pose_r: Points) -> Case:
        return Case(f"{p.name} | {r.name}", (p.vertices, r.vertices, pose_p, pose_r))

    def save(self, path: Path) -> None:
        """Writes the case as JSON."""
        arrays = [[[x.hex() for x in row] for row in array.tolist()] for array in self.bodies]
        keys = ("vertices_p", "vertices_r", "pose_p", "pose_r")
        text = json.dumps({"name": self.name, **dict(zip(keys, arrays, strict=True))}, indent=0)
        path.write_text(text)

    @staticmethod
    def load(path: Path) -> Case:
        """Reads a case."""
        content = json.loads(path.read_text())
        p, r, pose_p, pose_r = (
            np.array([[float.fromhex(x) for x in row] for row in content[key]])
            for key in ("vertices_p", "vertices_r", "pose_p", "pose_r")
        )
        return Case(content["name"], (p, r, pose_p, pose_r))
