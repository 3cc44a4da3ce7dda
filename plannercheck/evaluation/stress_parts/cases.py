"""Failing pairs of sets of parts in files: a case is made smaller before it is kept, and can be judged again.

In and out: JSON with numbers as hexadecimal floats, so that no bit is lost.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.checked_yaml import BROKEN_FILE
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.stress.shared_runs import is_case_of
from plannercheck.evaluation.stress_parts.given import Given, given_of

# The key by which a file tells that it is of this kind.
_KIND = "parts"


@dataclass(frozen=True, eq=False)
class PartCase:
    """Two bodies at their poses.

    Attributes:
        name: What failed.
        p: What the first body is given by.
        r: The same of the second.
        pose_p: (4, 4), m.
        pose_r: (4, 4), m.
    """

    name: str
    p: Given
    r: Given
    pose_p: Floats
    pose_r: Floats

    def save(self, path: Path) -> None:
        """Writes the case as JSON."""
        poses = {"pose_p": self.pose_p, "pose_r": self.pose_r}
        content = {
            "kind": _KIND,
            "name": self.name,
            "p": self.p.document(),
            "r": self.r.document(),
            **{name: [x.hex() for x in pose.ravel().tolist()] for name, pose in poses.items()},
        }
        path.write_text(json.dumps(content, indent=0))

    @staticmethod
    def load(path: Path) -> PartCase:
        """Reads a case."""
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
            p, r = (given_of(content[name]) for name in ("p", "r"))
            poses = ([float.fromhex(x) for x in content[name]] for name in ("pose_p", "pose_r"))
            pose_p, pose_r = (np.array(pose).reshape(4, 4) for pose in poses)
            return PartCase(content["name"], p, r, pose_p, pose_r)
        except BROKEN_FILE as error:
            raise PlannercheckError(f"file {str(path)!r} is no case of sets of parts: {error!s:.200}") from None

    @staticmethod
    def is_in(path: Path) -> bool:
        """Whether a file says that it holds a case of sets of parts."""
        return is_case_of(_KIND, path)


def shrunk(case: PartCase, fails: Callable[[PartCase], bool]) -> PartCase:
    """Drops parts and corners of both bodies for as long as a case still fails.

    Args:
        case: One that fails.
        fails: Whether a case fails.

    Returns:
        A case that fails, and of which no smaller one that was tried does.
    """
    while True:
        found = next((smaller for smaller in _smaller(case) if fails(smaller)), None)
        if found is None:
            return case
        case = found


def _smaller(case: PartCase) -> Iterator[PartCase]:
    yield from (replace(case, p=p) for p in case.p.smaller())
    yield from (replace(case, r=r) for r in case.r.smaller())
