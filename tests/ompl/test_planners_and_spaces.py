"""Every planner of OMPL on every kind of space: it plans what is free, or one line says where it can plan."""

from __future__ import annotations

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.ompl import setup, space_of

P = pc.planar


def arm() -> tuple[P.Checker, np.ndarray, np.ndarray]:
    """Two links on the floor of a plane: the first turns freely, the second has limits; a post is in their way."""
    outline = [[0.0, -0.05], [1.0, -0.05], [1.0, 0.05], [0.0, 0.05]]
    links = [
        P.Link("upper", outline, joint="revolute"),
        P.Link("lower", outline, parent="upper", anchor=(1.0, 0.0, 0.0), joint="revolute", limits=(-2.5, 2.5)),
    ]
    scene = P.Scene("post")
    scene.add_polygon("post", [[1.5, -0.1], [1.7, -0.1], [1.7, 0.1], [1.5, 0.1]])
    robot = P.Robot(links, name="arm", disabled_pairs=[("upper", "lower")])
    return P.Checker(robot, scene), np.array([-1.0, 0.0]), np.array([1.0, 0.0])


def kinova() -> tuple[pc.Checker, np.ndarray, np.ndarray]:
    checker = pc.Checker(pc.Robot.load("kinova"), pc.Scene.load("kitchen"))
    rows = checker.robot.random_configurations(200, 1)
    rows = rows[checker.check_states(rows)]
    return checker, rows[0], rows[1]


def declared(checker):
    return checker, checker.scene.start(checker.robot.name), checker.scene.goal(checker.robot.name)


def vehicle(name):
    return declared(P.Checker(P.Robot.load(name), P.Scene.load("parking")))


CASES = {
    "bounded": lambda: declared(pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))),
    "angles": kinova,
    "arm": arm,
    "vehicle": lambda: vehicle("forklift"),
    "trailer": lambda: vehicle("truck_trailer"),
}
SPACES = [(case, {}) for case in CASES] + [
    (case, {"curve": curve, "turning_radius": 3.0})
    for case in ("vehicle", "trailer")
    for curve in ("dubins", "reeds_shepp")
]


@pytest.fixture(scope="module")
def problems():
    return {case: make() for case, make in CASES.items()}


@pytest.mark.parametrize(("case", "options"), SPACES, ids=lambda value: value if isinstance(value, str) else None)
def test_every_space_has_a_projection(problems, case, options):
    checker, start, _ = problems[case]
    made = setup(checker, **options)
    made.getSpaceInformation().setup()
    evaluator = made.getStateSpace().getDefaultProjection()
    sizes = evaluator.getCellSizes()
    assert len(sizes) == evaluator.getDimension() == 2
    assert min(sizes) > 0
    if case == "bounded":
        return
    seen = np.zeros(2)
    space = space_of(checker, **options)
    evaluator.project(space.state(made.getSpaceInformation(), start), seen)
    assert seen == pytest.approx(start[:2])
