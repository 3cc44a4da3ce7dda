"""Curves of the motion stress: polynomials of degree 1 to 7 through the states at which bodies touch by construction.

In: a draw of straight motions, a random generator. Out: a draw of curves. Each passes the state of one of the motions,
at any instant or at an instant at which the certifier cuts, in the direction of the motion or without speed, gently or
with a swing. If a curve has a tube, a corner of the tube passes the state.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import comb

import numpy as np

from plannercheck.common.array_types import Bools, Floats
from plannercheck.evaluation.stress_motions.aims import Motions
from plannercheck.evaluation.stress_motions.curve_numbers import rows_of, unit_columns
from plannercheck.evaluation.stress_motions.draws import Draw
from plannercheck.evaluation.stress_motions.recipes import SpaceRecipe, space_checker

MOST_DEGREE = 7
# Curves through the state of each motion: so many that building robots and checkers takes no more time than judging.
_EACH = 5
# Instants at which curves are cut, and so far beside them, as powers of ten.
_CUTS, _BESIDE = (0.0, 1.0, 0.5, 0.25, 0.75, 1 / 64, 0.328125), (-12.0, -3.0)
_AT_A_CUT, _BESIDE_A_CUT, _STANDING = 0.4, 0.3, 0.2
# How far control points are off a straight line, as powers of ten of its length: gentle, or a swing; or only one is.
_BENDS, _ONE_ALONE, _SLOPE_AS_IT_COMES = ((-2.0, 0.0), (0.0, 2.0)), 0.3, 0.3
_LARGEST_BEND, _LONGEST_LINE = 20.0, 10.0
# Draws with a tube, and its size, rad and m, as powers of ten; numbers without; tries to find a corner that is free.
_TUBES, _SIZES, _WITHOUT, _CORNERS = 0.4, (-5.0, -0.8), 0.3, 4
# Numbers so large that a corner of a tube is rounded by more than contacts are deep.
_FAR = 1e5
# So many boxes and hulls become the clouds of their corners.
_CLOUDS = 0.2


def curved(draw: Draw, rng: np.random.Generator) -> Draw:
    """A draw of curves through the states of a draw of motions."""
    recipe, motions = draw.recipe, draw.motions.of(np.tile(np.arange(len(draw.motions.at)), _EACH))
    assert recipe["kind"] == "space"
    recipe = {**recipe, "curved": True, "path": "slerp"}
    _scatter(recipe, rng)
    checker = space_checker(recipe)
    units = unit_columns(checker.robot)
    at = motions.at if units.any() or np.abs(motions.through).max() > _FAR else instants(motions.at, rng)
    tube, middle = tube_around(checker.check_states, motions.through, units, rng)
    points = points_through(motions, at, middle, int(rng.integers(1, MOST_DEGREE + 1)), rng)
    points[:, :, units] = motions.through[:, None, units]
    points[:, 0, units], points[:, -1, units] = motions.q0[:, units], motions.q1[:, units]
    made = Motions(*rows_of(points, tube), at, motions.through, motions.touching)
    return replace(draw, recipe=recipe, motions=made)


def _scatter(recipe: SpaceRecipe, rng: np.random.Generator) -> None:
    """Some obstacles become clouds of their corners; the corner that touches is one of them."""
    recipe["obstacles"] = [dict(body) for body in recipe["obstacles"]]  # type: ignore[misc]
    for body in recipe["obstacles"]:
        if body["shape"][0] in ("box", "hull") and rng.random() < _CLOUDS:
            body["shape"] = ["corners", body["shape"]]


def instants(at: Floats, rng: np.random.Generator) -> Floats:
    """Instants (n,) of contacts: as they are, at a cut, or beside one."""
    n = len(at)
    cuts = rng.choice(_CUTS, n)
    beside = cuts + rng.choice([-1.0, 1.0], n) * 10.0 ** rng.uniform(*_BESIDE, n)
    cuts = np.where(rng.random(n) < _BESIDE_A_CUT, np.clip(beside, 0.0, 1.0), cuts)
    return np.where(rng.random(n) < _AT_A_CUT, cuts, at)


def tube_around(
    check: Callable[[Floats], Bools], through: Floats, units: Bools, rng: np.random.Generator
) -> tuple[Floats, Floats]:
    """A tube (nq,), and the states (n, nq) of whose tube a corner is the contact: free ones if a few tries find any."""
    n, nq = through.shape
    if rng.random() >= _TUBES or np.abs(through).max() > _FAR:
        return np.zeros(nq), through
    tube = 10.0 ** rng.uniform(*_SIZES) * rng.uniform(0.1, 1.0, nq)
    tube[units | (rng.random(nq) < _WITHOUT)] = 0.0
    middle = through - tube * rng.choice([-1.0, 1.0], (n, nq))
    for _ in range(_CORNERS):
        blocked = np.flatnonzero(~check(middle))
        middle[blocked] = through[blocked] - tube * rng.choice([-1.0, 1.0], (len(blocked), nq))
    return tube, middle


def points_through(motions: Motions, at: Floats, middle: Floats, degree: int, rng: np.random.Generator) -> Floats:
    """Control points (n, degree + 1, nq) of curves that pass the states in the middle at instants (n,)."""
    n, nq = middle.shape
    line = motions.q1 - motions.q0
    length = np.abs(line).max(axis=1)
    line *= np.minimum(1.0, _LONGEST_LINE / np.maximum(length, 1e-300))[:, None]
    line[rng.random(n) < _STANDING] = 0.0
    least, most = np.array(_BENDS)[rng.integers(0, len(_BENDS), n)].T
    sizes = np.minimum(length * 10.0 ** rng.uniform(least, most), _LARGEST_BEND)
    bends = rng.normal(size=(n, degree + 1, nq)) * sizes[:, None, None]
    alone = np.arange(degree + 1) == rng.integers(0, degree + 1, (n, 1))
    bends[(rng.random((n, 1)) < _ONE_ALONE) & ~alone] = 0.0
    bends -= np.einsum("nk,nkc->nc", _weights(degree, at), bends)[:, None]
    slope = degree * np.einsum("nk,nkc->nc", _weights(degree - 1, at), np.diff(bends, axis=1))
    slope[rng.random(n) < _SLOPE_AS_IT_COMES] = 0.0
    places = np.arange(degree + 1) / degree - at[:, None]
    points = np.asarray(middle[:, None] + places[:, :, None] * (line - slope)[:, None] + bends)
    points[at == 0, 0], points[at == 1, -1] = middle[at == 0], middle[at == 1]
    return points


def _weights(degree: int, at: Floats) -> Floats:
    """Bernstein's polynomials (n, degree + 1) at instants (n,)."""
    k = np.arange(degree + 1)
    choices = np.array([comb(degree, each) for each in k], dtype=np.float64)
    return np.asarray(choices * at[:, None] ** k * (1 - at[:, None]) ** (degree - k))
