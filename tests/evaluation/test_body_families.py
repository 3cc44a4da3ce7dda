"""The families and contact poses are what the other tests take them for."""

import numpy as np
import pytest
from contact_differences import differ_from_contact
from poses import at
from solids import centroid

from plannercheck.bodies import exact_reference as exact
from plannercheck.bodies.integers import IntegerHull, cross, dot, minus
from plannercheck.evaluation.stress import body_families as families
from plannercheck.evaluation.stress import contact_poses as contacts
from plannercheck.evaluation.stress.contact_poses import Solid


def reflex_edges(solid: Solid) -> int:
    """Edges that are not strictly convex, in exact arithmetic."""
    hull = IntegerHull(solid.vertices, None)
    points = [hull.point(k) for k in range(len(solid.vertices))]
    count = 0
    for face, beyond in zip(solid.faces.tolist(), solid.across.tolist(), strict=True):
        a, b, c = (points[k] for k in face)
        normal = cross(minus(b, a), minus(c, a))
        for neighbour in beyond:
            opposite = next(k for k in solid.faces[neighbour].tolist() if k not in face)
            count += dot(normal, minus(points[opposite], a)) >= 0
    return count


@pytest.mark.parametrize("levels", [0, 1, 4, 8, 11])
def test_degree_doubling_is_convex_and_doubles(levels: int) -> None:
    vertices, faces = families.degree_doubling(levels)
    assert len(vertices) == 1 + 3 * 2**levels
    assert len(faces) == 2 * len(vertices) - 4
    assert np.count_nonzero(faces == 0) == 3 * 2**levels
    if levels <= 8:
        assert reflex_edges(Solid("doubling", vertices, faces)) == 0


@pytest.mark.parametrize("name", sorted(families.FAMILIES))
def test_families_are_about_a_metre_across(name: str) -> None:
    for n in (8, 100, 1000):
        points = families.family(name, n, seed=1)
        assert 4 <= len(points) <= n + 4
        assert 0.2 < np.ptp(points, axis=0).max() <= 4.0
        np.testing.assert_array_equal(points, families.family(name, n, seed=1))


@pytest.mark.parametrize("name", families.MESHES)
def test_meshes_load(name: str) -> None:
    assert len(families.mesh_points(name)) >= 8


@pytest.mark.parametrize("gap", [1e-2, 1e-6, 1e-10])
def test_contact_poses_keep_their_gap(gap: float) -> None:
    rng = np.random.default_rng(4)
    solid = Solid("doubling", *families.degree_doubling(3))
    for pose_p, pose_r in zip(*contacts.contact_poses(solid, solid, np.full(30, gap), rng), strict=True):
        apart = exact.distance(solid.vertices, solid.vertices, pose_p, pose_r)
        # At least the gap; more where a feature leans away. The pose rounds at 2e-16 of a metre and of the
        # size.
        assert apart >= gap - 2e-15
    facing = [exact.distance(solid.vertices, solid.vertices, *poses) for poses in _opposed(solid, gap)]
    np.testing.assert_allclose(facing, gap, atol=2e-15)


def _opposed(solid: Solid, gap: float) -> list[tuple[contacts.Points, contacts.Points]]:
    """A body over its mirror image below a facet: the gap is the distance."""
    lift = at(*solid.normals[0] * gap)
    mirrored = np.diag([-1.0, -1.0, -1.0, 1.0])
    mirrored[:3, 3] = 2 * solid.vertices[solid.faces[0]].mean(axis=0)
    return [(lift @ mirrored, np.eye(4))]


def test_overlaps_and_gaps_are_told_from_contact() -> None:
    corners = np.indices((2, 2, 2)).reshape(3, 8).T * 1.0
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    cube = Solid("cube", corners, np.array([f for a, b, c, d in sides for f in ((a, b, c), (a, c, d))]))
    np.testing.assert_allclose(centroid(cube), 0.5)
    pose = np.eye(4)
    for shift, differs in ((1.1, True), (1.0001, False), (0.9999, False), (0.9, True), (0.0, True)):
        pose[0, 3] = shift
        assert differ_from_contact(cube, cube, pose, np.eye(4), 1e-2) == differs
