"""Caps of open meshes: what they close, how little they add, and that triangles ⊆ capped ⊆ hull."""

import pickle
from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
import solid_meshes
import trimesh
from poses import at

import plannercheck as pc
from plannercheck import _oracle
from plannercheck.bodies import caps
from plannercheck.bodies.caps import SEAM
from plannercheck.bodies.solids import Solid
from plannercheck.evaluation.stress_solids.torn import TEARS, torn

CUBE = trimesh.creation.box((2, 2, 2))
BALL = trimesh.creation.icosphere(2)
IDENTITY = np.eye(4)


def mesh(given):
    return np.array(given.vertices), np.array(given.faces)


def without_top(given):
    """Without the triangles of the highest face."""
    points, triangles = given
    top = (points[triangles][:, :, 2] == points[:, 2].max()).all(axis=1)
    return points, triangles[~top]


def cup(around=24):
    """An open cup: a cylinder with a hollow, its rim, its floor; closed as a mesh."""
    angle = 2 * np.pi * np.arange(around) / around
    circle = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(around)])
    rings = [circle, circle + np.array([0, 0, 2]), circle * 0.8 + [0, 0, 2], circle * 0.8 + [0, 0, 0.2]]
    points = np.vstack([*rings, [[0, 0, 0], [0, 0, 0.2]]])
    here, following = np.arange(around), (np.arange(around) + 1) % around
    bottom, top = np.full(around, 4 * around), np.full(around, 4 * around + 1)
    triangles = [np.column_stack([bottom, following, here])]
    for low, high in pairwise(range(0, 4 * around, around)):
        triangles.append(np.column_stack([low + here, low + following, high + following]))
        triangles.append(np.column_stack([low + here, high + following, high + here]))
    triangles.append(np.column_stack([top, 3 * around + here, 3 * around + following]))
    return points, np.vstack(triangles)


def with_split_rim(given, apart=0.0):
    """A cup whose outer wall has a vertex more on each edge of the rim, which its rim does not have: T-junctions."""
    points, triangles = list(given[0]), given[1].tolist()
    around = (len(points) - 2) // 4
    for k in range(around):
        a, b = around + k, around + (k + 1) % around
        at = next(t for t, corners in enumerate(triangles) if {a, b} <= set(corners) and min(corners) < around)
        c = next(corner for corner in triangles[at] if corner not in (a, b))
        a, b = next((x, y) for x, y in ((a, b), (b, a)) if [x, y, c] in rotations(triangles[at]))
        points.append((points[a] + points[b]) / 2 + [0, 0, apart])
        triangles[at] = [a, len(points) - 1, c]
        triangles.append([len(points) - 1, b, c])
    return np.array(points), np.array(triangles)


def rotations(corners):
    return [corners, corners[1:] + corners[:1], corners[2:] + corners[:2]]


def soup(given, apart, seed=0):
    """Each triangle with corners of its own, apart by up to a part of the size."""
    points, triangles = given
    corners = points[triangles].reshape(-1, 3)
    shift = np.random.default_rng(seed).uniform(-1, 1, corners.shape)
    return corners + apart * np.ptp(points, axis=0).max() * shift / 4, np.arange(len(corners)).reshape(-1, 3)


def turned(given, some):
    points, triangles = given
    triangles = triangles.copy()
    triangles[some] = triangles[some, ::-1]
    return points, triangles


def moebius():
    strip = np.array([[np.cos(t), np.sin(t), 0] for t in 2 * np.pi * np.arange(12) / 12])
    half = np.array(
        [[np.cos(t) * np.cos(t / 2), np.sin(t) * np.cos(t / 2), np.sin(t / 2)] for t in 2 * np.pi * np.arange(12) / 12]
    )
    points = np.vstack([strip + 0.3 * half, strip - 0.3 * half])
    quads = [(k, k + 1, k + 13, k + 12) for k in range(11)] + [(11, 12, 0, 23)]
    return points, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


NAMED = {
    "a missing triangle": (mesh(CUBE)[0], mesh(CUBE)[1][1:]),
    "a missing face": without_top(mesh(CUBE)),
    "two missing faces": without_top((mesh(CUBE)[0] * [1, 1, -1], without_top(mesh(CUBE))[1][:, ::-1])),
    "a cup without its floor": (cup()[0], cup()[1][24:]),
    "T-junctions along a rim": with_split_rim(cup()),
    "gaps along a rim": with_split_rim(cup(), 1e-9),
    "vertices apart by 1e-9": soup(mesh(BALL), 1e-9),
    "vertices apart by 1e-5": soup(mesh(BALL), 1e-5),
    "turned triangles": turned(mesh(BALL), [3, 17, 40, 41, 42]),
    "halves turned against each other": turned(mesh(BALL), slice(0, 160)),
    "several components": solid_meshes.both(without_top(mesh(CUBE)), (mesh(BALL)[0] + 5, mesh(BALL)[1][20:])),
    "a triangle": (np.eye(3), np.array([[0, 1, 2]])),
    "an edge of three triangles": (np.vstack([np.eye(3), -np.eye(3)]), np.array([[0, 1, 2], [0, 1, 3], [0, 1, 5]])),
    "a triangle twice": (mesh(CUBE)[0], np.vstack([mesh(CUBE)[1], mesh(CUBE)[1][:1]])),
    "a Möbius strip": moebius(),
    "a pinched hole": (mesh(BALL)[0], mesh(BALL)[1][(mesh(BALL)[1] != 7).all(axis=1)][8:]),
}


def edge_sums(triangles):
    """How often each directed edge occurs, less its reverse."""
    found = Counter()
    for a, b, c in np.asarray(triangles).tolist():
        for tail, head in ((a, b), (b, c), (c, a)):
            found[tail, head] += 1
            found[head, tail] -= 1
    return {edge: count for edge, count in found.items() if count}


def check(points, triangles):
    """Of an open mesh: the capped one keeps its triangles, adds no points, and is closed. The solid."""
    made = Solid(points, triangles)
    alone = Solid(points, triangles, "triangles")
    assert made.is_open
    assert made.kind == "capped"
    assert edge_sums(alone.used[1])
    np.testing.assert_array_equal(made.used[0], alone.used[0])
    np.testing.assert_array_equal(made.used[1][: len(triangles)], alone.used[1])
    assert not edge_sums(made.used[1])
    assert made.core.is_closed
    assert _oracle.Mesh(*made.used, 0.0).is_closed
    return made


@pytest.mark.parametrize("name", NAMED)
def test_caps_close_open_meshes(name):
    made = check(*NAMED[name])
    assert made.caps.loops or made.caps.seams


@pytest.mark.parametrize("tear", TEARS)
def test_caps_close_torn_meshes(tear):
    rng, seen = np.random.default_rng(5), 0
    for _ in range(15):
        found = torn(60, rng)
        for _ in range(2):
            found = TEARS[tear](found, rng)
        if Solid(found.points, found.triangles).is_open:
            check(found.points, found.triangles)
            seen += 1
    assert seen > 8


@pytest.mark.parametrize("name", NAMED)
def test_triangles_collide_only_if_capped_do_and_these_only_if_hulls_do(name):
    points, triangles = NAMED[name]
    capped, alone, hull = Solid(points, triangles), Solid(points, triangles, "triangles"), pc.Polytope(points)
    rng, size = np.random.default_rng(1), np.ptp(points, axis=0).max()
    poses = np.tile(np.eye(4), (400, 1, 1))
    poses[:, :3, 3] = points.mean(axis=0) + rng.uniform(-0.7, 0.7, (400, 3)) * np.ptp(points, axis=0)
    poses[:100, :3, 3] = points[rng.integers(len(points), size=100)]  # corners, exactly
    for other in (pc.Polytope(np.zeros((1, 3))), pc.Box((0.05 * size,) * 3), Solid(points * 0.3, triangles)):
        few, some, most = (np.asarray(pc.intersects(body, other, None, poses)) for body in (alone, capped, hull))
        assert (few <= some).all()
        assert (some <= most).all()
    used = np.unique(triangles)
    at_corners = np.array([at(*point) for point in points[used]])
    assert pc.intersects(capped, pc.Polytope(np.zeros((1, 3))), None, at_corners).all()


def test_what_was_closed_is_said():
    said = {name: check(*NAMED[name]).caps for name in NAMED}
    assert (said["a missing triangle"].loops, said["a missing triangle"].edges) == (1, 3)
    assert (said["a missing face"].loops, said["a missing face"].edges, said["a missing face"].size) == (1, 4, 2.0)
    assert said["two missing faces"].loops == 2
    assert (said["a cup without its floor"].loops, said["a cup without its floor"].edges) == (1, 24)
    assert said["T-junctions along a rim"].loops == 24
    assert (said["vertices apart by 1e-9"].loops, said["vertices apart by 1e-9"].seams > 900) == (0, True)
    assert said["vertices apart by 1e-5"].loops == len(BALL.faces)  # each one has a back of its own
    assert said["turned triangles"].loops >= 2 * 3
    assert str(said["a missing face"]) == "1 loop of 4 edges, largest cap 2 m"
    assert Solid(*mesh(CUBE)).caps is None


@pytest.mark.parametrize("name", ["a missing triangle", "a missing face", "two missing faces"])
def test_flat_holes_of_convex_bodies_are_filled_exactly(name):
    assert Solid(*NAMED[name]).equals_hull
    assert not Solid(*NAMED[name], "triangles").equals_hull


@pytest.mark.parametrize("some", [[3], [3, 17, 40], slice(0, 160), slice(0, 319)])
def test_turned_triangles_change_nothing_about_the_inside(some):
    """The middle of a ball, and of each half of one whose halves are turned against each other."""
    made = Solid(*turned(mesh(BALL), some))
    inside = np.array([at(*(0.5 * x)) for x in np.vstack([np.eye(3), -np.eye(3), np.zeros((1, 3))])])
    assert pc.intersects(made, pc.Sphere(0.01), None, inside).all()


@pytest.mark.parametrize("name", ["T-junctions along a rim", "gaps along a rim"])
@pytest.mark.parametrize("is_inverted", [False, True])
@pytest.mark.parametrize("axes", [[0, 1, 2], [1, 2, 0], [2, 0, 1]])
def test_slits_along_a_rim_do_not_close_its_mouth(name, is_inverted, axes):
    """Whichever edge comes first: with the axis along x, all edges of the rim come before those of the wall."""
    points, triangles = NAMED[name]
    made = Solid(points[:, axes], triangles[:, ::-1] if is_inverted else triangles)
    small, places = pc.Sphere(0.1), np.array([[0, 0, 1], [0, 0, 1.95], [0.9, 0.01, 1]])[:, axes]
    assert not pc.intersects(made, small, None, at(*places[0]))
    assert not pc.intersects(made, small, None, at(*places[1]))
    assert pc.intersects(made, pc.Polytope(places[2:]))  # in its wall
    assert made.caps.size < 0.3


@pytest.mark.parametrize("apart", [1e-16, 1e-12, 1e-9, 1e-7])
@pytest.mark.parametrize("shift", [0.0, 1e3])
def test_seams_are_closed_by_slivers(apart, shift):
    """The gaps stay open for nothing that is larger, and a point in the middle is inside."""
    points, triangles = soup(cup(), apart)
    made = Solid(points + shift, triangles)
    assert made.caps is None or made.caps.loops == 0
    assert not pc.intersects(made, pc.Sphere(0.1), None, at(shift, shift, 1 + shift))
    assert pc.intersects(made, pc.Polytope(np.array([[0.9, 0.01, 1]]) + shift))


def test_chains_of_close_vertices_do_not_grow():
    """Of vertices in a row that is longer than a seam, none is joined with one that is further away than a seam."""
    rng = np.random.default_rng(4)
    row = np.cumsum(rng.uniform(0, 0.8 * SEAM, (300, 3)) * [1, 0, 0], axis=0)
    points = np.unique(np.vstack([row, row + np.array([0, 1, 0])]), axis=0)
    edges = np.column_stack([np.arange(len(points)), np.roll(np.arange(len(points)), 1)])
    found = caps._representatives(points, edges)
    assert np.linalg.norm(points - points[found], axis=1).max() <= SEAM * (1 + 1e-9)
    assert 100 < len(np.unique(found)) < 400
    assert (found[found] == found).all()


@pytest.mark.parametrize("scale", [2.0**-1060, 2.0**-300, 1.0, 2.0**150])
def test_sizes_do_not_matter(scale):
    for name in ("a missing face", "T-junctions along a rim", "turned triangles", "vertices apart by 1e-9"):
        points, triangles = NAMED[name]
        one, other = Solid(points, triangles), Solid(points * scale, triangles)
        if scale > 2.0**-1000:
            np.testing.assert_array_equal(one.used[1], other.used[1])
        assert not edge_sums(other.used[1])


def test_the_order_of_vertices_and_triangles_does_not_matter():
    rng = np.random.default_rng(3)
    for points, triangles in NAMED.values():
        place = rng.permutation(len(points))
        order = rng.permutation(len(triangles))
        shuffled = Solid(points[np.argsort(place)], place[triangles][order])
        one, other = Solid(points, triangles), shuffled
        np.testing.assert_array_equal(one.used[0], other.used[0])
        np.testing.assert_array_equal(one.used[1][len(triangles) :], other.used[1][len(triangles) :])


def test_without_time_for_shortest_loops_any_are_closed(monkeypatch):
    monkeypatch.setattr(caps, "_MOST_VISITS", 0)
    for points, triangles in NAMED.values():
        check(points, triangles)
    assert not pc.intersects(Solid(*NAMED["a missing face"]), pc.Sphere(0.1), None, at(0, 0, 3))


def test_triangles_alone_and_hulls_are_choices():
    points, triangles = without_top(mesh(CUBE))
    small = pc.Box((0.2, 0.2, 0.2))
    capped, alone, hull = (Solid(points, triangles, kind) for kind in ("cap", "triangles", "hull"))
    assert [pc.intersects(body, small) for body in (capped, alone, hull)] == [True, False, True]
    assert [body.kind for body in (capped, alone, hull)] == ["capped", "open", "hull"]
    assert [body.is_closed for body in (capped, alone, hull)] == [True, False, True]
    assert len({body.digest for body in (capped, alone, hull)}) == 3
    for body in (capped, alone, hull):
        again = pickle.loads(pickle.dumps(body))
        assert (again.open, again.digest) == (body.open, body.digest)
        np.testing.assert_array_equal(body.triangles, triangles)
    assert Solid(*mesh(CUBE), "triangles").digest == Solid(*mesh(CUBE)).digest
    bowl = Solid(*without_top(cup()), "hull")
    assert pc.intersects(bowl, small, None, at(0, 0, 1.5))
    assert not edge_sums(bowl.used[1])


@pytest.mark.parametrize("points", [[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]])
def test_hulls_of_flat_meshes(points):
    made = Solid(points, [[0, 1, 2]] if len(points) == 3 else [[0, 1, 2], [0, 2, 1], [1, 2, 3]], "hull")
    assert made.equals_hull
    assert made.digest != Solid(made.vertices, made.triangles, "triangles").digest
    middle = np.mean(points, axis=0)
    assert pc.intersects(made, pc.Polytope(middle[None]))
    assert pc.intersects(made, pc.Sphere(0.01), None, at(*middle))


@pytest.mark.parametrize("given", ["caps", "", None, 3, ["cap"], np.array([1, 2])])
def test_unknown_choices_are_refused(given):
    with pytest.raises(
        pc.PlannercheckError, match=r"unknown way to take an open mesh .*valid are cap, triangles, hull"
    ):
        Solid(*mesh(CUBE), given)


@pytest.mark.parametrize("kind", ["cap", "triangles", "hull"])
def test_files_say_what_is_done(tmp_path, kind):
    trimesh.Trimesh(*without_top(mesh(CUBE)), process=False).export(tmp_path / "open.stl")
    words = {"cap": "caps close", "triangles": "triangles alone", "hull": "are their hulls"}[kind]
    with pytest.warns(
        RuntimeWarning, match=rf"open\.stl.*{words}.*the mesh \(1 loop of 4 edges, largest cap 2 m\)"
    ) as caught:
        made = Solid.load(tmp_path / "open.stl", open=kind)
    assert len(caught) == 1
    assert made.open == kind


@pytest.mark.parametrize(
    "name", ["a missing face", "a cup without its floor", "several components", "turned triangles"]
)
def test_certificates_of_capped_solids_verify(name):
    capped, small = Solid(*NAMED[name]), pc.Box((0.1, 0.1, 0.1))
    rng, kinds = np.random.default_rng(2), set()
    for _ in range(30):
        pose = at(*(NAMED[name][0].mean(axis=0) + rng.uniform(-0.6, 0.6, 3) * np.ptp(NAMED[name][0], axis=0)))
        found = pc.certify(capped, small, None, pose)
        assert found.verify()
        kinds.add(type(found).__name__)
    assert len(kinds) > 1
