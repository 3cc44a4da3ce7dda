"""Poses of two bodies around the moment at which they begin to share a point.

In: two bodies, rotations. Out: poses at offsets from such a moment, along a line.

The idea: take a place where the bodies share a point, since a point of one lies on a point of the other, and a place
where they share none, be it inside each other's hulls. Halve the line between both, with the oracle's verdicts, until
two neighbouring doubles are left. Along an axis, bodies of a lattice then touch exactly; otherwise the contact is as
near as doubles come.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from plannercheck.common.array_types import Bools, Floats
from plannercheck.evaluation.stress.contact_poses import identities, quarter_turns, random_directions, turns_onto
from plannercheck.evaluation.stress_solids.bodies import EXACT_FAMILIES, Body, decided

# Offsets from the last shared place towards the free one, over the smaller body's size, by name.
OFFSETS: dict[str, float] = {
    "0": 0.0,
    "next": 0.0,
    "+1 ulp": 0.0,
    "-1 ulp": 0.0,
    **{f"{sign}1e-{k}": float(f"{sign}1e-{k}") for k in (16, 15, 14, 13, 12, 10, 8, 6, 4, 3) for sign in "+-"},
}
_OFFSETS = np.array(list(OFFSETS.values()))
_NAMES = list(OFFSETS)
# Steps of halving: doubles of one exponent need 52, those about 0 more, which do not matter.
_MOST_HALVINGS = 90
# Places to look for one where nothing is shared, over the larger size; the last is outside of both.
_AWAY = np.array([0.06, 0.15, 0.3, 0.5, 0.8, 4.0])
ROTATIONS = ("none", "axis-aligned", "axis-aligned", "1e-9 rad", "random", "random")
_TINY_ANGLE = 1e-9  # rad


class Place(NamedTuple):
    """Where two bodies are but for a shift of the first: its rotation (3, 3), and the second one's pose (4, 4)."""

    turn_p: Floats
    pose_r: Floats

    def poses(self, shifts: Floats) -> tuple[Floats, Floats]:
        """Poses (k, 4, 4) of both for shifts (k, 3) of the first, m."""
        poses_p = identities(len(shifts))
        poses_p[:, :3, :3], poses_p[:, :3, 3] = self.turn_p, shifts
        return poses_p, np.tile(self.pose_r, (len(shifts), 1, 1))


def turn(rotation: str, rng: np.random.Generator) -> Floats:
    """A rotation (3, 3) of a kind in ROTATIONS."""
    if rotation == "none":
        return np.eye(3)
    if rotation == "axis-aligned":
        return np.asarray(quarter_turns(1, rng)[0], dtype=np.float64)
    if rotation == "random":
        return np.array(turns_onto(random_directions(1, rng), random_directions(1, rng), rng)[0], dtype=np.float64)
    x, y, z = _TINY_ANGLE * random_directions(1, rng)[0]
    return np.array([[1.0, -z, y], [z, 1.0, -x], [-y, x, 1.0]])


def around_contact(p: Body, r: Body, place: Place, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Poses (offsets, 4, 4) of both around a moment at which they begin to share a point."""
    point_r = place.pose_r[:3, :3] @ _point_of(r, rng) + place.pose_r[:3, 3]
    meeting = point_r - place.turn_p @ _point_of(p, rng)
    are_exact = all(body.family.startswith(EXACT_FAMILIES) for body in (p, r))
    along_axis = rng.random() < (0.8 if are_exact else 0.2)
    direction = quarter_turns(1, rng)[0, 0] if along_axis else random_directions(1, rng)[0]
    away = meeting + max(p.size, r.size) * _AWAY[:, None] * direction
    shared = _shared(p, r, place, np.vstack([meeting[None], away]))
    free = np.flatnonzero(~shared)
    if not shared[0] or not len(free):
        return place.poses(offset(meeting, meeting, direction, min(p.size, r.size)))
    # Half the time the nearest free place, which is the most hidden one.
    chosen = away[(free[0] if rng.integers(2) else int(rng.choice(free))) - 1]
    touching, apart = _halved(p, r, place, meeting, chosen)
    return place.poses(offset(touching, apart, direction, min(p.size, r.size)))


def offset(touching: Floats, apart: Floats, direction: Floats, size: float) -> Floats:
    """Shifts (offsets, 3) about a contact, m; `apart` is the next one without."""
    shifts = touching + size * _OFFSETS[:, None] * direction
    shifts[_NAMES.index("next")] = apart
    axis = int(np.argmax(np.abs(direction)))
    for name, side in (("+1 ulp", 1.0), ("-1 ulp", -1.0)):
        towards = side * np.sign(direction[axis]) * np.inf
        shifts[_NAMES.index(name), axis] = np.nextafter(touching[axis], towards)
    return np.asarray(shifts)


def _shared(p: Body, r: Body, place: Place, shifts: Floats) -> Bools:
    poses_p, poses_r = place.poses(shifts)
    return np.asarray(decided(p, poses_p, r, poses_r) != 0)


def _halved(p: Body, r: Body, place: Place, shared: Floats, free: Floats) -> tuple[Floats, Floats]:
    """Two shifts between a shared one and a free one, neighbours on the way: the first is shared, the second free."""
    for _ in range(_MOST_HALVINGS):
        middle = shared + (free - shared) / 2
        if (middle == shared).all() or (middle == free).all():
            break
        if _shared(p, r, place, middle[None])[0]:
            shared = middle
        else:
            free = middle
    return shared, free


def _point_of(body: Body, rng: np.random.Generator) -> Floats:
    """A corner, an edge's middle or a point in a triangle, (3,), m; exact on a lattice."""
    corners = body.surface.points[body.surface.triangles[rng.integers(len(body.surface.triangles))]]
    weights = ([1.0, 0, 0], [0.5, 0.5, 0], [0.5, 0.25, 0.25])[rng.integers(3)]
    return np.asarray(np.array(weights) @ rng.permutation(corners))
