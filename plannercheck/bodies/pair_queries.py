"""Queries on a pair of bodies in one call of the core, which looks at bodies and poses itself.

In: what users pass to `intersects` and `distance`. Out: the answer, or None for all but a `Polytope` or `Placed` with
poses in NumPy arrays of doubles that are surely rigid. For those `given_bodies` converts, or says what is wrong.
"""

from __future__ import annotations

from typing import Any

from plannercheck.bodies.placed import Placed
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import RIGID_TOLERANCE
from plannercheck.common.core import core

queries: Any = core.PairQueries(Polytope, Placed, RIGID_TOLERANCE)
