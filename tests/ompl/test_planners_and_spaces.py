"""Every planner of OMPL on every kind of space: it plans what is free, or one line says where it can plan."""

import numpy as np
import pytest
from ompl import base, geometric

import plannercheck as pc
from plannercheck.ompl import planner_names, setup, space_of
from plannercheck.ompl.planning import plan
from plannercheck.ompl.simple_setup import INFORMED_PLANNERS

P = pc.planar
# Seconds a search; FMT and BFMT take as long as their samples need.
SHORT, SAMPLES = 0.1, 60


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
WITHOUT_INFORMED = ("angles", "arm", "trailer")


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


@pytest.mark.parametrize(("case", "options"), SPACES, ids=lambda value: value if isinstance(value, str) else None)
@pytest.mark.parametrize("name", planner_names())
def test_every_planner_plans_or_says_where_it_can(problems, case, options, name):
    checker, start, goal = problems[case]
    made, space = setup(checker, **options), space_of(checker, **options)
    information = made.getSpaceInformation()
    made.setStartAndGoalStates(space.state(information, start), space.state(information, goal))
    planner = getattr(geometric, name)(information)
    if hasattr(planner, "setNumSamples"):
        planner.setNumSamples(SAMPLES)
    made.setPlanner(planner)
    if case in WITHOUT_INFORMED and name in INFORMED_PLANNERS:
        with pytest.raises(pc.PlannercheckError, match=f"^{name} can't plan .* AORRTC, BITstar, Informed"):
            made.solve(SHORT)
        return
    if name == "AORRTC" and options.get("curve") == "dubins":  # it crashed in one search of eight
        with pytest.raises(pc.PlannercheckError, match=r"AORRTC can't plan where the way back has another length"):
            made.solve(SHORT)
        return
    made.solve(base.timedPlannerTerminationCondition(SHORT))
    if made.haveExactSolutionPath():
        assert made.getSolutionPath().check()


def test_a_path_that_collides_the_way_it_is_gone_is_none(problems, monkeypatch):
    """A roadmap planner checks a curve one way and goes it the other way."""
    checker, start, goal = problems["vehicle"]
    curve = {"curve": "reeds_shepp", "turning_radius": 3.0}
    monkeypatch.setattr(geometric.PathGeometric, "check", lambda path: False)
    found = plan(checker, start, goal, planner="PRM", time_limit=2.0, **curve)
    assert not found.solved
    assert found.reason.startswith("PRM found a path that does not begin at the start, or has a curve that collides")


def test_plan_says_it_too(problems):
    with pytest.raises(pc.PlannercheckError, match=r"BITstar can't plan in this space.* all others serve every space"):
        plan(*problems["angles"], planner="BITstar")


def test_informed_planners_serve_any_space_with_another_objective(problems):
    """Only for the length are samples drawn from where a shorter path may be."""
    checker, start, goal = problems["angles"]
    made, space = setup(checker), space_of(checker)
    information = made.getSpaceInformation()
    made.setOptimizationObjective(pc.ompl.clearance_objective(checker, made))
    made.setStartAndGoalStates(space.state(information, start), space.state(information, goal))
    made.setPlanner(geometric.InformedRRTstar(information))
    made.solve(SHORT)
