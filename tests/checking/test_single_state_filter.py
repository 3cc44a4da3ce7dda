"""Single states are bounded in lanes over bodies, sets in lanes over states: both find the same pairs."""

import numpy as np
import pytest

import plannercheck as pc


def _boxes(count, size):
    """A shell of boxes around the robot, some of them within its reach."""
    rng = np.random.default_rng(count)
    scene = pc.Scene("shell")
    for k in range(count):
        direction = rng.normal(size=3)
        pose = np.eye(4)
        pose[:3, 3] = rng.uniform(0.3, 1.2) * direction / np.linalg.norm(direction)
        scene.add_box(f"box{k}", [size] * 3, pose)
    return scene


# Few obstacles are in lanes, many in a tree; 8, 9, 64 and 65 are where an eight and the list of them end.
@pytest.mark.parametrize("count", [0, 1, 7, 8, 9, 63, 64, 65, 300])
@pytest.mark.filterwarnings("ignore:.*touches obstacle:RuntimeWarning")
@pytest.mark.parametrize("robot", ["panda", "baxter"])
def test_single_states_find_the_same_pairs(robot, count):
    checker = pc.Checker(pc.Robot.load(robot), _boxes(count, 0.05), overlaps=False)
    q = checker.robot.random_configurations(60, seed=count)
    together, before = checker.colliding_pairs(q), checker.statistics()
    alone = np.concatenate([checker.colliding_pairs(row[None]) for row in q])
    after = checker.statistics()
    np.testing.assert_array_equal(alone, together)
    assert [checker.is_valid(row) for row in q] == (~together.any(axis=1)).tolist()
    # The same comparisons, but for the rounding of the balls' centres.
    assert after["bounds"] - before["bounds"] == pytest.approx(before["bounds"], rel=1e-4)


@pytest.mark.parametrize("place", range(9))
def test_only_the_near_box_is_found(place):
    """One near box among nine, in every place of an eight and in the next one."""
    scene = pc.Scene("one is near")
    for k in range(9):
        pose = np.eye(4)
        pose[2, 3] = 0.4 if k == place else 50 + k
        scene.add_box(f"box{k}", [0.1] * 3, pose)
    panda = pc.Robot.load("panda")
    checker = pc.Checker(panda, scene, self_collision=False, reach=False)
    assert not checker.is_valid(panda.reference)
    counted = checker.statistics()
    assert counted["bounds"] >= 8 * len(panda.bodies) - 8
    assert (
        checker.bodies[checker.pairs[checker.first_colliding_pair(panda.reference[None])[0]][1]].name == f"box{place}"
    )
