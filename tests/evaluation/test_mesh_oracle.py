"""The compiled oracle's verdicts on meshes, held against brute force written otherwise: pairs of triangles by Gilbert,
Johnson and Keerthi in Python's integers, winding numbers by signed tetrahedra in whole numbers."""

import itertools
import math
import random
from fractions import Fraction

import numpy as np
import pytest

from plannercheck import _oracle
from plannercheck.bodies import exact_reference as exact

EYE = np.eye(4)
TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], dtype=np.int32)
NONE, TRIANGLES, WITHIN_RADII, FIRST_INSIDE, SECOND_INSIDE = range(5)


def mesh(vertices, triangles, radius=0.0):
    return _oracle.Mesh(np.asarray(vertices, dtype=float), np.asarray(triangles, dtype=np.int32), radius)


def reason(p, r, pose_p=EYE, pose_r=EYE):
    """The oracle's, which has to be the same by whole numbers alone."""
    found, again = (
        int(_oracle.decide_meshes(p, np.array([pose_p]), r, np.array([pose_r]), every)[0]) for every in (False, True)
    )
    assert found == again
    return found


def quarter_turn(rng):
    turn = np.eye(4)
    turn[:3, :3] = np.eye(3)[rng.permutation(3)] * rng.choice([-1, 1], (3, 1))
    turn[:3, 3] = rng.integers(-2, 3, 3)
    return turn


def any_pose(rng):
    pose = np.eye(4)
    pose[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    pose[:3, 3] = rng.normal(size=3)
    return pose


def closed_soup(rng, steps):
    """A closed mesh of lattice points that crosses itself: two or three tetrahedra, or an octahedron's triangles."""
    if rng.integers(2):
        count = int(rng.integers(1, 4))
        points = rng.integers(0, steps + 1, (4 * count, 3))
        return points, np.vstack([TETRAHEDRON + 4 * k for k in range(count)])
    triangles = [[4, 0, 2], [4, 2, 1], [4, 1, 3], [4, 3, 0], [5, 2, 0], [5, 1, 2], [5, 3, 1], [5, 0, 3]]
    return rng.integers(0, steps + 1, (6, 3)), np.array(triangles)


def determinant(rows):
    (a, b, c), (d, e, f), (g, h, i) = rows
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def sign(x):
    return (x > 0) - (x < 0)


def winding_by_tetrahedra(vertices, triangles, point):
    """Signed tetrahedra between the triangles and an apex; another apex if the point is on the border of one."""
    numbers = random.Random(1)
    given = [[Fraction(x) for x in row] for row in (*vertices.tolist(), point)]
    # In whole numbers, of which all coordinates are multiples: sums of Fractions would be reduced each time.
    unit = math.lcm(*(x.denominator for row in given for x in row))
    *whole_vertices, point = [[97 * x.numerator * (unit // x.denominator) for x in row] for row in given]
    for _ in range(100):
        apex = [numbers.randrange(-999, 999) * unit for _ in range(3)]
        total, on_border = 0, False
        for triangle in triangles.tolist():
            corners = [*(whole_vertices[k] for k in triangle), apex]
            whole = sign(volume(corners))
            signs = [sign(volume([*corners[:k], point, *corners[k + 1 :]])) for k in range(4)]
            if whole == 0 or any(s == -whole for s in signs):
                continue
            on_border |= 0 in signs
            total += whole
        if not on_border:
            return total
    return None


def volume(corners):
    return determinant([[x - y for x, y in zip(corner, corners[3], strict=True)] for corner in corners[:3]])


def posed(vertices, pose):
    rows = [[Fraction(x) for x in row] for row in pose.tolist()]
    return [
        [sum((m * Fraction(x) for m, x in zip(row, v, strict=False)), row[3]) for row in rows[:3]]
        for v in np.asarray(vertices, dtype=float).tolist()
    ]


def triangles_of(vertices, triangles):
    return [np.asarray(vertices, dtype=float)[list(corners)] for corners in np.asarray(triangles).tolist()]


def triangles_meet(p, r, pose_p, pose_r, radii=(0.0, 0.0)):
    return any(exact.intersects(s, t, pose_p, pose_r, *radii) for s in p for t in r)


@pytest.mark.parametrize("steps", [2, 4, 1000])
def test_triangles_meet_as_their_hulls_do(steps):
    """Two triangles on a small lattice: in one plane, sharing corners and edges, segments and points among them."""
    rng, verdicts = np.random.default_rng(steps), []
    for _ in range(500):
        p, r = rng.integers(0, steps + 1, (2, 3, 3)).astype(float)
        pose_p, pose_r = (quarter_turn(rng) if rng.integers(2) else EYE for _ in range(2))
        found = reason(mesh(p, [[0, 1, 2]]), mesh(r, [[0, 1, 2]]), pose_p, pose_r)
        # A segment's edges cancel, but nothing is inside.
        assert found == (TRIANGLES if exact.intersects(p, r, pose_p, pose_r) else NONE)
        verdicts.append(found)
    assert 30 < sum(verdicts) < 470


def test_triangles_of_one_line_or_plane_at_any_pose():
    """The same pose of both keeps contact exact; another turns it to any."""
    rng, verdicts = np.random.default_rng(5), []
    for _ in range(300):
        arms = rng.integers(-3, 4, (2, 3))
        p, r = (rng.integers(-2, 3, (2, 3, 2)) @ arms).astype(float)
        pose_p = any_pose(rng)
        pose_r = any_pose(rng) if rng.integers(4) == 0 else pose_p
        found = reason(mesh(p, [[0, 1, 2]]), mesh(r, [[0, 1, 2]]), pose_p, pose_r)
        assert found == exact.intersects(p, r, pose_p, pose_r)
        verdicts.append(found)
    assert 50 < sum(verdicts) < 250


def test_a_triangle_or_segment_within_another_of_its_plane():
    """Without a point of its border; at the pose of both, and aside in the plane."""
    rng = np.random.default_rng(7)
    for _ in range(50):
        arms = rng.integers(-9, 10, (2, 3))
        if not np.cross(*arms).any():
            continue
        outer = mesh(np.array([[0, 0], [12, 0], [0, 12]]) @ arms, [[0, 1, 2]])
        for corners in ([0, 1, 2], [0, 1, 1], [0, 0, 0]):
            for shift, expected in ((np.zeros(2), TRIANGLES), (np.array([12, 12]), NONE)):
                inner = mesh((np.array([[3, 3], [4, 3], [3, 5]]) + shift) @ arms, [corners])
                pose = any_pose(rng)
                assert reason(inner, outer, pose, pose) == reason(outer, inner, pose, pose) == expected


def test_triangles_within_radii_as_their_hulls_are():
    rng, seen = np.random.default_rng(6), set()
    for k in range(500):
        p, r = rng.integers(0, 5, (2, 3, 3)).astype(float)
        pose_p = any_pose(rng) if k % 3 == 0 else quarter_turn(rng)
        radii = [float(x) for x in rng.choice([0.0, 0.5, 1.0, 2.0, 2.5], 2)]
        found = reason(mesh(p, [[0, 1, 2]], radii[0]), mesh(r, [[0, 1, 2]], radii[1]), pose_p)
        assert (found == TRIANGLES) == exact.intersects(p, r, pose_p, EYE)
        assert (found != NONE) == exact.intersects(p, r, pose_p, EYE, *radii)
        seen.add(found)
    assert seen == {NONE, TRIANGLES, WITHIN_RADII}


def test_radii_that_just_reach_and_just_do_not():
    """Corner to corner, corner to edge, edge to edge and corner to face, at distances that are whole."""
    far = [[30, 0, 0], [30, 40, 0], [30, 0, 7]]
    pairs = [
        (5.0, [[0, 0, 0]] * 3, [[3, 4, 0], [30, 40, 0], [3, 40, 1]]),
        (2.0, [[0, 0, 0]] * 3, [[2, -9, 0], [2, 9, 0], [9, 0, 1]]),
        (3.0, [[-5, 0, 0], [5, 0, 0], [0, 0, -9]], [[0, -5, 3], [0, 5, 3], [0, 0, 9]]),
        (7.0, [[5, 5, 7], [5, 5, 8], [6, 5, 9]], [[0, 0, 0], [20, 0, 0], [0, 20, 0]]),
        (30.0, [[0, 1, 1], [-1, 1, 1], [-1, 1, 0]], far),
    ]
    for distance, p, r in pairs:
        for radius, expected in ((distance, WITHIN_RADII), (np.nextafter(distance, 0), NONE)):
            for split in (0.0, 0.5, 1.0):
                found = reason(mesh(p, [[0, 1, 2]], radius * split), mesh(r, [[0, 1, 2]], radius - radius * split))
                assert found == expected


@pytest.mark.parametrize("steps", [2, 5, 1000])
def test_winding_numbers_are_those_of_signed_tetrahedra(steps):
    rng, seen = np.random.default_rng(steps), set()
    for _ in range(60):
        vertices, triangles = closed_soup(rng, steps)
        body = mesh(vertices, triangles)
        assert body.is_closed
        for point in (*rng.integers(0, 2 * steps + 1, (7, 3)) / 2, rng.uniform(0, steps, 3)):
            touches = any(exact.intersects(t, point[None], EYE, EYE) for t in triangles_of(vertices, triangles))
            found, again = (body.winding_number(point, every) for every in (False, True))
            assert found == again
            if touches:
                continue
            expected = winding_by_tetrahedra(vertices, triangles, [Fraction(x) for x in point.tolist()])
            assert expected is not None
            assert found == expected
            seen.add(found)
    assert {-1, 0, 1} <= seen


@pytest.mark.parametrize("seed", range(4))
def test_verdicts_on_meshes_are_those_of_brute_force(seed):
    """Soups of triangles on lattices of few steps and of many, closed and open, at exact and at any poses."""
    rng, seen = np.random.default_rng(seed), []
    for _ in range(60):
        bodies = []
        for scale in (1.0, float(rng.choice([1.0, 0.25]))):
            vertices, triangles = closed_soup(rng, int(rng.choice([2, 4, 1000])))
            vertices = vertices / max(1, vertices.max()) * 4 * scale
            if rng.integers(4) == 0:
                triangles = triangles[rng.permutation(len(triangles))[1:]]
            bodies.append((vertices, triangles))
        (p, p_triangles), (r, r_triangles) = bodies
        pose_p, pose_r = (any_pose(rng) if rng.integers(2) else quarter_turn(rng) for _ in range(2))
        first, second = mesh(p, p_triangles), mesh(r, r_triangles)
        found = reason(first, second, pose_p, pose_r)
        meet = triangles_meet(triangles_of(p, p_triangles), triangles_of(r, r_triangles), pose_p, pose_r)
        assert (found == TRIANGLES) == meet
        if not meet:
            inside = has_vertex_inside(bodies[0], bodies[1], pose_p, pose_r, second.is_closed)
            around = has_vertex_inside(bodies[1], bodies[0], pose_r, pose_p, first.is_closed)
            assert found == (FIRST_INSIDE if inside else SECOND_INSIDE if around else NONE)
        seen.append(found)
    assert set(seen) >= {NONE, TRIANGLES}


def has_vertex_inside(part, whole, pose_part, pose_whole, is_closed):
    """Whether any vertex of a part's triangles has another winding number than 0, exactly."""
    around = np.array(posed(whole[0], pose_whole), dtype=object)
    used = sorted(set(part[1].ravel().tolist()))
    points = posed(part[0][used], pose_part)
    return is_closed and any(winding_by_tetrahedra(around, whole[1], point) for point in points)


def test_a_body_inside_another_and_in_its_cavity():
    small = mesh(np.array([[1, 1, 1], [2, 1, 1], [1, 2, 1], [1, 1, 2]]) / 8, TETRAHEDRON)
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    hull = mesh(corners, TETRAHEDRON)
    assert reason(small, hull) == FIRST_INSIDE
    assert reason(hull, small) == SECOND_INSIDE
    cavity = np.vstack([corners, corners * 0.9 + 0.02])
    assert reason(small, mesh(cavity, np.vstack([TETRAHEDRON, TETRAHEDRON[:, ::-1] + 4]))) == NONE
    twice = mesh(cavity, np.vstack([TETRAHEDRON, TETRAHEDRON + 4]))
    assert reason(small, twice) == FIRST_INSIDE
    assert twice.components == 2
    opened = mesh(corners, TETRAHEDRON[1:])
    assert not opened.is_closed
    assert reason(small, opened) == NONE
    undone = mesh(np.vstack([corners, corners]), np.vstack([TETRAHEDRON, TETRAHEDRON[:, ::-1] + 4]))
    assert (undone.is_closed, undone.components) == (True, 1)
    assert reason(small, undone) == NONE


def test_edges_cancel_where_vertices_coincide():
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    soup = corners[TETRAHEDRON.ravel()]
    soup[soup == 0] *= np.where(np.arange(np.count_nonzero(soup == 0)) % 2 == 0, 1, -1)
    assert np.signbit(soup[soup == 0]).any()
    separate = mesh(soup, np.arange(12).reshape(4, 3))
    assert (separate.is_closed, separate.components) == (True, 1)
    # A T-junction: the middle of an edge on one side alone; then a triangle without area in between.
    middle = np.vstack([corners, [[0.5, 0.5, 0]]])
    split = np.array([[0, 2, 4], [0, 4, 1], *TETRAHEDRON[1:]])
    assert not mesh(middle, split).is_closed
    assert mesh(middle, [*split.tolist(), [1, 4, 2]]).is_closed
    assert not mesh(middle, [*split.tolist(), [1, 2, 4]]).is_closed
    # Points and segments have edges that cancel of themselves.
    assert mesh(corners, [[0, 0, 0]]).is_closed
    assert mesh(corners, [[0, 1, 1]]).is_closed


def test_coordinates_beyond_intervals():
    """Where products would overflow, whole numbers decide all."""
    for scale in (1e-300, 1e-150, 1.0, 1e45, 1e150):
        corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * scale
        body, pose = mesh(corners, TETRAHEDRON), np.eye(4)
        pose[0, 3] = scale
        assert reason(body, body, EYE, pose) == TRIANGLES
        pose[0, 3] = np.nextafter(scale, np.inf)
        assert reason(body, body, EYE, pose) == NONE


def test_what_is_no_mesh_is_refused():
    points = np.zeros((2, 3))
    for vertices, triangles, radius in (
        (points, np.zeros((0, 3)), 0.0),
        (points, [[0, 1, 2]], 0.0),
        (points, [[0, 1, -1]], 0.0),
        (np.full((2, 3), np.nan), [[0, 1, 0]], 0.0),
        (points, [[0, 1, 0]], -1.0),
    ):
        with pytest.raises(ValueError, match=r"finite|at least|indices"):
            mesh(vertices, np.asarray(triangles), radius)
    body = mesh(points, [[0, 1, 0]])
    with pytest.raises(ValueError, match="as many"):
        _oracle.decide_meshes(body, EYE[None], body, np.tile(EYE, (2, 1, 1)), False)


def test_many_triangles_are_swept():
    """Two fine tori, where they touch and where they miss."""
    u, v = (a.ravel() for a in np.meshgrid(np.arange(60), np.arange(40), indexing="ij"))
    a, b = 2 * np.pi * u / 60, 2 * np.pi * v / 40
    points = np.stack(
        [(1 + 0.25 * np.cos(b)) * np.cos(a), (1 + 0.25 * np.cos(b)) * np.sin(a), 0.25 * np.sin(b)], axis=1
    )
    at = lambda i, j: (i % 60) * 40 + j % 40  # noqa: E731
    quads = np.stack([at(u, v), at(u + 1, v), at(u + 1, v + 1), at(u, v + 1)], axis=1)
    torus = mesh(points, np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))
    poses = np.tile(np.eye(4), (6, 1, 1))
    poses[:, :3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    poses[:, 0, 3] = [1.0, 0.6, 0.49, 0.45, 0.0, 3.0]
    found = _oracle.decide_meshes(torus, np.tile(EYE, (6, 1, 1)), torus, poses, False)
    assert found.tolist() == [NONE, NONE, TRIANGLES, TRIANGLES, TRIANGLES, NONE]
    assert [torus.winding_number(np.array(p), False) for p in itertools.product((0.0, 1.0), (0.0,), (0.0, 0.3))] == [
        0,
        0,
        1,
        0,
    ]
