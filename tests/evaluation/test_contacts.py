"""Contacts by construction: at corners the balls around both bodies only just meet, and what touches shares a point."""

import numpy as np
import pytest
from poses import pose_within

from plannercheck.bodies import exact_reference as exact
from plannercheck.evaluation.stress_motions.contacts import Closeness, Extent, extent_of, random_contact
from plannercheck.evaluation.stress_motions.recipes import shape_of

# All contacts at corners, of depths from 1 µm to 1 mm; gaps are 10^-3.9 to 10^-0.5 m wide.
AT_CORNERS, DEPTHS, GAPS = Closeness((-6.0, -3.0), 0.0, 1.0), (1e-6, 1e-3), (10**-3.9, 10**-0.5)
SYMMETRIC = {
    "box": ["box", [0.3, 0.2, 0.5]],
    "wall": ["box", [1e-3, 0.8, 0.6]],
    "ball": ["sphere", 0.07],
    "capsule": ["capsule", 0.05, 0.4],
}
HULL = ["hull", [[0, 0, 0], [0.4, 0, 0], [0, 0.3, 0], [0, 0, 0.2], [0.3, 0.3, 0.3]]]


def middle_and_reach(extent):
    """The ball around an extent that is centred at the middle of its box."""
    middle = (extent.vertices.min(axis=0) + extent.vertices.max(axis=0)) / 2
    return middle, np.linalg.norm(extent.vertices - middle, axis=1).max() + extent.inflation_radius


def gap_of_balls(body, pose, other, placed):
    """How far the balls around two posed extents are apart, m."""
    (a, first), (b, second) = middle_and_reach(body), middle_and_reach(other)
    centres = pose[:3, :3] @ a + pose[:3, 3] - placed[:3, :3] @ b - placed[:3, 3]
    return float(np.linalg.norm(centres) - first - second)


def contacts(body, shape, closeness, count=60):
    """Contacts of a body at random poses: the pose of each, the contact, and how far the balls are apart."""
    rng = np.random.default_rng(7)
    for _ in range(count):
        pose = pose_within(rng, 1.0)
        contact = random_contact(body, pose, shape, rng, closeness)
        yield pose, contact, gap_of_balls(body, pose, extent_of(shape_of(shape)), contact.pose)


@pytest.mark.parametrize("shape", SYMMETRIC)
@pytest.mark.parametrize("body", SYMMETRIC)
def test_at_corners_the_balls_just_meet(body, shape):
    seen = set()
    for _, contact, gap in contacts(extent_of(shape_of(SYMMETRIC[body])), SYMMETRIC[shape], AT_CORNERS):
        least, largest = DEPTHS if contact.touches else GAPS
        apart = -gap if contact.touches else gap
        assert least * (1 - 1e-6) <= apart <= largest * (1 + 1e-6)
        seen.add(contact.touches)
    assert seen == {True, False}


def test_at_corners_the_balls_of_bodies_without_symmetry_meet_by_no_more_than_the_depth():
    for _, contact, gap in contacts(extent_of(shape_of(HULL)), HULL, AT_CORNERS):
        assert (-DEPTHS[1] <= gap <= 0) if contact.touches else (GAPS[0] * (1 - 1e-6) <= gap)


def test_elsewhere_the_balls_overlap_by_much_more():
    body = extent_of(shape_of(SYMMETRIC["box"]))
    gaps = [gap for *_, gap in contacts(body, SYMMETRIC["box"], Closeness((-6.0, -3.0), 0.0, 0.0), 200)]
    assert np.median(gaps) < -10 * DEPTHS[1]


@pytest.mark.parametrize("at_corners", [0.0, 1.0])
def test_what_touches_shares_a_point_and_what_misses_does_not(at_corners):
    body, shape = extent_of(shape_of(HULL)), SYMMETRIC["capsule"]
    other = extent_of(shape_of(shape))
    for pose, contact, _ in contacts(body, shape, Closeness((-6.0, -3.0), 0.0, at_corners)):
        radii = body.inflation_radius, other.inflation_radius
        assert exact.intersects(body.vertices, other.vertices, pose, contact.pose, *radii) == contact.touches


def test_outward_leads_to_a_vertex_that_no_other_one_exceeds():
    rng = np.random.default_rng(1)
    corners = extent_of(shape_of(["box", [2.0, 2.0, 2.0]]))
    found = {tuple(np.sign(corners.outward(rng)).tolist()) for _ in range(200)}
    assert len(found) == 8  # any corner of a cube
    kite = Extent(np.array([[-1.0, 0, 0], [1.0, 0, 0], [0, 0.2, 0], [0, -0.2, 0]]), 0.1)
    assert {tuple(kite.outward(rng).tolist()) for _ in range(50)} == {(-1.0, 0.0, 0.0), (1.0, 0.0, 0.0)}
    ball = [extent_of(shape_of(SYMMETRIC["ball"])).outward(rng) for _ in range(50)]
    assert np.allclose(np.linalg.norm(ball, axis=1), 1)
    assert np.ptp(np.array(ball), axis=0).min() > 1  # all around
