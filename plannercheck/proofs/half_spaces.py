"""Half-spaces in proofs: the plane of one, in ball arithmetic.

In: the body {x : n . x <= d}, posed by y = M x + t. Out: the direction g = n adj(M) out of it, and its point that is
nearest to the origin, of height c = d det M + g . t. As det M > 0, the body is {y : g . y <= c}, so its highest points
along g have the height of this point. No other direction separates a body from it, so entries name none.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from flint import arb, arb_mat

from plannercheck.proofs.data import WORLD, PosedBody
from plannercheck.proofs.heights import Direction, Seen, direction_on
from plannercheck.proofs.jets import affine


def plane_of(body: PosedBody) -> tuple[Seen, Direction]:
    """A point of a half-space as high as any of it, and the direction out of it, both in the world."""
    pose = affine(body.pose)
    rows = [[pose[i, k] for k in range(3)] for i in range(3)]
    cofactors = [_cross(rows[(i + 1) % 3], rows[(i + 2) % 3]) for i in range(3)]
    normal, offset = [arb(x) for x in body.half_space[:3]], arb(body.half_space[3])
    outwards = [_dot(row, normal) for row in cofactors]
    height = offset * _dot(rows[0], cofactors[0]) + _dot(outwards, [pose[k, 3] for k in range(3)])
    part = height / _dot(outwards, outwards)
    place = arb_mat(4, 4, [x for g in outwards for x in (0, 0, 0, g * part)] + [0, 0, 0, 1])
    return Seen(np.zeros((1, 3)), np.zeros(3), WORLD, place), direction_on(WORLD, arb_mat(4, 1, [*outwards, 0]))


def _dot(a: list[Any], b: list[Any]) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: list[Any], b: list[Any]) -> list[Any]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
