"""Failing pairs of solids in files: a case is made smaller before it is kept, and can be judged again.

In and out: JSON with points and poses as hexadecimal floats, so that no bit is lost.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct_values
from plannercheck.common.checked_yaml import BROKEN_FILE
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.stress.shared_runs import is_case_of
from plannercheck.evaluation.stress_solids.bodies import Body
from plannercheck.evaluation.stress_solids.surfaces import Surface, surface

# The key by which a file tells that it is of this kind.
_KIND = "solids"


@dataclass(frozen=True, eq=False)
class SolidCase:
    """Two bodies at their poses.

    Attributes:
        name: What failed.
        p: The first body.
        r: The second body.
        pose_p: (4, 4), m.
        pose_r: (4, 4), m.
    """

    name: str
    p: Body
    r: Body
    pose_p: Floats
    pose_r: Floats

    def save(self, path: Path) -> None:
        """Writes the case as JSON."""
        content = {
            "kind": _KIND,
            "name": self.name,
            **{name: _document_of(body) for name, body in (("p", self.p), ("r", self.r))},
            **{name: _hexadecimal(pose) for name, pose in (("pose_p", self.pose_p), ("pose_r", self.pose_r))},
        }
        path.write_text(json.dumps(content, indent=0))

    @staticmethod
    def load(path: Path) -> SolidCase:
        """Reads a case."""
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
            p, r = (_body_of(content[name]) for name in ("p", "r"))
            pose_p, pose_r = (_doubles(content[name]) for name in ("pose_p", "pose_r"))
            return SolidCase(content["name"], p, r, pose_p, pose_r)
        except BROKEN_FILE as error:
            raise PlannercheckError(f"file {str(path)!r} is no case of a pair of solids: {error!s:.200}") from None

    @staticmethod
    def is_in(path: Path) -> bool:
        """Whether a file says that it holds a case of solids."""
        return is_case_of(_KIND, path)


def shrunk(case: SolidCase, fails: Callable[[SolidCase], bool]) -> SolidCase:
    """Drops triangles of both bodies for as long as a case still fails, then points that none uses.

    Args:
        case: One that fails.
        fails: Whether a case fails.

    Returns:
        A case that fails, and from which no triangle can be dropped.
    """
    for first in (True, False):
        part = max(1, len(_body(case, first).surface.triangles) // 2)
        while part >= 1:
            smaller = _without_some(case, first, part, fails)
            part = part if smaller is not case else part // 2
            case = smaller
    bare = replace(case, p=_bare(case.p), r=_bare(case.r))
    return bare if fails(bare) else case


def _without_some(case: SolidCase, first: bool, part: int, fails: Callable[[SolidCase], bool]) -> SolidCase:
    """The case without the first run of `part` triangles that it can do without; itself if there is none."""
    body = _body(case, first)
    triangles = body.surface.triangles
    if body.is_convex:
        return case
    for start in range(0, len(triangles), part):
        kept = np.delete(triangles, slice(start, start + part), axis=0)
        smaller = replace(body, surface=Surface(body.surface.points, kept))
        tried = replace(case, p=smaller) if first else replace(case, r=smaller)
        if len(kept) and fails(tried):
            return tried
    return case


def _body(case: SolidCase, first: bool) -> Body:
    return case.p if first else case.r


def _bare(body: Body) -> Body:
    used, corners = distinct_values(body.surface.triangles)
    return replace(body, surface=surface(body.surface.points[used], corners.reshape(-1, 3)))


def _hexadecimal(rows: Floats) -> list[list[str]]:
    return [[x.hex() for x in row] for row in rows.tolist()]


def _doubles(rows: list[list[str]]) -> Floats:
    return np.array([[float.fromhex(x) for x in row] for row in rows])


def _document_of(body: Body) -> dict[str, Any]:
    return {
        "family": body.family,
        "points": _hexadecimal(body.surface.points),
        "triangles": body.surface.triangles.tolist(),
        "inflation_radius": body.inflation_radius.hex(),
        "is_convex": body.is_convex,
        "is_capped": body.is_capped,
    }


def _body_of(document: dict[str, Any]) -> Body:
    found = surface(_doubles(document["points"]), document["triangles"])
    radius = float.fromhex(document["inflation_radius"])
    kinds = bool(document["is_convex"]), bool(document.get("is_capped", False))
    return Body(str(document["family"]), found, radius, *kinds)
