"""Bounds of what is outside a cover, against dense samples, closed forms and fractions."""

import itertools
import math

import numpy as np
import pytest
from covering_oracle import distances, holds, random_cover, samples_in_hull

import plannercheck as pc
from plannercheck.bodies import exact_reference
from plannercheck.bodies.shapes import GeometryObject
from plannercheck.coverings import search
from plannercheck.coverings.primitives import Primitives
from plannercheck.coverings.regions import regions_of
from plannercheck.coverings.search import outside


def regions(shape, pose=None):
    return regions_of([GeometryObject("body", "link", np.eye(4) if pose is None else pose, shape)])


def turned(seed):
    rng = np.random.default_rng(seed)
    axis, angle = rng.normal(size=3), rng.uniform(0, 3)
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    pose = np.eye(4)
    pose[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    pose[:3, 3] = rng.normal(size=3)
    return pose


@pytest.mark.parametrize("seed", range(12))
def test_bounds_hold_dense_samples_of_hulls(seed):
    rng = np.random.default_rng(seed)
    vertices = rng.normal(size=(rng.integers(4, 20), 3))
    pose = np.eye(4) if seed % 2 else turned(seed)
    posed = vertices @ pose[:3, :3].T + pose[:3, 3]
    cover = random_cover(rng, rng.integers(1, 9), capsules=seed % 3)
    shift = pose[:3, 3]
    cover = Primitives(cover.ends + shift, cover.radii, cover.frames, cover.halves)
    found = outside(regions(pc.Hull(vertices), pose), cover, 1e-3)
    most = distances(cover, samples_in_hull(rng, posed, 20_000)).max()
    assert max(most, 0) <= found.upper + 1e-12
    assert found.upper - found.lower <= 1e-3 + 1e-12
    assert found.is_covered == (found.witness is None)
    if found.witness is not None:
        assert not holds(cover, found.witness)
        rounded = np.array([[float(x) for x in found.witness]])
        assert distances(cover, rounded)[0] == pytest.approx(found.lower, abs=1e-9)
        gap = exact_reference.distance(rounded, vertices, None, pose)
        assert gap is None or float(gap[0] if isinstance(gap, tuple) else gap) < 1e-12


def test_bounds_meet_where_a_whole_edge_is_furthest_outside():
    cover = Primitives.of(capsules=[((0, 0, -0.15), (0, 0, 0.15), 0.1)])
    found = outside(regions(pc.Box((0.05, 0.3, 0.1))), cover, 1e-6)
    assert found.lower <= math.hypot(0.025, 0.15) - 0.1 + 1e-12
    assert math.hypot(0.025, 0.15) - 0.1 <= found.upper <= found.lower + 1e-6


@pytest.mark.parametrize("radius", [0.11, 0.13, 0.15])
def test_a_hole_may_be_deeper_than_the_surface(radius):
    middle = np.array([0.0123, -0.0077, 0.0041])
    cover = Primitives.of([(middle + corner, radius) for corner in itertools.product((-0.1, 0.1), repeat=3)])
    pose = np.eye(4)
    pose[:3, 3] = middle
    found = outside(regions(pc.Box((0.2, 0.2, 0.2)), pose), cover, 1e-3)
    assert found.lower - 1e-12 <= math.sqrt(0.03) - radius <= found.upper <= found.lower + 1.1e-3


@pytest.mark.parametrize("seed", range(6))
def test_bounds_hold_dense_samples_of_triangles(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(9, 3))
    body = regions(pc.Solid(points, np.arange(9).reshape(3, 3), "triangles"))
    cover = random_cover(rng, 5, capsules=seed % 2)
    weights = rng.dirichlet(np.full(3, 0.5), (3, 5000))
    samples = np.einsum("tsk,tki->tsi", weights, points.reshape(3, 3, 3)).reshape(-1, 3)
    found = outside(body, cover, 1e-3)
    assert max(distances(cover, np.concatenate([points, samples])).max(), 0) <= found.upper + 1e-12
    assert found.upper - found.lower <= 1e-3 + 1e-12
    assert outside(body, cover.grown(found.upper), 1e-4).is_covered


@pytest.mark.parametrize("seed", range(12))
def test_the_upper_bound_as_growth_covers_and_less_does_not(seed):
    rng = np.random.default_rng(seed)
    body = regions(pc.Hull(rng.normal(size=(12, 3))))
    cover = random_cover(rng, 6, capsules=seed % 2)
    found = outside(body, cover, 1e-4)
    assert outside(body, cover.grown(found.upper), 1e-4).is_covered
    if found.lower > 1e-3:
        less = outside(body, cover.grown(found.lower - 1e-6), 1e-4)
        assert not less.is_covered
        assert less.witness is not None


def test_a_corner_on_the_sphere_is_covered_exactly_and_one_bit_less_is_not():
    box = regions(pc.Box((6, 8, 24)))  # its corners are 13 from the middle
    assert outside(box, Primitives.of([((0, 0, 0), 13.0)])).is_covered
    less = outside(box, Primitives.of([((0, 0, 0), math.nextafter(13, 0))]))
    assert not less.is_covered
    assert [abs(x) for x in less.witness] == [3, 4, 12]


def test_an_edge_that_two_spheres_share_exactly_is_covered():
    # Both spheres hold the corners and the middle of the long edges (0, ±4, ±...): 3-4-5 triangles.
    plate = regions(pc.Hull([(x, y, 0.0) for x in (-6, 6) for y in (-4, 4)]))
    cover = [((-3, 0, 0), 5.0), ((3, 0, 0), 5.0)]
    assert outside(plate, Primitives.of(cover)).is_covered
    thinner = [((-3, 0, 0), 5.0), ((3, 0, 0), math.nextafter(5, 0))]
    assert not outside(plate, Primitives.of(thinner)).is_covered


def test_a_hole_inside_is_found():
    """Spheres on all of a box's surface, none in its middle."""
    steps = np.linspace(-1, 1, 5)
    shell = [p for p in itertools.product(steps, repeat=3) if max(map(abs, p)) == 1]
    cover = Primitives.of([(p, 0.45) for p in shell])
    body = regions(pc.Box((2, 2, 2)))
    found = outside(body, cover, 1e-3)
    assert outside(body, cover, inside=False).is_covered
    assert found.lower == pytest.approx(0.55, abs=2e-3)
    assert max(abs(float(x)) for x in found.witness) < 0.1
    assert outside(body, cover + Primitives.of([((0, 0, 0), 1.1)])).is_covered


def test_the_middle_of_triangles_alone_need_not_be_covered():
    box = pc.Polytope(*pc.Box((2, 2, 2)).vertices_and_faces())
    triangles = list(np.array(box.faces).tolist())
    shell = [p for p in itertools.product(np.linspace(-1, 1, 5), repeat=3) if max(map(abs, p)) == 1]
    cover = Primitives.of([(p, 0.45) for p in shell])
    body = pc.Solid(box.vertices, triangles + triangles[:1], "triangles")
    assert outside(regions(body), cover).is_covered


def test_the_middle_of_a_triangle_is_found():
    body = regions(pc.Solid([(0, 0, 0), (2, 0, 0), (0, 2, 0)], [(0, 1, 2)], "triangles"))
    found = outside(body, Primitives.of([((0, 0, 0), 0.8), ((2, 0, 0), 0.8), ((0, 2, 0), 0.8)]), 1e-4)
    assert found.lower <= math.sqrt(2) - 0.8 <= found.upper < found.lower + 1.1e-4
    assert [float(x) for x in found.witness] == pytest.approx([1, 1, 0], abs=1e-3)


def test_a_ring_is_not_its_hull():
    """A solid with a hole through it is covered by spheres along it, its hull is not."""
    angles = np.linspace(0, 2 * np.pi, 25)[:-1]
    square = [(0.8, -0.1), (1.2, -0.1), (1.2, 0.1), (0.8, 0.1)]
    points = np.array([(r * np.cos(a), r * np.sin(a), z) for a in angles for r, z in square])
    triangles = []
    for i, k in itertools.product(range(24), range(4)):
        a, b, c, d = 4 * i + k, 4 * i + (k + 1) % 4, 4 * ((i + 1) % 24) + k, 4 * ((i + 1) % 24) + (k + 1) % 4
        triangles += [(a, c, b), (b, c, d)]
    cover = Primitives.of([((np.cos(a), np.sin(a), 0.0), 0.35) for a in angles])
    assert outside(regions(pc.Solid(points, triangles)), cover).is_covered
    hull = outside(regions(pc.Hull(points)), cover, 1e-3)
    assert hull.lower == pytest.approx(math.hypot(1, 0.1) - 0.35, abs=2e-3)


@pytest.mark.parametrize("pose", [np.eye(4), turned(5)])
def test_curved_bodies_have_their_closed_forms(pose):
    centre = pose[:3, 3].tolist()
    for shape, far in (
        (pc.Sphere(0.5), 0.5),
        (pc.Capsule(0.3, 1.0), 0.8),
        (pc.Cylinder(0.3, 0.8), 0.5),
    ):
        cover = Primitives.of([(centre, far - 0.1)])
        found = outside(regions(shape, pose), cover, 1e-3)
        assert found.lower <= 0.1 + 1e-12
        assert found.upper >= 0.1 - 1e-12
        assert found.upper - found.lower < 1e-3 + 1e-9
        assert not holds(cover, found.witness)
        assert outside(regions(shape, pose), Primitives.of([(centre, far + 1e-6)])).is_covered


def test_curved_bodies_are_covered_by_their_equals():
    assert outside(regions(pc.Sphere(0.5)), Primitives.of([((0, 0, 0), 0.5)])).is_covered
    assert not outside(regions(pc.Sphere(0.5)), Primitives.of([((0, 0, 0), math.nextafter(0.5, 0))])).is_covered
    capsule = Primitives.of(capsules=[((0, 0, -0.5), (0, 0, 0.5), 0.3)])
    for shape in (pc.Capsule(0.3, 1.0), pc.Cylinder(0.3, 1.0)):
        assert outside(regions(shape), capsule).is_covered
        assert outside(regions(shape, turned(1)), capsule).lower > 0
    longer = outside(regions(pc.Cylinder(0.3, 1.4)), capsule, 1e-4)
    assert longer.lower <= math.hypot(0.3, 0.2) - 0.3 <= longer.upper < longer.lower + 2e-4
    assert outside(regions(pc.Cylinder(3, 8)), Primitives.of([((0, 0, 0), 5.0)])).is_covered


@pytest.mark.parametrize("seed", range(9))
def test_bounds_hold_dense_samples_of_curved_bodies(seed):
    rng, pose = np.random.default_rng(seed), turned(seed)
    radius, length = rng.uniform(0.2, 1, 2)
    angles, heights = rng.uniform(0, 2 * np.pi, 20_000), rng.choice([-1.0, 1.0, 0.3], 20_000) * length / 2
    inside = np.sqrt(rng.choice([0.0, 0.5, 1.0], 20_000))
    points = np.column_stack([inside * np.cos(angles), inside * np.sin(angles), heights / radius]) * radius
    shape = (pc.Cylinder(radius, length), pc.Capsule(radius, length), pc.Sphere(radius))[seed % 3]
    if seed % 3:
        directions = rng.normal(size=(20_000, 3))
        points = radius * directions / np.linalg.norm(directions, axis=1, keepdims=True)
        points[:, 2] += rng.uniform(-1, 1, 20_000) * (length / 2 if seed % 3 == 1 else 0)
    points = points @ pose[:3, :3].T + pose[:3, 3]
    cover = random_cover(rng, 5, capsules=seed % 2)
    cover = Primitives(cover.ends / 2 + pose[:3, 3], cover.radii, cover.frames, cover.halves)
    found = outside(regions(shape, pose), cover, 1e-3)
    assert max(distances(cover, points).max(), 0) <= found.upper + 1e-12
    assert found.upper - found.lower <= 1e-3 + 1e-12
    assert outside(regions(shape, pose), cover.grown(found.upper + 1e-6)).is_covered


def test_a_cylinder_between_two_spheres():
    """The seam of two spheres is a circle of radius 4: cylinders of less are covered, of more they are not."""
    cover = Primitives.of([((0, 0, -3), 5.0), ((0, 0, 3), 5.0)])
    assert outside(regions(pc.Cylinder(3.999, 6)), cover).is_covered
    found = outside(regions(pc.Cylinder(4.01, 6)), cover, 1e-3)
    assert 0 < found.lower <= math.hypot(3, 4.01) - 5 <= found.upper


def test_boxes_and_capsules_cover():
    box = regions(pc.Box((2, 2, 2)))
    assert outside(box, Primitives.of(boxes=[(np.eye(4), (2, 2, 2))])).is_covered
    quarter = turned(0)
    quarter[:3, :3], quarter[:3, 3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]], 0
    found = outside(box, Primitives.of(boxes=[(quarter, (2, 1.5, 2))]))
    assert found.lower == pytest.approx(0.25, abs=1e-4)
    assert not holds(Primitives.of(boxes=[(quarter, (2, 1.5, 2))]), found.witness)
    assert outside(box, Primitives.of(boxes=[(quarter, (2, 1.5, 2))]).grown(0.25)).is_covered
    up, down = np.eye(4), np.eye(4)
    up[2, 3], down[2, 3] = 0.5, -0.5
    assert outside(box, Primitives.of(boxes=[(up, (2, 2, 1)), (down, (2, 2, 1))])).is_covered  # flush, which is a tie
    halves = Primitives.of(boxes=[(np.eye(4), (2, 2, 1))], capsules=[((0, 0, 0.6), (0, 0, 0.9), 1.5)])
    assert outside(box, halves).lower > 0


def test_curved_bodies_bulge_out_of_their_corners():
    """A box whose side cuts off less than the arc between the corners of a first cell."""

    def box(normal, at):
        """All points with (x, normal) <= at, as far as it matters."""
        x = np.array(normal) / np.linalg.norm(normal)
        y = np.cross(x, [0.6, 0, 0.8])
        y /= np.linalg.norm(y)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = np.column_stack([x, y, np.cross(x, y)]), (at - 10) * x
        return Primitives.of(boxes=[(pose, (20, 20, 20))])

    for shape, normal in ((pc.Cylinder(1, 1), (np.cos(np.pi / 6), np.sin(np.pi / 6), 0)), (pc.Sphere(1), (1, 1, 1))):
        found = outside(regions(shape), box(normal, 0.9), 1e-3)
        assert found.lower <= 0.1 <= found.upper < 0.102
        assert found.witness is not None
        assert outside(regions(shape), box(normal, 1.001)).is_covered


def test_links_without_primitives_are_all_outside():
    found = outside(regions(pc.Box((2, 2, 2))), Primitives.of())
    assert found.upper == math.inf
    assert found.witness is not None
    assert outside(regions(pc.Sphere(1)), Primitives.of()).witness is not None


def test_signs_by_doubles_alone_agree_where_they_are_sure(monkeypatch):
    """Without fractions, only ties are no longer proved."""
    rng = np.random.default_rng(1)
    body, cover = regions(pc.Hull(rng.normal(size=(12, 3)))), random_cover(rng, 6)
    plate = regions(pc.Hull([(x, y, 0.0) for x in (-6, 6) for y in (-4, 4)]))
    tie = Primitives.of([((-3, 0, 0), 5.0), ((3, 0, 0), 5.0)])
    plain = outside(body, cover, 1e-4)
    assert outside(plate, tie).is_covered
    monkeypatch.setattr(search, "_MOST_EXACT", 0)
    assert outside(body, cover, 1e-4).upper == plain.upper
    assert not outside(plate, tie).is_covered
