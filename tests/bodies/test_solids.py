"""Solids are their meshes with what these enclose: when they are closed or their hulls, what they share, and where."""

import copy
import itertools
import pickle
from fractions import Fraction

import exact_verdicts
import numpy as np
import pytest
import trimesh
from poses import at
from solid_meshes import angle

import plannercheck as pc
from plannercheck.bodies import solid_certificates
from plannercheck.bodies.hull_equality import is_hull
from plannercheck.bodies.solid_certificates import winding_number
from plannercheck.bodies.solids import Solid

CUBE = trimesh.creation.box((2, 2, 2))
TETRAHEDRON = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
TRIANGLES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def solid(mesh):
    return Solid(mesh.vertices, mesh.faces)


def joined(*meshes):
    """One mesh of several (points, triangles)."""
    first = np.cumsum([0, *(len(points) for points, _ in meshes)])
    corners = [triangles + start for (_, triangles), start in zip(meshes, first[:-1], strict=True)]
    return np.concatenate([points for points, _ in meshes]), np.concatenate(corners)


def hollow(inner=0.5):
    """A cube of edge 2 with a cube in it left out."""
    points, corners = np.asarray(CUBE.vertices), np.asarray(CUBE.faces)
    return joined((points, corners), (inner * points, corners[:, ::-1]))


# What users give.


def test_arrays_are_copied_and_can_not_be_written_to():
    points, triangles = TETRAHEDRON.copy(), TRIANGLES.copy()
    made = Solid(points, triangles)
    points[0], triangles[0] = 7, 3
    assert made.vertices.tolist() == TETRAHEDRON.tolist()
    assert made.triangles.tolist() == TRIANGLES.tolist()
    for array in (made.vertices, made.triangles, *made.used):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    assert Solid(TETRAHEDRON.tolist(), TRIANGLES.tolist()).is_closed
    with pytest.raises(AttributeError):
        made.vertices = points


@pytest.mark.parametrize(
    ("vertices", "triangles", "says"),
    [
        (TETRAHEDRON, [], "at least one triangle"),
        (TETRAHEDRON, np.zeros((0, 3), dtype=int), "at least one triangle"),
        (TETRAHEDRON, [[0, 1, 4]], r"row 0 is \[0, 1, 4\], but there are 4 vertices"),
        (TETRAHEDRON, [[0, 1, 2], [0, -1, 2]], r"row 1 is \[0, -1, 2\]"),
        (TETRAHEDRON, [[0, 1, 2, 3]], r"shape \(k, 3\)"),
        (TETRAHEDRON, [0, 1, 2], r"shape \(k, 3\)"),
        (TETRAHEDRON, [[0.0, 1.0, 2.0]], "whole numbers"),
        (TETRAHEDRON, [[True, False, True]], "whole numbers"),
        (TETRAHEDRON, "abc", "whole numbers"),
        (TETRAHEDRON, [[0, 1, 2], [0, 1]], "at least one triangle|whole numbers"),
        (TETRAHEDRON[:, :2], TRIANGLES, r"shape \(n, 3\)"),
        ([[0, 0, 0], [1, 0, float("nan")]], [[0, 1, 1]], "row 1 is .* must be finite"),
        ([[0, 0, 0], [1, 0, float("inf")]], [[0, 1, 1]], "row 1 is .* must be finite"),
        (["a", "b"], [[0, 1, 1]], "must be numbers"),
        (np.zeros((0, 3)), [[0, 0, 0]], "there are 0 vertices"),
        (TETRAHEDRON * 1j, TRIANGLES, "must be numbers"),
    ],
)
def test_wrong_arrays_are_refused(vertices, triangles, says):
    with pytest.raises(pc.PlannercheckError, match=says):
        Solid(vertices, triangles)


def test_a_mesh_of_a_library_is_a_solid_of_its_vertices_and_faces():
    mesh = trimesh.creation.torus(1.0, 0.25)
    solid = pc.Solid(mesh)
    assert np.array_equal(solid.vertices, mesh.vertices)
    assert np.array_equal(solid.triangles, mesh.faces)
    assert not pc.intersects(solid, pc.Sphere(0.5))  # in its hole
    assert pc.Solid(trimesh.Trimesh(CUBE.vertices, CUBE.faces[2:]), open="triangles").kind == "open"


@pytest.mark.parametrize("value", [CUBE.vertices, trimesh.Scene([CUBE]), "cube.stl", None])
def test_what_has_no_triangles_is_no_solid(value):
    with pytest.raises(pc.PlannercheckError, match="needs vertices and triangles, or a mesh that has vertices"):
        pc.Solid(value)


def test_solids_are_pickled_and_shown():
    made = solid(CUBE)
    again = pickle.loads(pickle.dumps((made, made.is_closed, made.equals_hull)))[0]
    for other in (again, copy.copy(made), copy.deepcopy(made)):
        assert isinstance(other, pc.Solid)
        assert other.digest == made.digest
        assert not other.vertices.flags.writeable
    assert repr(made) == "Solid(8 vertices, 12 triangles, closed)"
    assert repr(Solid(TETRAHEDRON, TRIANGLES[1:])) == "Solid(4 vertices, 3 triangles, capped)"
    assert Solid(TETRAHEDRON, TRIANGLES[1:]).digest != Solid(TETRAHEDRON, TRIANGLES).digest
    assert Solid(np.vstack([TETRAHEDRON, [9, 9, 9]]), TRIANGLES).digest == Solid(TETRAHEDRON, TRIANGLES).digest


# Files.


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply", "dae"])
def test_mesh_files_are_loaded_with_their_scale(tmp_path, suffix):
    if suffix == "dae":
        pytest.importorskip("collada", reason="trimesh writes dae with pycollada")
    trimesh.Trimesh(*angle()).export(tmp_path / f"angle.{suffix}")
    loaded = Solid.load(tmp_path / f"angle.{suffix}", [0.5, 1, 2])
    assert loaded.is_closed
    assert not loaded.equals_hull
    points = angle()[0] if suffix != "dae" else angle()[0][:, [0, 2, 1]] * [1, -1, 1]  # y is up by Collada's default
    assert sorted((loaded.vertices + 0.0).tolist()) == sorted((points * [0.5, 1, 2] + 0.0).tolist())
    assert len(loaded.triangles) == len(angle()[1])


def test_files_that_are_no_solids_are_refused(tmp_path):
    (tmp_path / "cloud.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n")
    with pytest.raises(pc.PlannercheckError, match=r"cloud\.obj.*no faces"):
        Solid.load(tmp_path / "cloud.obj")
    with pytest.raises(pc.PlannercheckError, match=r"nothing\.stl.*does not exist"):
        Solid.load(tmp_path / "nothing.stl")
    (tmp_path / "bad.stl").write_text("solid\n")
    with pytest.raises(pc.PlannercheckError, match=r"bad\.stl.*has no 'endsolid'"):
        Solid.load(tmp_path / "bad.stl")
    with pytest.raises(pc.PlannercheckError, match="scale"):
        Solid.load(tmp_path / "cloud.obj", 0.0)


def test_an_open_file_is_told(tmp_path):
    trimesh.Trimesh(CUBE.vertices, CUBE.faces[2:]).export(tmp_path / "open.stl")
    with pytest.warns(RuntimeWarning, match=r"open\.stl.*: caps close open meshes: the mesh"):
        assert Solid.load(tmp_path / "open.stl").is_open


# Closed meshes.


def test_closed_is_what_directed_edges_say():
    points, corners = np.asarray(CUBE.vertices), np.asarray(CUBE.faces)
    soup = points[corners].reshape(-1, 3)
    assert Solid(points, corners).is_closed
    assert Solid(points, corners[:, ::-1]).is_closed
    assert Solid(soup, np.arange(36).reshape(-1, 3)).is_closed
    assert Solid(*hollow()).is_closed
    assert Solid(*joined((points, corners), (points + 0.3, corners))).is_closed  # they cross
    assert Solid(*joined((points, corners), (points, corners))).is_closed  # each edge twice
    assert Solid(points, corners[1:]).is_open
    assert Solid(points, np.vstack([corners, corners[:1]])).is_open
    flipped = corners.copy()
    flipped[3] = flipped[3, ::-1]
    assert Solid(points, flipped).is_open


def test_minus_zero_is_zero():
    points = np.vstack([TETRAHEDRON, [[-0.0, 1, 0]]])
    assert Solid(points, np.where(TRIANGLES == 2, np.where(np.arange(4)[:, None] < 2, 2, 4), TRIANGLES)).is_closed


def test_a_t_junction_is_closed_by_a_degenerate_triangle():
    points = np.vstack([TETRAHEDRON, [[0.5, 0, 0]]])  # in the middle of the edge from 0 to 1
    split = np.array([[0, 2, 4], [4, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    assert Solid(points, split).is_open
    mended = Solid(points, np.vstack([split, [[0, 4, 1]]]))
    assert mended.is_closed
    assert mended.equals_hull
    assert Solid(points, np.vstack([TRIANGLES, [[0, 0, 4]]])).is_closed  # to and fro


# Solids that are their hulls.


def fractions_say(points, triangles):
    """Whether a closed mesh with volume is its hull, by the definition, in fractions."""
    hull = pc.Polytope(points)
    exact_points = np.array([[Fraction(x) for x in row] for row in points.tolist()], dtype=object)

    def cross(b, c):
        return np.array([b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]])

    facets = exact_points[hull.source[hull.faces]]
    normals = np.array([cross(b - a, c - a) for a, b, c in facets])
    on = exact_points @ normals.T == (normals * facets[:, 0]).sum(axis=1)  # points, facets
    volume = sum(a @ cross(b, c) for a, b, c in exact_points[triangles])
    return bool(on[triangles].all(axis=1).any(axis=1).all()) and volume != 0


CONVEX = {
    "box": CUBE,
    "cut box": CUBE.subdivide().subdivide(),
    "ball": trimesh.creation.icosphere(1),
    "cone": trimesh.creation.cone(1, 2, sections=12),
}


@pytest.mark.parametrize("name", CONVEX)
def test_convex_meshes_are_their_hulls(name):
    points, corners = np.asarray(CONVEX[name].vertices), np.asarray(CONVEX[name].faces)
    if not fractions_say(points, corners):
        pytest.skip("rounding has bent it")
    for shift in (0, 1e3):  # exact for these
        for triangles in (corners, corners[:, ::-1], np.vstack([corners, corners, corners[:, ::-1]])):
            made = Solid(points, triangles)
            assert made.equals_hull == fractions_say(made.used[0], made.used[1])
            assert shift or made.equals_hull
    assert not Solid(points, np.vstack([corners, corners[:, ::-1]])).equals_hull  # it winds around nothing
    assert not Solid(points, corners[1:], "triangles").equals_hull


@pytest.mark.parametrize("make", [hollow, angle, lambda: hollow(1.0), lambda: joined(hollow(), hollow())])
def test_concave_meshes_are_not(make):
    made = Solid(*make())
    assert made.is_closed
    assert not made.equals_hull


def test_the_last_bit_decides():
    """Vertices in the middle of faces, moved by one unit in the last place, against fractions."""
    rng = np.random.default_rng(3)
    cut = CUBE.subdivide()
    points, corners = np.asarray(cut.vertices), np.asarray(cut.faces)
    said = []
    for _ in range(60):
        moved = (points + rng.choice([0.0, 0.0, 2.0**-3])) * rng.choice([1.0, 3.0, 2.0**-300, 2.0**120])
        for _ in range(rng.integers(0, 2)):
            k, axis = rng.integers(len(points)), rng.integers(3)
            moved[k, axis] = np.nextafter(moved[k, axis], rng.choice([-np.inf, np.inf]))
        made = Solid(moved, corners)
        said.append(made.equals_hull)
        assert said[-1] == fractions_say(*made.used)
    assert 10 < sum(said) < 50


def test_skew_faces_whose_bends_doubles_do_not_show():
    """Faces of skew boxes of whole numbers of 40 bits, with a vertex that is off by the last bit, or not."""
    rng = np.random.default_rng(5)
    cut = CUBE.subdivide()
    lattice, corners = np.asarray(cut.vertices) + 1, np.asarray(cut.faces)
    for is_bent in (False, True) * 10:
        points = lattice @ rng.integers(-(2**40), 2**40, (3, 3))
        if is_bent:
            k, axis = rng.integers(len(points)), rng.integers(3)
            points[k, axis] = np.nextafter(points[k, axis], rng.choice([-np.inf, np.inf]))
        made = Solid(points, corners)
        assert made.equals_hull == fractions_say(*made.used)
        assert is_bent or made.equals_hull


def test_random_flat_faces_against_fractions():
    """Hulls of a few whole numbers, cut at random: coplanar facets, vertices without volume of their own."""
    rng = np.random.default_rng(4)
    for _ in range(40):
        hull = pc.Polytope(rng.integers(0, 4, (8, 3)) * 1.0)
        if hull.dimension < 3:
            continue
        mesh = trimesh.Trimesh(hull.vertices, hull.faces, process=False).subdivide()
        corners = np.asarray(mesh.faces)
        assert is_hull(*Solid(mesh.vertices, corners).used, True)
        dented = np.array(mesh.vertices)
        k = rng.integers(len(dented))
        dented[k] = 0.5 * dented[k] + 0.5 * dented.mean(axis=0)
        made = Solid(dented, corners)
        assert made.equals_hull == fractions_say(*made.used)


def test_flat_ones_are_their_hulls_if_one_triangle_is_all():
    assert Solid(TETRAHEDRON, [[0, 1, 2]]).equals_hull
    assert Solid(TETRAHEDRON, [[0, 1, 2], [0, 0, 1]]).equals_hull
    assert Solid(TETRAHEDRON, [[3, 3, 3]]).equals_hull
    assert Solid([[0, 0, 0], [1, 0, 0], [2, 0, 0.0]], [[0, 1, 2]]).equals_hull
    assert not Solid([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0.0]], [[0, 0, 1], [2, 2, 3]]).equals_hull


def test_a_solid_that_is_its_hull_is_prepared_as_it():
    assert pc.Polytope(solid(CUBE)).solid is None
    assert pc.Polytope(Solid(*hollow())).solid is not None
    assert pc.Polytope(Solid(*hollow())).nbytes > pc.Polytope(solid(CUBE)).nbytes


# What two bodies share.


def test_a_body_inside_collides_and_in_a_hollow_does_not():
    small = pc.Box((0.2, 0.2, 0.2))
    made = Solid(*hollow())
    assert not pc.intersects(made, small)
    assert pc.intersects(made, small, None, at(0.75, 0, 0))  # in the wall
    assert pc.intersects(made, small, None, at(0.5, 0, 0))
    assert pc.intersects(pc.Hull(made.vertices), small)
    inverted = Solid(made.vertices, made.triangles[:, ::-1])
    assert pc.intersects(inverted, small, None, at(0.75, 0, 0))
    is_open = Solid(CUBE.vertices, CUBE.faces[1:], "triangles")
    assert not pc.intersects(is_open, small)
    assert pc.intersects(is_open, small, at(1, 0, 0))


def test_touching_counts():
    slot = pc.Box((1.0, 1.0, 1.0))
    hole = Solid(*hollow())
    assert pc.intersects(hole, slot)  # all faces touch
    assert not pc.intersects(hole, pc.Box((np.nextafter(1.0, 0),) * 3))
    segment = Solid([[0, 0, 0], [0, 0, 0.5]], [[0, 0, 1]])
    assert pc.intersects(hole, segment)
    assert not pc.intersects(hole, Solid([[0, 0, 0], [0, 0, np.nextafter(0.5, 0)]], [[0, 1, 1]]))


def test_radii_act_on_the_set():
    hole = Solid(*hollow())
    assert not pc.intersects(hole, pc.Sphere(0.4999))
    assert pc.intersects(hole, pc.Sphere(0.5))
    assert pc.intersects(hole, pc.Polytope(np.zeros((1, 3)), inflation_radius=0.5))


def test_bodies_may_be_given_in_many_ways():
    hole, box = Solid(*hollow()), pc.Box((0.2, 0.2, 0.2))
    prepared = pc.Polytope(hole)
    poses = np.array([at(x, 0, 0) for x in (0, 0.75, 5)])
    expected = [False, True, False]
    assert pc.intersects(prepared, box, None, poses).tolist() == expected
    assert pc.intersects(hole, pc.Polytope(box), None, poses, "walk").tolist() == expected
    assert [pc.intersects(pc.Placed(prepared), pc.Placed(pc.Polytope(box), pose)) for pose in poses] == expected
    assert pc.intersects(pickle.loads(pickle.dumps(prepared)), box, None, poses).tolist() == expected
    assert pc.intersects(pickle.loads(pickle.dumps(pc.Placed(prepared))), box, None, poses[0]) is False


def test_what_is_not_there_yet_says_so(tmp_path):
    hole = pc.Polytope(Solid(*hollow()))
    with pytest.raises(pc.PlannercheckError, match="pickle it"):
        hole.save(tmp_path / "hole.body")


# Against brute force.


def brute_force(a, pose_a, b, pose_b):
    """Whether two solids share a point: all triangles with all others, then points by their winding numbers."""
    (p, s), (r, t) = a.used, b.used
    posed = [x @ pose[:3, :3].T + pose[:3, 3] for x, pose in ((p, pose_a), (r, pose_b))]  # whole numbers: exact
    boxes = [(x[k].min(axis=1), x[k].max(axis=1)) for x, k in zip(posed, (s, t), strict=True)]
    near = ((boxes[0][0][:, None] <= boxes[1][1]) & (boxes[1][0] <= boxes[0][1][:, None])).all(axis=2)
    if any(exact_verdicts.intersects(posed[0][s[i]], posed[1][t[j]]) for i, j in np.argwhere(near).tolist()):
        return True
    whole = [np.array([[int(8 * x) for x in row] for row in each.tolist()], dtype=object) for each in posed]
    return any(
        around.is_closed and any(winding_number(outer - v, around.used[1]) for v in inner)
        for around, outer, inner in ((a, whole[0], whole[1]), (b, whole[1], whole[0]))
    )


def family():
    ring = trimesh.creation.torus(1, 0.4, major_sections=8, minor_sections=4)
    ring.vertices = np.round(ring.vertices * 8) / 8
    cube = (np.asarray(CUBE.vertices) * 0.5, np.asarray(CUBE.faces))
    small = (cube[0] * 0.125, cube[1])
    yield from (solid(ring), Solid(*angle()), Solid(*hollow()), Solid(*small), Solid(*cube))
    yield Solid(*joined(cube, (cube[0] + 0.5, cube[1])))  # crossing itself
    yield Solid(cube[0], cube[1][3:])  # open
    yield Solid(*cube, open="surface")
    yield Solid(TETRAHEDRON, [[1, 2, 3]])
    yield Solid(TETRAHEDRON, TRIANGLES[:, ::-1])


TURNS = [np.array(m, dtype=float) for m in ([[1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, -1, 0], [1, 0, 0], [0, 0, 1]])]


def test_pairs_against_brute_force():
    rng = np.random.default_rng(0)
    verdicts, enclosures = [], 0
    for a, b in itertools.combinations_with_replacement(family(), 2):
        is_small = min(np.ptp(each.used[0], axis=0).max() for each in (a, b)) < 0.3
        for _ in range(30 if is_small else 5):
            poses = [at(*rng.integers(-9, 10, 3) / 8) for _ in range(2)]
            for pose in poses:
                pose[:3, :3] = TURNS[rng.integers(2)]
            expected = brute_force(a, poses[0], b, poses[1])
            assert pc.intersects(a, b, *poses) == expected
            assert pc.intersects(b, a, *poses[::-1]) == expected
            verdicts.append(expected)
            if expected:
                certificate = pc.certify(a, b, *poses)
                assert certificate.verify()
                enclosures += isinstance(certificate, pc.Enclosure)
    assert 0.1 < np.mean(verdicts) < 0.9
    assert enclosures > 5


# Certificates.


def test_certificates_are_verified_and_changed_ones_are_not():
    hole, small = Solid(*hollow()), pc.Box((0.2, 0.2, 0.2))
    inside = pc.certify(hole, small, None, at(0.75, 0, 0))
    assert isinstance(inside, pc.Enclosure)
    assert inside.winding_number == 1
    assert not inside.first_is_inside
    assert inside.verify()
    assert pc.certify(small, hole, at(0.75, 0, 0)).first_is_inside
    other = copy.copy(inside)
    object.__setattr__(other, "winding_number", 2)
    assert not other.verify()
    object.__setattr__(other, "winding_number", 0)
    assert not other.verify()
    moved = copy.copy(inside)
    object.__setattr__(moved, "inner", type(inside.inner)(inside.inner.vertices, at(0.2, 0, 0)))
    assert not moved.verify()
    torn = copy.copy(inside)
    surface = inside.outer
    object.__setattr__(torn, "outer", type(surface)(surface.points, surface.triangles[1:], surface.pose))
    assert not torn.verify()
    touching = pc.certify(hole, small, None, at(0.5, 0, 0))
    assert isinstance(touching, pc.SharedPoint)
    assert touching.verify()
    assert isinstance(pc.certify(hole, small, None, at(5, 0, 0)), pc.Separation)


def test_winding_numbers_count():
    cube = np.array(CUBE.vertices, dtype=int).astype(object)
    corners = np.asarray(CUBE.faces)
    assert winding_number(cube, corners) == 1
    assert winding_number(cube, corners[:, ::-1]) == -1
    assert winding_number(cube, np.vstack([corners, corners])) == 2
    assert winding_number(cube + 3, corners) == 0
    assert winding_number(cube + 1, corners) is None  # a corner is at the origin
    assert winding_number(cube, np.vstack([corners, [[0, 0, 1], [2, 2, 2]]])) == 1


def test_rays_through_edges_and_vertices_are_not_used():
    """Around the origin, triangles whose edges and corners lie on the first rays that are tried."""
    for direction in solid_certificates._DIRECTIONS[:3]:
        d = np.array(direction)
        side = np.array([d[1], -d[0], 0])
        third = np.cross(d, side)
        # Of a tetrahedron around the origin: one corner, or the middle of one edge, on the ray.
        for corners in (
            [d, -d + side, -d - 2 * side + third, -d - third],
            [d + side, d - side, -d + third, -2 * d - third],
        ):
            points = np.array([[int(x) for x in corner] for corner in corners], dtype=object)
            assert abs(winding_number(points, TRIANGLES)) == 1
