"""FCL and coal on the pairs of the stress of solids: trees of triangles, which are surfaces, for comparison.

In: a draw. Out: the verdicts of each on every pair, where both bodies are without an inflation radius.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from plannercheck.bodies.coal_bodies import coal_mesh
from plannercheck.bodies.fcl_bodies import load_fcl
from plannercheck.evaluation.campaign.posed_pairs import UNFIT, Outcome
from plannercheck.evaluation.stress.other_libraries import outcomes_of_shapes
from plannercheck.evaluation.stress_solids.bodies import Body
from plannercheck.evaluation.stress_solids.draws import Draw


class FclMeshes:
    """python-fcl's BVHModel, by its own defaults."""

    name = "fcl"

    def __init__(self) -> None:
        """Raises PlannercheckError if python-fcl is not installed."""
        self._fcl = load_fcl()
        self._request = self._fcl.CollisionRequest(num_max_contacts=1, enable_contact=False)

    def outcomes(self, drawn: Draw, first: int = 0) -> Iterator[Outcome]:
        """See `plannercheck.evaluation.campaign.supervised_process.Peer`."""
        return outcomes_of_shapes(self._model(drawn.p), self._model(drawn.r), drawn, first, self._collide)

    def _model(self, body: Body) -> Any:
        if body.inflation_radius:
            return UNFIT
        points, triangles = body.whole.points, body.whole.triangles
        model = self._fcl.BVHModel()
        model.beginModel(len(points), len(triangles))
        model.addSubModel(points, triangles)
        model.endModel()
        return model

    def _collide(self, p: Any, pose_p: Any, r: Any, pose_r: Any) -> bool:
        placed = [
            self._fcl.CollisionObject(model, self._fcl.Transform(pose[:3, :3], pose[:3, 3]))
            for model, pose in ((p, pose_p), (r, pose_r))
        ]
        return bool(self._fcl.collide(*placed, self._request, self._fcl.CollisionResult()))


class CoalMeshes:
    """coal's BVHModelOBBRSS, by its own defaults."""

    name = "coal"

    def __init__(self) -> None:
        import coal

        self._coal = coal
        self._request = coal.CollisionRequest()

    def outcomes(self, drawn: Draw, first: int = 0) -> Iterator[Outcome]:
        """See `plannercheck.evaluation.campaign.supervised_process.Peer`."""
        return outcomes_of_shapes(self._model(drawn.p), self._model(drawn.r), drawn, first, self._collide)

    def _model(self, body: Body) -> Any:
        if body.inflation_radius:
            return UNFIT
        return coal_mesh(body.whole.points, body.whole.triangles)

    def _collide(self, p: Any, pose_p: Any, r: Any, pose_r: Any) -> bool:
        first, second = (self._coal.Transform3s(pose[:3, :3], pose[:3, 3]) for pose in (pose_p, pose_r))
        result = self._coal.CollisionResult()
        self._coal.collide(p, first, r, second, self._request, result)
        return bool(result.isCollision())
