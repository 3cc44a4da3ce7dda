"""Queries on a pair of bodies in one call of the core, which checks bodies and poses itself.

In: the arguments of `intersects` and `distance`. Out: the answer for `Polytope` and `Placed` with poses in NumPy arrays
of doubles that are surely rigid, else None: then `given_bodies` converts the arguments, or reports their fault.
"""

from __future__ import annotations

from typing import Any

from plannercheck.bodies.placed import Placed
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import RIGID_TOLERANCE
from plannercheck.common.core import core

queries: Any = core.PairQueries(Polytope, Placed, RIGID_TOLERANCE)
