"""Convex polytopes in any dimension: do two share a point (paper, "Detecting intersections in higher dimensions").

In: `Polytope`s, from points or from halfspaces, at any affine poses. Out: exact verdicts (`intersects`), certificates
(`certify`), which regions of a set meet (`overlap_graph`), and moving bodies in space-time (`sweeps`).

Which statement of the paper is where:

- polar of points, planes, polytopes, the lemmas and the theorem: `plannercheck.ndim.polar`, as properties in its test;
- Lemma "Simplex lemma", shell simplices: `polar.shell_simplices`, and `Cones` in `tree`;
- Lemma "Hierarchical Construction in R^d": `tree`, which lists where it departs from the text;
- "Testing intersection in higher dimensions", separation and inverse separation invariant: `walk`;
- certificates of logarithmic size: `Separation.hyperplanes`, `SharedPoint.halfspaces`.

Departures, and why the bounds hold. General position by simulation of simplicity is not needed: qhull triangulates
facets, and nothing relies on the trees being right. The text's pruning leaves out a body strictly inside the other;
`walk` asks for that first, one more walk of O(log n). The certificate of O(log n) hyperplanes proves that the bodies
are apart only all together; so from them one hyperplane is computed, which `verify` can check by itself. In theory the
last step is a game of O(log n) constant size; here it is a scan of all vertices with a proven error bound, or integers,
as a scan in NumPy costs no more than a level or two of a walk in Python at most sizes whose trees fit in memory. So
rounds and visited vertices of the walk grow with the logarithm, but the time of a query does not show it: `Effort`
counts both parts apart, and tests/benchmarks/ndim.py prints them.

Which method: the oracle needs no preparation and, as its scans run in NumPy and the walk in Python, answers faster at
all sizes whose trees fit in memory. So `auto` takes it. Trees take up to minutes and some hundred megabytes to build
(the same script prints them); they are built only for `method="tree"`, whose rounds and visited vertices grow with the
logarithm, and whose certificates hold its hyperplanes.
"""

from __future__ import annotations

from plannercheck.ndim.bodies import DEFAULT_MEMORY, Polytope
from plannercheck.ndim.certificates import Certificate, Effort, Separation, SharedPoint
from plannercheck.ndim.graph import OverlapGraph, overlap_graph
from plannercheck.ndim.pair import METHODS, certify, intersects, verdict
from plannercheck.ndim.sweeps import sweeps

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
    "sweeps",
    "verdict",
]
