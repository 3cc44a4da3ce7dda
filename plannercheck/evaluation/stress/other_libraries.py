"""FCL and coal on the pairs of the stress suite, for comparison: neither claims to be exact.

In: a draw. Out: the verdicts of each on every pair for which it has both shapes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from plannercheck.bodies.coal_bodies import coal_hull
from plannercheck.bodies.fcl_bodies import fcl_hull, load_fcl
from plannercheck.evaluation.campaign.posed_pairs import UNFIT, Outcome
from plannercheck.evaluation.campaign.supervised_process import Posed
from plannercheck.evaluation.campaign.tallies import EXCEPTION
from plannercheck.evaluation.stress.random_cases import Draw
from plannercheck.evaluation.stress.sample_bodies import Specimen


class Fcl:
    """python-fcl, by its own defaults."""

    name = "fcl"

    def __init__(self) -> None:
        """Raises PlannercheckError if python-fcl is not installed."""
        self._fcl = load_fcl()
        self._request = self._fcl.CollisionRequest(num_max_contacts=1, enable_contact=False)

    def outcomes(self, drawn: Draw, first: int = 0) -> Iterator[Outcome]:
        """See `Peer`."""
        return _outcomes(drawn, first, self._shape, self._collide)

    def _shape(self, body: Specimen) -> Any:
        if body.inflation_radius:
            return _inflated_shape(body, self._fcl.Sphere, self._fcl.Capsule)
        if body.polytope.dimension < 3:
            return None
        return fcl_hull(body.vertices, body.polytope.faces)

    def _collide(self, p: Any, pose_p: Any, r: Any, pose_r: Any) -> bool:
        placed = [
            self._fcl.CollisionObject(shape, self._fcl.Transform(pose[:3, :3], pose[:3, 3]))
            for shape, pose in ((p, pose_p), (r, pose_r))
        ]
        return bool(self._fcl.collide(*placed, self._request, self._fcl.CollisionResult()))


class Coal:
    """coal, by its own defaults."""

    name = "coal"

    def __init__(self) -> None:
        import coal

        self._coal = coal
        self._request = coal.CollisionRequest()

    def outcomes(self, drawn: Draw, first: int = 0) -> Iterator[Outcome]:
        """See `Peer`."""
        return _outcomes(drawn, first, self._shape, self._collide)

    def _shape(self, body: Specimen) -> Any:
        if body.inflation_radius:
            return _inflated_shape(body, self._coal.Sphere, self._coal.Capsule)
        if body.polytope.dimension < 3:
            return None
        return coal_hull(body.polytope, body.family)

    def _collide(self, p: Any, pose_p: Any, r: Any, pose_r: Any) -> bool:
        placed = (self._coal.Transform3s(pose[:3, :3], pose[:3, 3]) for pose in (pose_p, pose_r))
        tf_p, tf_r = placed
        result = self._coal.CollisionResult()
        self._coal.collide(p, tf_p, r, tf_r, self._request, result)
        return bool(result.isCollision())


def _inflated_shape(body: Specimen, sphere: Callable[[float], Any], capsule: Callable[[float, float], Any]) -> Any:
    """A sphere or capsule about the origin; None for anything else."""
    low, high = body.vertices[0], body.vertices[-1]
    if body.polytope.dimension > 1 or (low + high).any() or low[:2].any():
        return None
    return (
        sphere(body.inflation_radius)
        if body.polytope.dimension == 0
        else capsule(body.inflation_radius, 2 * abs(float(low[2])))
    )


def _outcomes(
    drawn: Draw, first: int, shape_of: Callable[[Specimen], Any], collide: Callable[[Any, Any, Any, Any], bool]
) -> Iterator[Outcome]:
    return outcomes_of_shapes(_shape(shape_of, drawn.p), _shape(shape_of, drawn.r), drawn, first, collide)


def outcomes_of_shapes(
    p: Any, r: Any, drawn: Posed, first: int, collide: Callable[[Any, Any, Any, Any], bool]
) -> Iterator[Outcome]:
    """What a library says of its shapes at all poses from a pair on; a shape may be UNFIT or EXCEPTION."""
    failed = next(
        (reason for reason in (UNFIT, EXCEPTION) if any(isinstance(s, str) and s == reason for s in (p, r))), None
    )
    for a, b in zip(drawn.poses_p[first:], drawn.poses_r[first:], strict=True):
        yield failed or _outcome(collide, p, a, r, b)


def _shape(shape_of: Callable[[Specimen], Any], body: Specimen) -> Any:
    """The peer's shape, or why there is none."""
    try:
        return shape_of(body) or UNFIT
    except Exception:
        return EXCEPTION


def _outcome(collide: Callable[[Any, Any, Any, Any], bool], p: Any, pose_p: Any, r: Any, pose_r: Any) -> Outcome:
    try:
        return collide(p, pose_p, r, pose_r)
    except Exception:
        return EXCEPTION
