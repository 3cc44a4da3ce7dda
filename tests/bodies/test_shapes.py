"""Polytopes of curved shapes contain them and are closed and convex, exactly; bad sizes are named."""

import dataclasses
import math
from collections import Counter
from fractions import Fraction

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies.polytope import prepared
from plannercheck.bodies.shapes import (
    Box,
    Capsule,
    Cone,
    Cylinder,
    GeometryObject,
    Hull,
    Sphere,
    checked_pose,
    inflated_hull,
)
from plannercheck.common.errors import PlannercheckError
from plannercheck.view.surfaces import surface_of

CURVED = [
    Sphere(0.37),
    Cylinder(0.05, 0.4),
    Cylinder(3.0, 1e-3),
    Cone(0.2, 0.7),
    Cone(1.0, 1e-3),
    Capsule(0.06, 0.25),
    Capsule(1e-3, 20.0),
]
EXCESSES = [1.0, 0.3, 0.05, 1e-2, 1e-3]


def integers(vertices):
    """Vertices as Python integers, all scaled by one power of two, and that power."""
    fractions = [[Fraction(float(c)) for c in v] for v in vertices]
    scale = max(c.denominator for v in fractions for c in v)
    return np.array([[int(c * scale) for c in v] for v in fractions], dtype=object), scale


def triangles_of(faces):
    return [(int(f[0]), int(f[k]), int(f[k + 1])) for f in faces for k in range(1, len(f) - 1)]


def planes(points, triangles):
    """Outward normals and offsets of the triangles, in exact integers."""
    a, b, c = (points[[t[k] for t in triangles]] for k in range(3))
    u, v = b - a, c - a
    normal = np.stack([u[:, i] * v[:, j] - u[:, j] * v[:, i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=1)
    return normal, (normal * a).sum(axis=1)


def assert_closed_and_convex(vertices, faces):
    points, _ = integers(vertices)
    triangles = triangles_of(faces)
    edges = {(t[k], t[(k + 1) % 3]): t[(k + 2) % 3] for t in triangles for k in range(3)}
    assert len(edges) == 3 * len(triangles), "an edge is used twice in one direction"
    assert set(edges) == {(b, a) for a, b in edges}, "the surface is not closed"
    assert len({i for e in edges for i in e}) == len(points), "a vertex is in no face"
    normals, offsets = planes(points, triangles)
    for k in range(3):
        opposite = [edges[t[(k + 1) % 3], t[k]] for t in triangles]
        heights = (normals * points[opposite]).sum(axis=1) - offsets
        assert (heights <= 0).all(), "a surface edge is concave"
    centre = points.sum(axis=0)
    assert ((normals * centre).sum(axis=1) < offsets * len(points)).all(), "a face looks inwards"


def assert_polygons_flat(vertices, faces):
    points, _ = integers(vertices)
    for face in (f for f in faces if len(f) > 3):
        normal, offset = planes(points, [tuple(face[:3])])
        assert ((points[face] * normal).sum(axis=1) == offset).all()


def radius_within(shape, normal, offset):
    """Whether the shape is on the inner side of a plane, exactly: support function against offset."""
    x, y, z = normal
    half = Fraction(getattr(shape, "length", 0.0)) / 2
    radius = Fraction(shape.radius)
    if isinstance(shape, Cone):
        if z * half > offset:
            return False
        room, across = offset + z * half, x * x + y * y
    elif isinstance(shape, Cylinder):
        room, across = offset - abs(z) * half, x * x + y * y
    else:
        room, across = offset - abs(z) * half, x * x + y * y + z * z
    return room >= 0 and room * room >= radius * radius * across


@pytest.mark.parametrize("excess", EXCESSES)
@pytest.mark.parametrize("shape", CURVED, ids=str)
def test_curved_shapes_are_contained(shape, excess):
    vertices, faces = shape.vertices_and_faces(excess)
    points, scale = integers(vertices)
    normals, offsets = planes(points, triangles_of(faces))
    unique = {(*map(int, n), int(o)) for n, o in zip(normals, offsets, strict=True)}
    assert all(radius_within(shape, plane[:3], Fraction(plane[3], scale)) for plane in unique)


@pytest.mark.parametrize("excess", EXCESSES)
@pytest.mark.parametrize("shape", CURVED, ids=str)
def test_points_stick_out_by_at_most_the_excess(shape, excess):
    vertices, _ = shape.vertices_and_faces(excess)
    half = getattr(shape, "length", 0.0) / 2
    if isinstance(shape, Sphere | Capsule):
        core = np.clip(vertices, [0, 0, -half], [0, 0, half])
        distance = np.linalg.norm(vertices - core, axis=1)
    else:
        assert set(np.abs(vertices[:, 2])) == {half}
        distance = np.linalg.norm(vertices[:, :2], axis=1)
    assert distance.max() <= shape.radius * (1 + excess) * (1 + 1e-15) + 4e-16 * half


@pytest.mark.parametrize("excess", EXCESSES)
@pytest.mark.parametrize("shape", [Box((0.1, 2.0, 1e-4)), *CURVED], ids=str)
def test_faces_form_a_closed_convex_surface(shape, excess):
    vertices, faces = shape.vertices_and_faces(excess)
    assert_closed_and_convex(vertices, faces)
    assert_polygons_flat(vertices, faces)


def test_a_box_has_full_edge_lengths():
    vertices, _ = Box((0.1, 0.2, 0.3)).vertices_and_faces()
    assert np.ptp(vertices, axis=0).tolist() == [0.1, 0.2, 0.3]
    assert np.allclose(vertices.mean(axis=0), 0)


def test_a_cone_points_up():
    vertices, _ = Cone(0.1, 0.5).vertices_and_faces()
    assert vertices[vertices[:, 2] > 0].tolist() == [[0.0, 0.0, 0.25]]


def test_number_of_points_at_the_default_excess():
    sizes = [len(s.vertices_and_faces()[0]) for s in (Sphere(1.0), Cylinder(1.0, 1.0), Cone(1.0, 1.0))]
    assert sizes == [33126, 448, 225]


def test_a_capsule_too_long_for_its_faces_leaves_the_hull_to_others():
    assert Capsule(1e-7, 1.0).vertices_and_faces(0.1)[1] is None


@pytest.mark.parametrize(
    ("shape", "dimension", "corners"),
    [
        (Box((0, 1, 2)), 2, 4),
        (Box((5e-324, 1, 2)), 2, 4),
        (Box((1, 0, 0)), 1, 2),
        (Box((0, 0, 0)), 0, 1),
        (Sphere(0), 0, 1),
        (Cylinder(0, 1), 1, 2),
        (Cylinder(1, 0), 2, 224),
        (Cylinder(0, 0), 0, 1),
        (Cone(0, 1), 1, 2),
        (Cone(1, 0), 2, 224),
        (Capsule(0, 1), 1, 2),
        (Capsule(0, 0), 0, 1),
    ],
    ids=str,
)
def test_a_size_of_zero_makes_plates_segments_and_points(shape, dimension, corners):
    vertices, faces, inflation_radius = inflated_hull(shape)
    assert faces is None
    assert inflation_radius == 0
    polytope = prepared(vertices)
    assert polytope.dimension == dimension
    assert len(polytope.vertices) == corners
    drawn, triangles = surface_of(shape, "it")
    assert len(drawn) > dimension
    assert (len(triangles) > 0) == (dimension == 2)


def test_a_capsule_of_length_zero_is_a_ball():
    vertices, _, inflation_radius = inflated_hull(Capsule(0.5, 0))
    assert vertices.tolist() == [[0, 0, 0]]
    assert inflation_radius == 0.5
    assert np.array_equal(Capsule(0.5, 0).vertices_and_faces()[0], Sphere(0.5).vertices_and_faces()[0])


def test_a_plate_touches_exactly():
    plate, pose = prepared(inflated_hull(Box((0.5, 0.5, 0.0)))[0]), np.eye(4)
    assert pc.intersects(plate, plate, None, pose)
    pose[2, 3] = 2.0**-40
    assert not pc.intersects(plate, plate, None, pose)


def test_a_hull_keeps_its_points_read_only():
    source = np.random.default_rng(0).normal(size=(10, 3))
    hull = Hull(source)
    source[:] = 0
    assert hull.vertices_and_faces()[1] is None
    assert hull.vertices.any()
    with pytest.raises(ValueError, match="read-only"):
        hull.vertices[0] = 0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Box((1, 2)), "box size needs 3"),
        (lambda: Box((1, -1, 1)), "box size y must be finite and not negative"),
        (lambda: Box("abc"), "box size must be"),
        (lambda: Sphere(-1), "sphere radius must be finite and not negative"),
        (lambda: Sphere(math.nan), "sphere radius must be finite"),
        (lambda: Cylinder(1, math.inf), "cylinder length"),
        (lambda: Capsule("wide", 1), "capsule radius must be a number"),
        (lambda: Cone(-1, 1), "cone radius"),
        (lambda: Hull(np.zeros((5, 2))), r"shape \(n, 3\), not \(5, 2\)"),
        (lambda: Hull(np.zeros((3, 3))), "at least 4 points, here are 3"),
        (lambda: Hull([[0, 0, 0]] * 4 + [[0, math.nan, 1]]), "row 4"),
        (lambda: Sphere(1).vertices_and_faces(0), "excess"),
        (lambda: Sphere(1).vertices_and_faces(1e-9), "give 4e-06 or more"),
        (lambda: Cylinder(1, 1).vertices_and_faces(math.nan), "excess"),
    ],
)
def test_bad_sizes_are_named(make, message):
    with pytest.raises(PlannercheckError, match=message):
        make()


def posed(change):
    pose = np.eye(4)
    change(pose)
    return pose


def set_entry(index, value):
    def change(pose):
        pose[index] = value

    return change


@pytest.mark.parametrize(
    ("pose", "message"),
    [
        (np.eye(3), r"shape \(4, 4\)"),
        (posed(set_entry((0, 3), math.nan)), "not finite"),
        (posed(set_entry((3, 0), 1.0)), "last row"),
        (posed(set_entry((0, 0), 1.001)), "not rigid"),
        (posed(set_entry((2, 2), -1.0)), "reflection"),
        ("pose", "array of numbers"),
    ],
)
def test_bad_poses_name_the_body(pose, message):
    with pytest.raises(PlannercheckError, match=f"body 'shelf'.*{message}"):
        GeometryObject("shelf", None, pose, Sphere(1))


def test_poses_keep_their_doubles():
    pose = np.eye(4)
    pose[:3, :3] += 1e-8
    kept = checked_pose(pose, "body")
    assert kept.tolist() == pose.tolist()
    assert not kept.flags.writeable
    assert checked_pose(None, "body").tolist() == np.eye(4).tolist()


def test_bodies_are_frozen():
    body = GeometryObject("a", None, np.eye(4), Box((1, 1, 1)))
    with pytest.raises(dataclasses.FrozenInstanceError):
        body.name = "b"
    assert Counter([body])[body] == 1
