"""Faults that C++ and Python are given alike: their sentences are the same (tests/support/cpp/say_faults.cpp)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

import plannercheck as pc
from plannercheck.trajectories.curve import Curve

# What Python's sentence has in addition: remedies, and values, that C++ does not have.
IN_PYTHON_ALONE = (
    '; invalid="drop" leaves such points out, and counts them',
    ", or NaN for a whole point",
)
ONE_POINT = "a trajectory of one point needs start= (--start), where the robot comes from"
ONE_POINT_IN_CPP = "a trajectory of one point needs another one before it, where the robot comes from"

Faults = Iterator[tuple[str, Callable[[], Any]]]


def sentences(checker: pc.Checker, lift: pc.Checker) -> list[str]:
    """Name, tab and sentence of each fault, as C++ has to say it; of a Panda's checker, and that of LIFT's robot."""
    faults = (*_configurations(checker), *_obstacles(checker), *_trajectories(checker), *_others(checker, lift))
    return [f"{name}\t{_sentence(fault)}" for name, fault in faults]


def stand_ins_of(checker: pc.Checker) -> list[pc.GeometryObject]:
    """Bodies for `with_bodies`: the checker's own."""
    return [*checker.robot.bodies, *checker.scene.bodies]


def _sentence(fault: Callable[[], Any]) -> str:
    try:
        fault()
    except pc.PlannercheckError as error:
        said = str(error)
        for more in IN_PYTHON_ALONE:
            said = said.replace(more, "")
        return ONE_POINT_IN_CPP if said == ONE_POINT else said
    return "no fault"


def _with(array: np.ndarray, at: Any, value: float) -> np.ndarray:
    out = array.copy()
    out.flat[at] = value
    return out


_Q, _TWO, _HERE = np.zeros(7), np.zeros((2, 7)), np.eye(4)


def _configurations(checker: pc.Checker) -> Faults:
    few, wrong = np.zeros(5), _with(_Q, 3, math.nan)
    far = np.array([-0.1, 1e-7, 2e15, 0, 1e22, 0.1 + 0.2, 123456.789])
    yield "too few numbers", lambda: checker.is_valid(few)
    yield "too many numbers in a set", lambda: checker.check_states(np.zeros(15))
    yield "too few numbers at a motion's end", lambda: checker.check_motion(_Q, few)
    yield "too few numbers to explain", lambda: checker.explain(few)
    yield "too few numbers to measure", lambda: checker.distances(few)
    yield "a number that is none", lambda: checker.is_valid(wrong)
    yield "a number that is none, to explain", lambda: checker.explain(wrong)
    yield "a number that is none at a motion's end", lambda: checker.check_motion(_Q, wrong)
    yield "an infinite number", lambda: checker.is_valid(_with(_Q, 0, -math.inf))
    yield "a number beyond all joints", lambda: checker.check_states(np.stack([_Q, far]))
    yield "a number beyond all joints, to measure", lambda: checker.distances(far)
    for tolerance in (0.0, -1e-4, math.nan, math.inf, -123456.7891):
        yield "a tolerance", partial(checker.check_motion, _Q, _Q, tolerance=tolerance)
    yield "a tolerance below rounding", lambda: checker.check_motion(_Q, _with(_Q, 0, 1e-3), tolerance=1e-17)
    for limit in (0.0, -0.1, math.nan):
        yield "a limit", partial(checker.distances, _Q, limit)


def _obstacles(checker: pc.Checker) -> Faults:
    def edited(edit: Callable[[pc.Scene], Any]) -> pc.Checker:
        scene = checker.scene.copy()
        edit(scene)
        return checker.with_scene(scene)

    def added(shape: Callable[[], Any], pose: np.ndarray = _HERE, name: str = "new") -> Callable[[], Any]:
        return lambda: edited(lambda scene: scene.add(name, shape(), pose))

    def cube() -> pc.Box:
        return pc.Box((1.0, 1.0, 1.0))

    yield "no name", added(cube, name="")
    yield "a link's name", added(cube, name="panda_hand")
    yield "a name that is not there, to move", lambda: edited(lambda scene: scene.move("cratr", _HERE))

    def moved_behind(scene: pc.Scene) -> None:
        scene.remove("rack")
        scene.add("rack", cube())
        scene.move("rick", _HERE)

    yield "a name that is not there, after edits", lambda: edited(moved_behind)
    yield "a name that is not there, to remove", lambda: edited(lambda scene: scene.remove("rick"))
    yield "no name to remove", lambda: edited(lambda scene: scene.remove(""))
    for edge in (-1.0, math.nan, math.inf):
        yield "an edge", added(partial(pc.Box, (1.0, edge, 1.0)))
    yield "a large edge", added(lambda: pc.Box((1.0, 3e50, 1.0)))
    for radius in (-1.0, math.nan, math.inf, 1e51):
        yield "a radius", added(partial(pc.Sphere, radius))
    yield "a centre", added(lambda: pc.Sphere(1.0), _with(_HERE, 7, math.nan))
    for radius in (0.0, -1.0, math.nan, 1e51):
        yield "a cloud's radius", added(partial(pc.PointCloud, np.zeros((1, 3)), radius))
    points = np.concatenate([np.zeros((1, 3)), np.eye(3)])
    yield "points of a hull in no rows", added(lambda: pc.Hull(np.zeros(13)))
    yield "points of a cloud in no rows", added(lambda: pc.PointCloud(np.zeros(4), 0.1))
    for count in (0, 1, 3):
        yield "few points of a hull", added(partial(pc.Hull, points[:count]))
    yield "few points of a hull, and wrong ones", added(lambda: pc.Hull(_with(points[:3], 4, math.nan)))
    yield "a point of a hull", added(lambda: pc.Hull(_with(points, 4, math.nan)))
    yield "a point of a cloud", added(lambda: pc.PointCloud(_with(points, 4, math.nan), 0.1))
    yield "a large point of a hull", added(lambda: pc.Hull(_with(points, 4, 2e50)))
    yield "a huge point of a hull", added(lambda: pc.Hull(_with(points, 4, 1e200)))
    yield "a point of a cloud without a radius", added(lambda: pc.PointCloud(_with(points, 4, math.nan), 0.0))
    yield "a large point of a cloud", added(lambda: pc.PointCloud(_with(points, 4, -2e50), 0.1))
    yield "a stretched pose", added(cube, _with(_HERE, 0, 1.1))
    yield "a mirrored pose", added(cube, _with(_HERE, 0, -1.0))
    yield "a pose that is hardly stretched", added(cube, _with(_HERE, 10, 1.00001))
    yield "a mirrored pose far away", added(cube, _with(_HERE, [3, 7, 10], [1e60, -1e300, -1.0]))
    yield "a pose beyond all doubles", added(cube, _with(_HERE, [0, 1, 4, 5], [1e200, 1e200, 1e200, -1e200]))
    yield "a pose's last row that is none", added(cube, _with(_HERE, [12, 0], [math.nan, 2.0]))
    yield "a stretched pose's last row", added(cube, _with(_HERE, [15, 0], [2.0, 2.0]))
    yield "a link's name at no pose", added(cube, _with(_HERE, 0, 2.0), "panda_hand")
    yield "a part's name", added(cube, name="rack/0")
    yield "a pose's last row", added(cube, _with(_HERE, 12, 1.0))
    yield "a pose that is none", lambda: edited(lambda scene: scene.move("crate", _with(_HERE, 7, math.nan)))
    yield "a stretched pose to move to", lambda: edited(lambda scene: scene.move("crate", _with(_HERE, 5, 0.9)))


def _trajectories(checker: pc.Checker) -> Faults:
    make, times = pc.Trajectory, [0.0, 1.0]
    wrong, moving = _with(_TWO, 9, math.nan), _with(_TWO, [10, 8], [0.5, -0.25])
    yield "no points", lambda: make([], [])
    yield "one point", lambda: make([0.0], _Q[None])
    yield "positions in no rows", lambda: make(times, np.zeros(15))
    yield "velocities in no rows", lambda: make(times, _TWO, np.zeros(15))
    yield "times that fall", lambda: make([0.0, 2.0, 1.0], np.zeros((3, 7)))
    yield "times before 0", lambda: make([-1.0, 2.0], _TWO)
    yield "times that are none", lambda: make([0.0, math.nan], _TWO)
    yield "times too close", lambda: make([0.0, 1e-10], _TWO)
    yield "a position that is none", lambda: make(times, wrong)
    yield "a velocity that is none", lambda: make(times, _TWO, wrong)
    yield "an acceleration that is none", lambda: make(times, _TWO, _TWO, wrong)
    yield "accelerations alone", lambda: make(times, _TWO, None, _TWO)
    yield "an end that moves", lambda: make(times, _TWO, moving)
    still, judge = make(times, _TWO), checker.check_trajectory
    yield "a tube below 0", lambda: judge(still, _with(_Q, 2, -1.0))
    yield "a tube of one number below 0", lambda: judge(still, -1.0)
    yield "a tube of three", lambda: judge(still, np.zeros(3))
    yield "a tube that is none", lambda: judge(still, np.full(7, math.nan))
    yield "a trajectory's tolerance", lambda: judge(still, 0.0, -1.0)
    yield "a trajectory's tolerance below rounding", lambda: judge(still, 0.0, 1e-18)
    yield "a trajectory of another robot", lambda: judge(make(times, np.zeros((2, 5))))
    yield "a trajectory beyond all joints", lambda: judge(make(times, _with(_TWO, 8, 1e16)))

    def curve(breaks: list[float], *pieces: np.ndarray) -> pc.Trajectory:
        return make.of_curve(Curve(np.array(breaks), pieces, _Q))

    yield "pieces that do not meet", lambda: judge(curve([0.0, 1.0, 2.0], _TWO, _with(_TWO, 0, 1.0)))
    yield "a piece of a high degree", lambda: judge(curve([0.0, 1.0], np.zeros((25, 7))))
    yield "a short piece", lambda: judge(curve([0.0, 1e-10], _TWO))


def _others(checker: pc.Checker, lift: pc.Checker) -> Faults:
    turned = np.array([0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1.25])
    yield "a quaternion of another length", lambda: lift.is_valid(turned)
    yield "a cosine and sine of another length", lambda: lift.is_valid(_with(turned, [14, 7], [1.0, 0.5]))
    yield "too few numbers of several joints", lambda: lift.is_valid(np.zeros(3))
    mirrored = _with(_HERE, 0, -1.0)
    yield "a mirrored pose for stand-ins", lambda: checker.scene.copy().add("new", pc.Sphere(1.0), mirrored)
    yield "stand-ins in another scene", lambda: checker.with_bodies(stand_ins_of(checker)).with_scene(checker.scene)
