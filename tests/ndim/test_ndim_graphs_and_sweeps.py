"""Any dimension: which regions of a set overlap, and what moving bodies sweep in space-time."""

import itertools

import numpy as np
import pytest
from ndim_pairs import both_kinds, box

import plannercheck as pc
from plannercheck import ndim


def test_overlap_graph_against_all_pairs():
    rng = np.random.default_rng(0)
    regions = []
    for _ in range(25):
        low = rng.integers(0, 6, size=3).astype(np.float64)
        regions.append(both_kinds(low, low + rng.integers(1, 3, size=3))[int(rng.integers(2))])
    graph = ndim.overlap_graph(regions)
    truth = [
        (i, j)
        for i, j in itertools.combinations(range(len(regions)), 2)
        if ndim.intersects(regions[i], regions[j], method="exact")
    ]
    assert graph.edges.tolist() == [list(edge) for edge in truth]
    assert graph.tested + graph.skipped == 300
    assert graph.tested >= len(truth) > 0
    path = graph.path(*truth[0])
    assert path == list(truth[0])
    assert graph.path(3, 3) == [3]
    assert ndim.overlap_graph([]).edges.shape == (0, 2)


def test_swept_bodies_in_space_time():
    """Two boxes that pass each other: their sweeps in (x, y, z, t) meet exactly if the boxes ever do."""
    cube = box([0, 0, 0], [1, 1, 1])

    def sweep(start, end):
        return ndim.sweeps(cube, [start, end], [0.0, 1.0])[0]

    first = sweep([0.0, 0, 0], [4.0, 0, 0])
    # Crosses the same space, later; meets it; touches it with an edge at one moment.
    assert not ndim.intersects(first, sweep([2.0, -8, 0], [2.0, 0, 0]))
    assert ndim.intersects(first, sweep([2.0, -2, 0], [2.0, 2, 0]))
    assert ndim.intersects(first, sweep([2.0, -1, 0], [2.0, -1, 0]))
    assert not ndim.intersects(first, sweep([2.0, np.nextafter(-1, -2), 0], [2.0, np.nextafter(-1, -2), 0]))


def test_sweeps_against_moments():
    """Bodies on paths of three pieces: no moment collides where no sweeps meet, and a common point says where."""
    rng = np.random.default_rng(0)
    bodies = [rng.normal(size=(8, 3)) for _ in range(2)]
    in_space = [pc.Polytope(points) for points in bodies]
    times, met = np.array([0.0, 1.0, 2.5, 3.0]), 0

    def poses(waypoints, moments):
        matrices = np.tile(np.eye(4), (len(moments), 1, 1))
        matrices[:, :3, 3] = np.column_stack([np.interp(moments, times, column) for column in waypoints.T])
        return matrices

    for _ in range(15):
        ways = [3.0 * rng.normal(size=(4, 3)) for _ in range(2)]
        first, second = (ndim.sweeps(points, way, times) for points, way in zip(bodies, ways, strict=True))
        certificates = [ndim.certify(a, b) for a, b in zip(first, second, strict=True)]
        for k, certificate in enumerate(certificates):
            if certificate.shares:
                moments = certificate.point[3:]
                assert times[k] <= moments[0] <= times[k + 1]
            else:
                moments = np.linspace(times[k], times[k + 1], 20)
            for pair in zip(*(poses(way, moments) for way in ways), strict=True):
                # The moment is rounded, so bodies that only touch may be a rounding apart.
                apart = pc.distance(*in_space, *pair).distance
                assert apart <= 1e-12 if certificate.shares else not pc.intersects(*in_space, *pair)
        met += any(certificate.shares for certificate in certificates)
    assert 0 < met < 15


@pytest.mark.parametrize(
    ("waypoints", "times", "words"),
    [
        ([[0.0, 0, 0]], [0.0], "at least two waypoints"),
        ([[0.0, 0], [1, 1]], [0.0, 1], "at least two waypoints"),
        ([[0.0, 0, 0], [1, 1, 1]], [0.0, 0], "ascending"),
        ([[0.0, 0, 0], [1, 1, 1j]], [0.0, 1], "waypoints must be numbers"),
        (np.ma.masked_equal([[0.0, 0, 0], [1, 1, 1]], 1), [0.0, 1], "masked"),
        ([[0.0, 0, 0], [1, 1, 1]], [0.0, [1]], "times must be numbers"),
    ],
)
def test_paths_that_are_none(waypoints, times, words):
    with pytest.raises(pc.PlannercheckError, match=words):
        ndim.sweeps(box([0, 0, 0], [1, 1, 1]), waypoints, times)


@pytest.mark.parametrize(("start", "goal"), [(0, 2), (2, 0), (-1, 0), (0, 0.5), ("a", 0)])
def test_paths_lead_from_region_to_region(start, goal):
    square = ndim.Polytope(box([0, 0], [1, 1]))
    with pytest.raises(pc.PlannercheckError, match="a region must be one of 2, from 0 on"):
        ndim.overlap_graph([square, square]).path(start, goal)
