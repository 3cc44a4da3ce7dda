"""Bodies whose coordinates are of very different sizes, some with a polar that overflows, against exact arithmetic."""

import exact_verdicts
import numpy as np
import pytest

import plannercheck as pc

METHODS = ("oracle", "walk", "exact")
EXPONENTS = np.array([-323, -320, -310, -300, -200, -162, -155, -100, -50, -10, -3, 0, 3, 10, 30, 45, 49])
LARGEST = 1e50


def points(rng):
    """Points (k, 3), scaled as a whole, by axes, one by one, or each coordinate by itself."""
    k = int(rng.choice([1, 2, 3, 4, 5, 8, 12, 40]))
    p = rng.normal(size=(k, 3)) if rng.integers(3) else rng.integers(-2, 3, size=(k, 3)).astype(float)
    p *= 10.0 ** rng.choice(EXPONENTS, [(1, 1), (1, 3), (k, 1), (k, 3)][rng.integers(4)])
    if rng.integers(3) == 0:
        p[rng.integers(k), rng.integers(3)] = rng.choice([LARGEST, -LARGEST, 5e-324, 0.0])
    if rng.integers(4) == 0:
        p += rng.normal(size=3) * 10.0 ** rng.choice(EXPONENTS)
    return np.clip(p, -LARGEST, LARGEST)


def pose(rng):
    m = np.eye(4)
    kind = rng.integers(4)
    if kind == 1:
        q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        m[:3, :3] = q * np.sign(np.linalg.det(q))
    if kind:
        m[:3, 3] = rng.normal(size=3) * 10.0 ** rng.choice(EXPONENTS[:-2]) * (rng.random(3) < 0.6)
    return m


@pytest.mark.parametrize("seed", range(8))
def test_verdicts_are_those_of_exact_arithmetic(seed):
    rng = np.random.default_rng([seed, 1])
    for _ in range(120):
        a, b = points(rng), points(rng)
        b = a if rng.integers(4) == 0 else b
        p, r = (pc.Polytope(each, inflation_radius=rng.choice([0, 0, 1e-300, 1e-160, 1e-3, 1e30])) for each in (a, b))
        x, y = pose(rng), pose(rng)
        y = x if rng.integers(3) == 0 else y
        truth = exact_verdicts.intersects(p.vertices, r.vertices, x, y, p.inflation_radius, r.inflation_radius)
        assert [pc.intersects(p, r, x, y, method=method) for method in METHODS] == [truth] * 3
        assert pc.intersects(p, r, np.stack([x, x]), np.stack([y, y])).tolist() == [truth] * 2
        if rng.integers(4) == 0:
            certificate = pc.certify(p, r, x, y)
            assert isinstance(certificate, pc.SharedPoint) == truth
            assert certificate.verify()


# Doubles hold no polar of these: it has infinite coordinates beside finite ones.
NEEDLES = {
    "of denormals": [
        [1.0697e-320, 1.6699e-321, 4.2292e-321],
        [4.9950e-321, -7.1343e-321, -6.7440e-321],
        [-1.0321e-320, 1.3977e-320, 3.0187e-321],
        [8.0533e-321, 4.0563e-321, -2.8656e-321],
        [1e50, -3.0731e-321, -3.2687e-320],
    ],
    "across the range": [[0, 0, 0], [1e50, 0, 0], [0, 1e-300, 0], [0, 0, 1e-300], [1e50, 1e-300, 1e-300]],
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", NEEDLES)
def test_a_body_whose_polar_overflows_meets_itself(name, method):
    body = pc.Polytope(np.array(NEEDLES[name]))
    assert pc.intersects(body, body, method=method)
    assert pc.certify(body, body, method=method).verify()
    assert body.fault() == ""
