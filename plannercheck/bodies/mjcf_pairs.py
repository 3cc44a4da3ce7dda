"""Which geoms of an MJCF file MuJoCo tests against each other, and which are obstacles.

In: a compiled file. Out: pairs of geoms, exactly those that `mj_collision` tests (engine_collision_driver.c): contype
of one geom and conaffinity of the other have to share a bit. Left out are bodies that are welded together or excluded,
and a body and the next body above it that moves against it, unless that body is welded to the world or the file
disables this filter. A <pair> passes all of these filters. Margins and gaps widen contacts, not bodies: they decide
nothing here.

A child of the world without joints on it or below it is no part of a robot: its geoms are obstacles, as are the world's
geoms, planes and height fields, which only static bodies have.
"""

from __future__ import annotations

import numpy as np

from plannercheck.bodies.mjcf_files import (
    HFIELD,
    PLANE,
    Integers,
    MjcfFile,
)
from plannercheck.common.array_types import Bools
from plannercheck.common.arrays import distinct_rows

# Two bodies by one number, in MuJoCo's signatures of excluded pairs.
_BODIES = 1 << 16


def tested_pairs(file: MjcfFile) -> Integers:
    """(k, 2) the geoms that MuJoCo tests against each other, in ascending order."""
    if file.disabled & {"CONSTRAINT", "CONTACT"}:
        return np.empty((0, 2), dtype=np.int64)
    shown = np.flatnonzero((file.geom_contype | file.geom_conaffinity) != 0)
    rows, columns = np.triu_indices(len(shown), 1)
    first, second = shown[rows], shown[columns]
    kept = _masks_meet(file, first, second)
    first, second = first[kept], second[kept]
    kept = _bodies_meet(file, file.geom_bodyid[first], file.geom_bodyid[second])
    by_masks = np.stack([first[kept], second[kept]], axis=1)
    named = np.sort(np.stack([file.pair_geom1, file.pair_geom2], axis=1), axis=1)
    pairs = distinct_rows(np.concatenate([by_masks, named]).reshape(-1, 2))[0]
    surfaces = np.isin(file.geom_type[pairs], (PLANE, HFIELD)).all(axis=1)  # MuJoCo has no function for two of these
    return np.asarray(pairs[~surfaces])


def colliding_geoms(file: MjcfFile) -> Bools:
    """(geoms,) which geoms can collide: by their masks, or as they are named in a <pair>."""
    shown: Bools = np.asarray((file.geom_contype | file.geom_conaffinity) != 0)
    shown[file.pair_geom1], shown[file.pair_geom2] = True, True
    return shown


def robot_geoms(file: MjcfFile) -> Integers:
    """The geoms that can collide and are on links, in ascending order."""
    return np.flatnonzero(colliding_geoms(file) & _is_of_robot(file))


def obstacle_geoms(file: MjcfFile) -> Integers:
    """The geoms that can collide and are obstacles, in ascending order."""
    return np.flatnonzero(colliding_geoms(file) & ~_is_of_robot(file))


def _is_of_robot(file: MjcfFile) -> Bools:
    on_link = file.is_of_robot[file.geom_bodyid]
    stands_still = file.body_dofnum[file.body_weldid[file.geom_bodyid]] == 0
    return np.asarray(on_link & ~(stands_still & np.isin(file.geom_type, (PLANE, HFIELD))))


def _masks_meet(file: MjcfFile, first: Integers, second: Integers) -> Bools:
    types, affinities = file.geom_contype, file.geom_conaffinity
    return np.asarray(((types[first] & affinities[second]) | (types[second] & affinities[first])) != 0)


def _bodies_meet(file: MjcfFile, first: Integers, second: Integers) -> Bools:
    """(k,) which pairs of bodies pass the filters."""
    welds = file.body_weldid
    parents = welds[file.body_parentid[welds]]  # the next body above that moves, by body
    a, b = welds[first], welds[second]
    can_move = (file.body_dofnum[a] > 0) | (file.body_dofnum[b] > 0)
    meet = (a != b) & can_move
    if "FILTERPARENT" not in file.disabled:
        next_to = (a == parents[second]) | (b == parents[first])
        meet &= ~(next_to & (a != 0) & (b != 0))
    low, high = np.sort([first, second], axis=0)
    one, other = np.sort([file.exclude_signature // _BODIES, file.exclude_signature % _BODIES], axis=0)
    return np.asarray(meet & ~np.isin(low * _BODIES + high, one * _BODIES + other))
