"""Prepared bodies against brute force in integers: hulls, hierarchies, extreme vertices, wedges, refusals."""

import itertools
import pickle

import numpy as np
import pytest
from exact_points import integers
from hypothesis import given, settings
from hypothesis import strategies as st

import plannercheck as pc
from plannercheck.bodies.core_polytopes import LARGEST_COORDINATE
from plannercheck.bodies.shapes import Box, Capsule, Cone, Cylinder, Sphere
from plannercheck.common.core import core
from plannercheck.evaluation.stress import body_families as families
from plannercheck.evaluation.stress.body_families import FAMILIES, MESHES, family, mesh_points

CUBE = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
CUBE_FACES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]

# A query may visit this many blocks of four: 16 of the top, and about 12 more for each factor of ten.
MOST_BLOCKS = 16 + 4 * 12


def normal_of(a, b, c):
    (x1, y1, z1), (x2, y2, z2) = b - a, c - a
    return np.array([y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2], dtype=object)


def assert_is_hull(polytope, points):
    """Every point is inside all facets, every vertex is one of them and extreme; all exact."""
    given = integers(points)
    corners = given[polytope.source]
    np.testing.assert_array_equal(np.asarray(points)[polytope.source], polytope.vertices)
    assert len({tuple(p) for p in polytope.vertices.tolist()}) == len(polytope.vertices)
    assert len(polytope.faces) == 2 * len(polytope.vertices) - 4
    facets = [set() for _ in corners]  # per vertex: which given points lie in the planes that meet there
    for face in polytope.faces.tolist():
        heights = (given - corners[face[0]]) @ normal_of(*corners[face])
        assert heights.max() == 0
        for corner in face:
            facets[corner].add(tuple(np.flatnonzero(heights == 0)))
    assert min(len(planes) for planes in facets) >= 3


def assert_extreme(polytope, directions):
    """The vertex named is exactly furthest along each direction."""
    values = integers(directions) @ integers(polytope.vertices).T
    found = polytope.extreme(directions)
    assert (values[np.arange(len(found)), found] == values.max(axis=1)).all()


def hull_or_refusal(points, refusal="no hull to work with"):
    """The body, or None if it has no volume or its points are refused for the reason given."""
    try:
        polytope = pc.Polytope(points)
        return polytope if polytope.dimension == 3 else None
    except pc.PlannercheckError as error:
        if refusal not in str(error):
            raise
        return None


def is_flat(points):
    """Whether all points lie in a plane, exactly."""
    given = integers(sorted(set(map(tuple, points.tolist()))))
    normals = (normal_of(*triple) for triple in itertools.combinations(given, 3))
    normal = next((n for n in normals if n.any()), None)
    if normal is None:
        return True
    return len(set((given @ normal).tolist())) == 1


small_grid = st.lists(st.tuples(*[st.integers(0, 3)] * 3), min_size=4, max_size=24)
scales = st.sampled_from([1.0, 1e-12, 1e6, 0.1])
offsets = st.sampled_from([0.0, 1.0, 1e6])


@settings(max_examples=250, deadline=None, derandomize=True, database=None)
@given(points=small_grid, scale=scales, offset=offsets)
def test_lattice_points_have_an_exact_hull(points, scale, offset):
    points = np.array(points, dtype=float) * scale + offset
    polytope = hull_or_refusal(points)
    if polytope is None:
        return
    assert_is_hull(polytope, points)
    assert polytope.fault() == ""
    assert_extreme(polytope, np.vstack([np.eye(3), -np.eye(3), [[1, 1, 0], [1, 1, 1], [-1, 2, 3]]]))


@settings(max_examples=120, deadline=None, derandomize=True, database=None)
@given(points=small_grid)
def test_flat_points_have_a_flat_hull(points):
    points = np.array(points, dtype=float)
    polytope = pc.Polytope(points)
    assert (polytope.dimension < 3) == is_flat(points)
    assert polytope.fault() == ""
    directions = np.vstack([np.eye(3), -np.eye(3), [[1, 1, 0], [1, 1, 1], [-1, 2, 3]]])
    best = (polytope.vertices @ directions.T).max(axis=0)
    assert (best == (points @ directions.T).max(axis=0)).all()
    chosen = polytope.vertices[polytope.extreme(directions)]
    assert ((chosen * directions).sum(axis=1) == best).all()


def corners_in_plane(points):
    """Of pairs of integers: those at the ends of a hull's edges, by trying all pairs of them. Brute force."""

    def turn(a, b, c):
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    def is_edge(a, b):
        """Whether all are left of the way from a to b, or on it between them."""
        for c in points:
            side, along = turn(a, b, c), sum((c[k] - a[k]) * (b[k] - c[k]) for k in range(2))
            if side < 0 or (side == 0 and along < 0):
                return False
        return True

    return {p for a, b in itertools.permutations(points, 2) if is_edge(a, b) for p in (a, b)}


@pytest.mark.parametrize("slope", [0, 64])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_slivers_have_exact_corners(axis, slope):
    """Points within a unit of a line of up to 2^53: doubles do not tell which turn they take, nor whether they do.

    In a plane at right angles to an axis, or in one so steep that turns along the axes differ in size.
    """
    rng = np.random.default_rng(axis)
    flat = 0
    for number in range(150):
        step = rng.integers(2**46, 2**47, 2)
        points = np.outer(rng.integers(-32, 33, rng.integers(3, 8)), step) + rng.integers(-1, 2, 2)
        points[rng.integers(len(points))] += rng.integers(-1, 2, 2)
        if number < 50:  # a corner clearly off the line, so that the plane is beyond doubt
            points = np.vstack([points, 32 * step[::-1] * [-1, 1]])
        points = np.unique(points, axis=0)
        if len(points) < 3:
            continue
        corners = corners_in_plane([tuple(map(int, p)) for p in points])
        polytope = pc.Polytope(np.insert(points, axis, slope * points[:, 0], axis=1).astype(float))
        assert polytope.dimension == min(2, len(corners) - 1)
        flat += polytope.dimension == 2
        found = np.delete(polytope.vertices, axis, axis=1)
        assert sorted(map(tuple, found.tolist())) == sorted(corners)
        assert polytope.fault() == ""
    assert 100 < flat < 150


def test_triangles_whose_normals_no_double_holds():
    """All products of their edges underflow, but along the axis that is at right angles to none: found exactly."""
    for axis in range(3):
        corners = np.insert(np.array([[0.0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5]]) * 2.0**-600, axis, 0.0, axis=1)
        polytope = pc.Polytope(corners)
        assert polytope.dimension == 2
        assert sorted(polytope.source.tolist()) == [0, 1, 2, 3]
        assert polytope.fault() == ""


@pytest.mark.parametrize("scale", [1.0, 1e-12, 1e6])
@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_thousands_of_small_bodies_are_sound(scale, offset):
    rng = np.random.default_rng(7)
    solid = 0
    for n in rng.integers(4, 14, 350):
        kind = rng.integers(3)
        points = rng.normal(size=(n, 3)) if kind == 0 else rng.integers(0, 3, size=(n, 3)).astype(float)
        if kind == 2:  # nearly coplanar: neighbouring doubles
            points += rng.integers(-1, 2, size=points.shape) * np.spacing(1.0)
        polytope = pc.Polytope(points * scale + offset)
        assert polytope.fault() == ""
        solid += polytope.dimension == 3
    # 1e-12 is lost in 1e6: one point is left, which is sound as well.
    assert solid == 0 if scale * 1e10 < offset else solid > 340


@pytest.mark.parametrize("name", sorted(FAMILIES))
@pytest.mark.parametrize("n", [8, 65, 300, 2000])
def test_families_are_sound(name, n):
    polytope = pc.Polytope(family(name, n, seed=n))
    assert polytope.fault() == ""


@pytest.mark.parametrize("name", MESHES)
def test_meshes_are_sound(name):
    points = mesh_points(name)
    polytope = pc.Polytope(points)
    assert polytope.fault() == ""
    assert polytope.extreme(np.eye(3)).tolist() == polytope.extreme(np.eye(3) * 3).tolist()


@pytest.mark.parametrize("shape", [Box((1, 2, 3)), Sphere(0.3), Cylinder(0.2, 1), Capsule(0.1, 1), Cone(0.2, 0.4)])
def test_shapes_know_their_faces(shape):
    vertices, faces = shape.vertices_and_faces(1e-3)
    polytope = pc.Polytope(vertices, faces)
    assert polytope.fault() == ""
    found = pc.Polytope(vertices)
    assert len(found.vertices) == len(polytope.vertices)
    assert found.statistics()["facets"] == polytope.statistics()["facets"]


@pytest.mark.parametrize("name", ["round", "cone", "lattice", "flat", "needle", "fan", "box"])
@pytest.mark.parametrize("n", [12, 60, 400])
def test_extreme_vertices_are_exact(name, n):
    points = family(name, n, seed=3)
    rng = np.random.default_rng(1)
    for moved in (points, points + 1e3, points * 1e-9):
        polytope = pc.Polytope(moved)
        corners = polytope.vertices[polytope.faces[:: max(1, len(polytope.faces) // 20)]]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        directions = np.vstack([np.eye(3), -np.eye(3), rng.normal(size=(20, 3)), normals, [[0, 0, 0]]])
        assert_extreme(polytope, directions)
        assert_extreme(polytope.without_cells(), directions)


def many_facing(polytope, k, seed):
    """Directions of all kinds: random, towards vertices, across facets and edges."""
    rng = np.random.default_rng(seed)
    corners = polytope.vertices[polytope.faces[rng.integers(0, len(polytope.faces), k)]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    normals = normals[lengths > 0] / lengths[lengths > 0][:, None]
    between = normals + 1e-3 * rng.normal(size=normals.shape) * rng.uniform(size=(len(normals), 1))
    return np.vstack([rng.normal(size=(k, 3)), polytope.vertices[rng.integers(0, len(polytope.vertices), k)], between])


LARGE = ["cone", "fan", "prism", "doubling", "round"]


@pytest.fixture(scope="module", params=LARGE)
def large(request):
    """A body of about 10,000 vertices."""
    if request.param == "doubling":
        return pc.Polytope(*families.degree_doubling(11))
    return pc.Polytope(family(request.param, 10_000, seed=1))


@pytest.fixture(params=["with cells", "by hierarchies"])
def large_core(request, large):
    return large.core if request.param == "with cells" else large.without_cells().core


def test_queries_visit_logarithmically_many_blocks(large, large_core):
    for of_polar in (False, True):
        _, blocks = large_core.extremes(many_facing(large, 700, 2), of_polar)
        assert blocks.max() <= MOST_BLOCKS


def test_large_bodies_agree_with_plain_scanning(large, large_core):
    directions = many_facing(large, 300, 3)
    for of_polar, points in ((False, large.vertices), (True, np.asarray(large.core.polar_points()))):
        found = np.asarray(large_core.extremes(directions, of_polar)[0])
        values = directions @ points.T
        reached = np.take_along_axis(values, found[:, None].astype(np.int64), axis=1)[:, 0]
        rounding = 16 * 2.0**-53 * np.abs(directions).sum(axis=1) * np.abs(points).max()
        assert (reached >= values.max(axis=1) - rounding).all()


def test_wedges_agree_with_exact_scanning_at_the_hub():
    polytope = pc.Polytope(family("cone", 1000, seed=5)).without_cells()
    assert polytope.statistics()["inner"]["fans"] > 0
    hub = int(polytope.extreme([[0, 0, 1]])[0])
    # Directions around the border of the hub's normal cone: the rim barely beats the hub, or barely not.
    rim = polytope.vertices[np.arange(len(polytope.vertices)) != hub]
    slope = np.hypot(rim[0, 0], rim[0, 1])
    angles = np.random.default_rng(2).uniform(0, 2 * np.pi, 40)
    for tilt in (1 - 1e-12, 1, 1 + 1e-12, 1 + 1e-6):
        directions = np.stack([np.cos(angles), np.sin(angles), np.full(40, slope * tilt)], axis=1)
        assert_extreme(polytope, directions)


def test_a_hub_with_coplanar_facets_in_mirrored_directions():
    # Kites around an apex, each exactly flat, all symmetric about y = 0: the wedge of a kite's diagonal is empty.
    n = 400
    rim = np.round(families.rim_points(n, 0.5) * 2**28) / 2**28
    rim[n // 2 :] = rim[: n // 2][::-1] * [1, -1]
    ring = np.column_stack([rim, np.zeros(n)])
    apex = np.array([0.0, 0.0, 1.0])
    tips = apex + 0.75 * (ring - apex) + 0.75 * (np.roll(ring, -1, axis=0) - apex)
    polytope = pc.Polytope(np.vstack([apex, ring, tips]))
    assert polytope.fault() == ""
    heights = np.concatenate([np.linspace(-1, 3, 41), 1 + np.linspace(-1e-4, 1e-4, 41)])
    directions = [[x, 0.0, h] for h in heights for x in (-1.0, 1.0)] + [
        [0.0, y, h] for h in heights for y in (-1.0, 1.0)
    ]
    values = np.array(directions) @ polytope.vertices.T
    found = polytope.extreme(directions)
    assert (np.take_along_axis(values, found[:, None].astype(int), 1)[:, 0] >= values.max(axis=1) - 1e-14).all()


def test_memory_and_levels():
    for n in (1000, 10_000):
        polytope = pc.Polytope(family("round", n, seed=1))
        statistics = polytope.statistics()
        assert polytope.nbytes / len(polytope.vertices) < 1000
        assert statistics["inner"]["levels"] <= 8 * np.log10(n)
        assert statistics["facets"] == statistics["polar"]["vertices"]


def test_a_cube_has_six_facets():
    polytope = pc.Polytope(np.vstack([CUBE, CUBE, [[0.5, 0.5, 0.5], [0.5, 0.5, 0], [0.5, 0, 0]]]))
    assert len(polytope.vertices) == 8
    assert polytope.statistics()["facets"] == 6
    np.testing.assert_allclose(polytope.centre.ravel(), [0.5, 0.5, 0.5])


def test_faces_are_taken_as_given():
    polytope = pc.Polytope(CUBE, CUBE_FACES)
    assert polytope.fault() == ""
    np.testing.assert_array_equal(polytope.vertices, CUBE)
    np.testing.assert_array_equal(polytope.source, np.arange(8))


def dented():
    points, faces = CUBE.copy(), CUBE_FACES
    points[7] = [0.4, 0.4, 0.4]
    return points, faces


WRONG_FACES = {
    "inside out": (CUBE, [face[::-1] for face in CUBE_FACES], "stick"),
    "one reversed": (CUBE, [CUBE_FACES[0][::-1], *CUBE_FACES[1:]], "same direction"),
    "one missing": (CUBE, CUBE_FACES[1:], "not closed"),
    "one twice": (CUBE, [*CUBE_FACES, CUBE_FACES[0]], "same direction"),
    "dented": (*dented(), "sticks out"),
    "vertex unused": (np.vstack([CUBE, [[0.5, 0.5, 0.5]]]), CUBE_FACES, "no face"),
    "corners crossed": (CUBE, [[0, 3, 1, 2], *CUBE_FACES[1:]], "same direction|not closed"),
    "corner in a face": (
        np.vstack([CUBE, [[0.5, 0.5, 0]]]),
        [*CUBE_FACES[:4], [0, 2, 8], [2, 6, 8], [6, 4, 8], [4, 0, 8], CUBE_FACES[5]],
        "sticks out|no corner",
    ),
    "two corners": (CUBE, [[0, 1], *CUBE_FACES[1:]], "at least 3 different corners"),
    "corner repeated": (CUBE, [[0, 1, 1, 2], *CUBE_FACES[1:]], "at least 3 different corners"),
    "no such vertex": (CUBE, [[0, 1, 3, 8], *CUBE_FACES[1:]], "beyond 0 … 7"),
    "negative": (CUBE, [[0, 1, 3, -2], *CUBE_FACES[1:]], "beyond 0 … 7"),
    "too few": (CUBE, CUBE_FACES[:1], "fewer than 4"),
    "empty": (CUBE, [], "fewer than 4"),
}


@pytest.mark.parametrize("case", WRONG_FACES)
def test_wrong_faces_are_refused(case):
    points, faces, message = WRONG_FACES[case]
    with pytest.raises(pc.PlannercheckError, match=f"(?s)crate.*({message})"):
        pc.Polytope(points, faces, name="crate")


def test_faces_that_wind_twice_are_refused():
    # Every edge of this surface is convex, and it goes around the axis twice: {5/2} between two apices.
    angles = 2 * np.pi * 2 * np.arange(5) / 5
    star = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(5)])
    points = np.vstack([star, [[0, 0, 1], [0, 0, -1]]])
    faces = [[k, (k + 1) % 5, 5] for k in range(5)] + [[(k + 1) % 5, k, 6] for k in range(5)]
    with pytest.raises(pc.PlannercheckError, match="more than once"):
        pc.Polytope(points, faces)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.zeros((0, 3)), "at least one"),
        (CUBE[:, :2], r"shape \(n, 3\), not \(8, 2\)"),
        (CUBE.ravel(), r"shape \(n, 3\)"),
        ([["a", "b", "c"]], "array of numbers"),
        (np.where(CUBE[5] == CUBE, np.nan, CUBE), "finite"),
        (np.where(np.arange(8)[:, None] == 3, np.inf, CUBE), "vertex 3 .*finite"),
        (CUBE * 10 * LARGEST_COORDINATE, "at most 1e.50"),
    ],
)
def test_bad_points_are_refused(points, message):
    with pytest.raises(pc.PlannercheckError, match=f"crate.*{message}"):
        pc.Polytope(points, name="crate")


@pytest.mark.parametrize("thickness", [1e-9, 1e-15, 1e-100, 1e-300, 5e-324])
def test_extremely_thin_bodies_have_a_hull(thickness):
    polytope = pc.Polytope(CUBE * [1, 1, thickness])
    assert polytope.dimension == 3
    assert polytope.fault() == ""
    assert len(polytope.vertices) == 8
    assert polytope.statistics()["facets"] == 6


@pytest.mark.parametrize("bad", [[[np.nan, 0, 0]], [[np.inf, 0, 0]], [[1.0, 0]], [["up", 0, 0]]])
def test_bad_directions_are_refused(bad):
    with pytest.raises(pc.PlannercheckError, match="direction"):
        pc.Polytope(family("cone", 500, seed=1)).extreme(bad)


def test_bodies_are_immutable():
    polytope = pc.Polytope(CUBE)
    for array in (polytope.vertices, polytope.faces, polytope.source):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    with pytest.raises(AttributeError):
        polytope.colour = "red"


def test_equal_points_give_equal_bytes():
    points = family("lattice", 500, seed=2)
    assert pc.Polytope(points).core.serialise() == pc.Polytope(points.copy()).core.serialise()


@pytest.mark.parametrize("name", ["box", "cone", "round"])
def test_pickled_bodies_keep_every_bit(name):
    polytope = pc.Polytope(family(name, 400, seed=1))
    again = pickle.loads(pickle.dumps(polytope))
    assert again.core.serialise() == polytope.core.serialise()
    np.testing.assert_array_equal(again.source, polytope.source)
    assert again.fault() == ""


def test_damaged_bytes_are_refused_or_harmless():
    data = pc.Polytope(family("cone", 300, seed=1)).core.serialise()
    for end in (0, 7, 8, 100, len(data) // 2, len(data) - 1):
        with pytest.raises(core.HullError):
            core.Polytope.parse(data[:end])
    with pytest.raises(core.HullError, match="go on"):
        core.Polytope.parse(data + b"\0")
    rng = np.random.default_rng(1)
    directions = rng.normal(size=(20, 3))
    for _ in range(300):
        damaged = bytearray(data)
        place = int(rng.integers(0, len(data) // 4)) * 4
        damaged[place : place + 4] = int(rng.integers(-(2**31), 2**31)).to_bytes(4, "little", signed=True)
        try:
            body = core.Polytope.parse(bytes(damaged))
        except core.HullError:
            continue
        for of_polar in (False, True):
            body.extremes(directions, of_polar)


def test_representation_tells_sizes():
    assert repr(pc.Polytope(CUBE)) == "Polytope(8 vertices, 6 facets)"
