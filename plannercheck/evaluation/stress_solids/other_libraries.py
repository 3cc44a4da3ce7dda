"""FCL and coal on the pairs of the stress of solids: trees of triangles, which are surfaces, for comparison.

In: a draw. Out: the verdicts of each on every pair, where both bodies are without an inflation radius.
"""

from __future__ import annotations

from typing import Any

from plannercheck.bodies.coal_bodies import coal_mesh
from plannercheck.evaluation.stress.other_libraries import CoalLibrary, FclLibrary
from plannercheck.evaluation.stress_solids.bodies import Body


class FclMeshes(FclLibrary[Body]):
    """python-fcl's BVHModel, by its own defaults."""

    def shape(self, body: Body) -> Any:
        """See `Library`."""
        if body.inflation_radius:
            return None
        points, triangles = body.whole.points, body.whole.triangles
        model = self._fcl.BVHModel()
        model.beginModel(len(points), len(triangles))
        model.addSubModel(points, triangles)
        model.endModel()
        return model


class CoalMeshes(CoalLibrary[Body]):
    """coal's BVHModelOBBRSS, by its own defaults."""

    def shape(self, body: Body) -> Any:
        """See `Library`."""
        return None if body.inflation_radius else coal_mesh(body.whole.points, body.whole.triangles)
