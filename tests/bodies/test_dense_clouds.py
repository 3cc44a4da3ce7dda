"""Bodies before surfaces of thousands of points, as close as rounding: what ends whole nodes leaves no ball out."""

from typing import Any

import numpy as np
import pytest

import plannercheck as pc

SIDE = 70
BODIES = ["box", "hull", "ball", "capsule", "inflated hull", "polygon", "point"]


def body_of(kind: str, rng: np.random.Generator) -> pc.Polytope:
    corners = rng.normal(size=(40, 3)) * [0.06, 0.1, 0.2]
    match kind:
        case "box":
            return pc.Polytope(pc.Box((0.2, 0.1, 0.3)))
        case "hull" | "inflated hull":
            return pc.Polytope(corners, inflation_radius=0.03 if kind.startswith("inflated") else 0.0)
        case "ball":
            return pc.Polytope([[0.01, 0.02, 0.03]], inflation_radius=0.1)
        case "capsule":
            return pc.Polytope(corners[:2], inflation_radius=0.04)
        case "polygon":
            return pc.Polytope(corners[:5] * [1, 1, 0])
        case _:
            return pc.Polytope(corners[:1])


def surface(rng: np.random.Generator, one_radius: bool) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """A rough sheet above the plane x, y, as a camera sees one."""
    x, y = (side.ravel() for side in np.meshgrid(*[np.linspace(-0.4, 0.4, SIDE)] * 2))
    z = 0.05 * np.sin(5 * x) * np.cos(4 * y) + rng.normal(size=x.size) * 0.002
    return np.stack([x, y, z], axis=1), rng.uniform(0.009, 0.012, size=1 if one_radius else x.size)


def turned(rng: np.random.Generator) -> np.ndarray[Any, Any]:
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    out = np.eye(4)
    out[:3, :3] = q * np.linalg.det(q)
    return out


def meets_a_ball(body: pc.Polytope, at: Any, balls: list[pc.Polytope], set_at: Any) -> bool:
    return any(pc.intersects(body, ball, at, set_at) for ball in balls)


@pytest.mark.parametrize("kind", BODIES)
@pytest.mark.parametrize("one_radius", [True, False])
def test_verdicts_close_to_a_surface_are_those_of_its_balls(kind: str, one_radius: bool) -> None:
    rng = np.random.default_rng([BODIES.index(kind), one_radius])
    points, radii = surface(rng, one_radius)
    cloud = pc.Polytope(pc.PointCloud(points, radii))
    each = np.resize(radii, len(points))
    alone = [pc.Polytope(points[k : k + 1], inflation_radius=each[k]) for k in range(len(points))]
    verdicts = []
    for _ in range(3):
        body, at, set_at = body_of(kind, rng), turned(rng), turned(rng)
        set_at[:3, 3] = rng.normal(size=3)
        up = set_at[:3, 2]
        at[:3, 3] = set_at[:3, :3] @ [*rng.uniform(-0.25, 0.25, size=2), 0.7] + set_at[:3, 3]
        apart = pc.distance(body, cloud, at, set_at).distance
        for _ in range(40):  # nearer by what is known to be free
            at[:3, 3] -= apart * up
            apart = pc.distance(body, cloud, at, set_at).distance
        middle = at[:3, 3].copy()
        around = np.linalg.norm((points @ set_at[:3, :3].T + set_at[:3, 3]) - middle, axis=1) < 0.8
        balls = [alone[k] for k in np.flatnonzero(around)]
        for step in (1e-4, 1e-6, 1e-9, 1e-13, 1e-16, 0.0, -1e-16, -1e-13, -1e-9, -1e-6, -1e-4, -1e-2):
            at[:3, 3] = middle + step * up
            expected = meets_a_ball(body, at, balls, set_at)
            assert pc.intersects(body, cloud, at, set_at) == expected
            assert pc.intersects(cloud, body, set_at, at) == expected
            verdicts.append(expected)
    assert 0.1 < np.mean(verdicts) < 0.9
