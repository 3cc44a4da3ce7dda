"""Convex polytopes in any dimension: do two share a point (paper, "Detecting intersections in higher dimensions").

In: `Polytope`s, from points or from halfspaces, at any affine poses. Out: exact verdicts (`intersects`), certificates
(`certify`), and which regions of a set meet (`overlap_graph`).
"""

from __future__ import annotations

from plannercheck.ndim.bodies import DEFAULT_MEMORY, Polytope
from plannercheck.ndim.certificates import Certificate, Effort, Separation, SharedPoint
from plannercheck.ndim.graph import OverlapGraph, overlap_graph
from plannercheck.ndim.pair import METHODS, certify, intersects, verdict

__all__ = [
    "DEFAULT_MEMORY",
    "METHODS",
    "Certificate",
    "Effort",
    "OverlapGraph",
    "Polytope",
    "Separation",
    "SharedPoint",
    "certify",
    "intersects",
    "overlap_graph",
    "verdict",
]
