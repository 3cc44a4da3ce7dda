"""FCL and coal on the pairs of the stress suite, for comparison: neither claims to be exact.

In: a draw. Out: each library's verdicts on every pair for which it has both shapes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from typing import Any, Generic

from plannercheck.bodies.coal_bodies import coal_hull
from plannercheck.bodies.fcl_bodies import fcl_hull, load_fcl
from plannercheck.evaluation.campaign.posed_pairs import UNFIT, AnyBody, Outcome, PosedPairs
from plannercheck.evaluation.campaign.tallies import EXCEPTION
from plannercheck.evaluation.stress.sample_bodies import Specimen


class Library(ABC, Generic[AnyBody]):
    """Another library: a `Peer`, by its own defaults."""

    name: str

    @abstractmethod
    def shape(self, body: AnyBody) -> Any:
        """Its shape; None where it has none for the body."""

    @abstractmethod
    def collide(self, p: Any, pose_p: Any, r: Any, pose_r: Any) -> bool:
        """Whether two shapes collide at poses (4, 4), m."""

    def outcomes(self, drawn: PosedPairs[AnyBody], first: int = 0) -> Iterator[Outcome]:
        """See `Peer`."""
        try:
            p, r = self.shape(drawn.p), self.shape(drawn.r)
            failed = UNFIT if p is None or r is None else ""
        except Exception:
            failed = EXCEPTION
        for pose_p, pose_r in zip(drawn.poses_p[first:], drawn.poses_r[first:], strict=True):
            try:
                yield failed or self.collide(p, pose_p, r, pose_r)
            except Exception:
                yield EXCEPTION


class FclLibrary(Library[AnyBody]):
    """python-fcl."""

    name = "fcl"

    def __init__(self) -> None:
        """Raises PlannercheckError if python-fcl is not installed."""
        self._fcl = load_fcl()
        self._request = self._fcl.CollisionRequest(num_max_contacts=1, enable_contact=False)

    def collide(self, p: Any, pose_p: Any, r: Any, pose_r: Any) -> bool:
        """Whether two shapes collide."""
        placed = [
            self._fcl.CollisionObject(shape, self._fcl.Transform(pose[:3, :3], pose[:3, 3]))
            for shape, pose in ((p, pose_p), (r, pose_r))
        ]
        return bool(self._fcl.collide(*placed, self._request, self._fcl.CollisionResult()))


class CoalLibrary(Library[AnyBody]):
    """coal."""

    name = "coal"

    def __init__(self) -> None:
        import coal

        self._coal = coal
        self._request = coal.CollisionRequest()

    def collide(self, p: Any, pose_p: Any, r: Any, pose_r: Any) -> bool:
        """Whether two shapes collide."""
        tf_p, tf_r = (self._coal.Transform3s(pose[:3, :3], pose[:3, 3]) for pose in (pose_p, pose_r))
        result = self._coal.CollisionResult()
        self._coal.collide(p, tf_p, r, tf_r, self._request, result)
        return bool(result.isCollision())


class Fcl(FclLibrary[Specimen]):
    """python-fcl's hulls, spheres and capsules."""

    def shape(self, body: Specimen) -> Any:
        """See `Library`."""
        if body.inflation_radius:
            return _inflated_shape(body, self._fcl.Sphere, self._fcl.Capsule)
        return fcl_hull(body.vertices, body.polytope.faces) if body.polytope.dimension == 3 else None


class Coal(CoalLibrary[Specimen]):
    """coal's hulls, spheres and capsules."""

    def shape(self, body: Specimen) -> Any:
        """See `Library`."""
        if body.inflation_radius:
            return _inflated_shape(body, self._coal.Sphere, self._coal.Capsule)
        return coal_hull(body.polytope, body.family) if body.polytope.dimension == 3 else None


def _inflated_shape(body: Specimen, sphere: Callable[[float], Any], capsule: Callable[[float, float], Any]) -> Any:
    """A sphere or capsule about the origin; None for anything else."""
    low, high = body.vertices[0], body.vertices[-1]
    if body.polytope.dimension > 1 or (low + high).any() or low[:2].any():
        return None
    if body.polytope.dimension == 0:
        return sphere(body.inflation_radius)
    return capsule(body.inflation_radius, 2 * abs(float(low[2])))
