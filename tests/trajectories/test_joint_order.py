"""Names of columns that say another order than the robot's are errors wherever a trajectory meets a robot."""

import numpy as np
import pytest
from poses import at

import plannercheck as pc

PANDA = pc.Robot.load("panda")
NAMES = list(PANDA.joint_names)
SWAPPED = [NAMES[1], NAMES[0], *NAMES[2:]]
CELL = pc.Robot.together({"left": PANDA, "right": (PANDA, at(0, 1, 0))})


def trajectory(names):
    return pc.Trajectory([0.0, 1.0], [PANDA.reference, PANDA.reference + 0.01], joint_names=names)


def ridden(given):
    scene = pc.Scene()
    scene.add("tray", pc.Sphere(0.01), pc.Moving.along(given, "panda_hand", (PANDA, at(0, 3, 0))))
    return pc.Checker(PANDA, scene)


USES = [
    lambda given: pc.Checker(PANDA).check_trajectory(given),
    lambda given: pc.distances_along(pc.Checker(PANDA), given, [0.5]),
    lambda given: given.limits(PANDA),
    lambda given: given.of_robot(PANDA),
    lambda given: pc.first_conflict(pc.Checker(CELL), {"left": given, "right": PANDA.reference}),
    ridden,
]


@pytest.mark.parametrize("use", USES)
def test_another_order_is_an_error(use):
    with pytest.raises(
        pc.PlannercheckError, match=r"column 0 is joint 'panda_joint2' .* but 'panda_joint1' of 'panda'"
    ):
        use(trajectory(SWAPPED))


@pytest.mark.parametrize("use", USES)
@pytest.mark.parametrize("names", [(), NAMES, [f"arm_{name}" for name in NAMES]])
def test_the_robots_order_and_other_names_pass(use, names):
    use(trajectory(names))


def test_a_cells_names_are_in_order_too():
    swapped = trajectory([f"left/{name}" for name in SWAPPED])
    with pytest.raises(pc.PlannercheckError, match="trajectory of 'left': column 0 is joint 'panda_joint2'"):
        pc.first_conflict(pc.Checker(CELL), {"left": swapped, "right": np.array(PANDA.reference)})
