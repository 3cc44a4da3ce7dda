"""How far bodies are moved, and overlaps of all configurations of a box: against configurations drawn from it."""

import numpy as np
import pytest
from random_trees import random_tree

import plannercheck as pc
from plannercheck.timing.overlaps import Overlaps

pytestmark = pytest.mark.filterwarnings("ignore:.*look like degrees")


@pytest.mark.parametrize("seed", range(10))
def test_points_move_no_further_than_their_bound(tmp_path, seed):
    """The bound of a body's vertices, over corners of the box and configurations in it; some come near."""
    rng = np.random.default_rng(seed)
    robot = random_tree(rng, 5, sizes=(0.2, 0.15, 0.1), reach=0.5, placed=True).robot(tmp_path)
    checker = pc.Checker(robot)
    overlaps = Overlaps(checker, np.full(robot.nq, -9.0), np.full(robot.nq, 9.0))
    near = 0.0
    for q in robot.random_configurations(20, rng):
        change = rng.uniform(0, 0.6, robot.nq)
        signs = np.concatenate([rng.choice([-1.0, 1.0], (60, robot.nq)), rng.uniform(-1, 1, (20, robot.nq))])
        before, after = checker.body_poses(q[None])[0], checker.body_poses(q + signs * change)
        bounds = overlaps.moved(q, change)
        for body in np.unique(checker.pairs).tolist():
            points = np.c_[checker.polytopes[body].vertices, np.ones(len(checker.polytopes[body].vertices))]
            shifts = np.linalg.norm((points @ (after[:, body] - before[body]).transpose(0, 2, 1))[..., :3], axis=2)
            assert shifts.max() <= bounds[body] + 1e-12
            near = max(near, shifts.max() / (bounds[body] + 1e-12))
    assert near > 0.5


def test_overlaps_of_two_boxes(tmp_path):
    """Boxes of 0.2 m that slide along x, 0.05 m apart: no shorter translation than 0.15 m parts them."""
    urdf = tmp_path / "slide.urdf"
    urdf.write_text(
        '<robot name="slide"><link name="base"/><link name="tip"><collision><geometry><box size="0.2 0.2 0.2"/>'
        '</geometry></collision></link><joint name="x" type="prismatic"><parent link="base"/><child link="tip"/>'
        '<axis xyz="1 0 0"/><limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>'
    )
    robot = pc.Robot.from_urdf(urdf)
    checker = pc.Checker(pc.Robot.together({"a": (robot, np.eye(4)), "b": (robot, np.eye(4))}))
    overlaps, q = Overlaps(checker, np.full(2, -1.0), np.full(2, 1.0)), np.array([0.0, 0.05])
    assert overlaps.shared(q, [np.array([0.05, 0.05])]) is not None
    assert overlaps.shared(q, [np.array([0.0, 0.118])]).depth == pytest.approx(0.118, abs=1e-6)
    assert overlaps.shared(q, [np.array([0.151, 0.0])]) is None
    assert overlaps.shared(q, [np.array([0.151, 0.0]), np.array([0.0, 0.01])]) is not None
    assert overlaps.shared(np.array([0.0, 0.21]), [np.zeros(2)]) is None
