"""FCL gets the bodies it should, and boxes only skip pairs that are free."""

import sys

import exact_verdicts
import numpy as np
import pytest
from solids import random_poses

from plannercheck.bodies.fcl_bodies import FclBodies
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.stress import body_families as families
from plannercheck.evaluation.stress import contact_poses as contacts
from plannercheck.evaluation.stress.contact_poses import Solid

SOLID = Solid("doubling", *families.degree_doubling(4))


def test_fcl_is_right_at_clear_gaps() -> None:
    rng = np.random.default_rng(5)
    bodies = FclBodies([(SOLID.vertices, SOLID.faces)] * 2)
    verdicts = []
    for pose_p, pose_r in zip(*random_poses(SOLID, SOLID, 200, rng), strict=True):
        bodies.place(0, pose_p)
        bodies.place(1, pose_r)
        verdicts.append(bodies.collides(0, 1))
        assert verdicts[-1] == exact_verdicts.intersects(SOLID.vertices, SOLID.vertices, pose_p, pose_r)
    assert 20 < sum(verdicts) < 180


def test_fcl_does_not_depend_on_the_orientation_of_faces() -> None:
    rng = np.random.default_rng(6)
    outward = FclBodies([(SOLID.vertices, SOLID.faces)] * 2)
    inward = FclBodies([(SOLID.vertices, SOLID.faces[:, ::-1])] * 2)
    poses = np.stack(random_poses(SOLID, SOLID, 200, rng), axis=1)
    pair = np.array([[0, 1]])
    assert [outward.collide_all(p, pair) for p in poses] == [inward.collide_all(p, pair) for p in poses]


def test_boxes_apart_means_free() -> None:
    rng = np.random.default_rng(7)
    bodies = FclBodies([(SOLID.vertices, SOLID.faces)] * 2)
    poses = np.stack(random_poses(SOLID, SOLID, 300, rng), axis=1)
    poses[:, 0, :3, 3] += 2 * contacts.random_directions(300, rng)
    meet = bodies.boxes_meet(poses, np.array([[0, 1]]))[:, 0]
    assert 30 < np.count_nonzero(meet) < 270
    for pose_p, pose_r in poses[~meet]:
        assert not exact_verdicts.intersects(SOLID.vertices, SOLID.vertices, pose_p, pose_r)


def test_boxes_that_touch_meet() -> None:
    bodies = FclBodies([(SOLID.vertices, SOLID.faces)] * 2)
    poses = np.tile(np.eye(4), (1, 2, 1, 1))
    poses[0, 1, 0, 3] = np.ptp(SOLID.vertices[:, 0])
    assert bodies.boxes_meet(poses, np.array([[0, 1]])).all()


def test_without_fcl_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "fcl", None)
    with pytest.raises(PlannercheckError, match="pip install"):
        FclBodies([(SOLID.vertices, SOLID.faces)])


POINT, SEGMENT = np.zeros((1, 3)), np.array([[-1.0, 0.5, 0], [0.5, 0.25, 1]])
NO_FACES = np.zeros((0, 3), dtype=np.int64)


def test_inflated_points_and_segments_are_spheres_and_capsules() -> None:
    rng = np.random.default_rng(6)
    hulls, inflation_radii = (
        [(POINT + 0.5, NO_FACES), (SEGMENT, NO_FACES), (SOLID.vertices, SOLID.faces)],
        [0.5, 0.25, 0.0],
    )
    bodies = FclBodies(hulls, inflation_radii)
    assert bodies.known.all()
    pairs = np.array([[0, 1], [1, 2], [0, 2], [1, 1], [0, 0]])
    verdicts = []
    for pose_p, pose_r in zip(*random_poses(SOLID, SOLID, 100, rng), strict=True):
        for p, r in pairs.tolist():
            truth = exact_verdicts.intersects(
                hulls[p][0], hulls[r][0], pose_p, pose_r, inflation_radii[p], inflation_radii[r]
            )
            poses = np.stack([pose_p, pose_r])
            two = FclBodies([hulls[p], hulls[r]], [inflation_radii[p], inflation_radii[r]])
            assert two.collide_all(poses, np.array([[0, 1]])) == [truth]
            assert two.boxes_meet(poses[None], np.array([[0, 1]])).all() or not truth
            verdicts.append(truth)
    assert 50 < sum(verdicts) < 450


def test_bodies_that_fcl_has_no_form_for_are_left_out() -> None:
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    solid = (SOLID.vertices, SOLID.faces)
    bodies = FclBodies(
        [(square, NO_FACES), (SEGMENT, NO_FACES), solid, (square, NO_FACES), solid, None], [0, 0, 0.1, 0.1, 0, 0]
    )
    assert bodies.known.tolist() == [False, False, False, False, True, False]
