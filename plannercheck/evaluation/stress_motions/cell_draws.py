"""Random cells of the motion stress: several robots, bodies that move, obstacles; trajectories on one clock.

In: a family's name, a random generator. Out: a `Draw`. Each contact is built at a state and an instant: the base of a
robot is placed where it touches an earlier robot, a moving body passes a pose at which it touches a robot, an obstacle
stands there. Each robot then has its own curve through its part of the state, of its own degree, with its own knots,
controller and start, or it stands.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.transforms import rotation_of_quaternion
from plannercheck.evaluation.stress.contact_poses import random_directions
from plannercheck.evaluation.stress_motions.aims import Aim, Motions, joined, through
from plannercheck.evaluation.stress_motions.cell_numbers import Run, duration, row_of
from plannercheck.evaluation.stress_motions.cell_subject import CellSubject
from plannercheck.evaluation.stress_motions.contacts import Contact, extent_of, random_contact, random_shape
from plannercheck.evaluation.stress_motions.curve_numbers import unit_columns
from plannercheck.evaluation.stress_motions.curves import MOST_DEGREE, instants, points_through, tube_around
from plannercheck.evaluation.stress_motions.draws import Draw, add_bodies, choose_pairs, sharpest_rows, tidy
from plannercheck.evaluation.stress_motions.ends import Stage
from plannercheck.evaluation.stress_motions.recipes import CellRecipe, Matrix, SpaceRecipe, cell_of, robot_of, shape_of
from plannercheck.evaluation.stress_motions.tangents import tangents_of
from plannercheck.evaluation.stress_motions.trees import CONTINUOUS, SLIDES, TURNS, Wishes, random_states, random_tree
from plannercheck.robots.robot import CellPart, Robot
from plannercheck.trajectories.controllers import Controller
from plannercheck.trajectories.curve import Curve
from plannercheck.trajectories.trajectory import Trajectory

# Families: what the robots of a cell are.
FAMILIES: dict[str, Wishes] = {
    "cell": Wishes(joints=(1, 4), mimics=0.1),
    "arms": Wishes((*TURNS, *CONTINUOUS), (1.0,) * 8, (1, 5), 0.1, 0.1),
    "gantries": Wishes(SLIDES, (1.0,) * 3, (1, 3), 0.1, 0.0),
    "bases": Wishes(("planar", "floating", "revolute"), (1.0, 1.0, 0.5), (1, 2), 0.0, 0.3),
}
CELL_WEIGHTS: dict[str, float] = {"cell": 0.4, "arms": 0.3, "gantries": 0.15, "bases": 0.15}
# Trajectories of a cell; so many times as many are made as are taken, those first that are free at both ends.
CELL_MOTIONS, _CANDIDATES = 40, 2
# How often a cell has so many robots, bodies that move, and obstacles: each more takes longer.
_ROBOTS, _MOVING, _OBSTACLES = (0.0, 0.0, 0.6, 0.25, 0.15), (0.3, 0.3, 0.15, 0.1, 0.1, 0.05), (0.4, 0.3, 0.2, 0.1)
_WHOLE, _SELF, _CLOUDS, _PADDED, _STANDS_OUTSIDE = 0.2, 0.5, 0.2, 0.1, 0.5
# Contacts of a moving body: how many, how far apart, and how long before and after each it has another pose, s.
_CONTACTS, _APART, _BESIDE = (1, 3), 20.0, (0.05, 3.0)
# How far it goes and turns within that time, m and rad, as powers of ten.
_GOES, _TURNS = (-3.0, 0.5), (-3.0, 0.3)
# Where one that refuses to say more ends, s.
_ENDS = 5000.0
# How long the curve through the contact takes, s, as powers of ten, or one of these lengths, so that knots coincide.
_LENGTHS, _EVEN, _LENGTH_IS_EVEN = (-1.5, 1.0), (0.5, 1.0, 2.0), 0.5
# Pieces before and after it; their size, rad and m; robots that stand; curves as controllers have them.
_BEFORE, _SIZES, _STANDING, _CONTROLLED = 0.3, (-2.0, 0.3), 0.15, 0.5
_CONTROLLERS: dict[int, Controller] = {1: "linear", 3: "jtc", 5: "jtc"}
# Where the own clock of a curve begins, s; how long the clock runs before the first robot starts, as powers of ten.
_BEGINS, _NOT_AT_ONCE, _LATE = (0.0, 0.0, 0.25, 1.3), 0.5, (-2.0, 3.0)


@dataclass(frozen=True, eq=False)
class _Touch:
    """A contact of a body of one robot at a state of all, and an instant of the scene's clock, s."""

    states: Mapping[str, Floats]
    time: float
    link: str
    other: str  # the link of another robot, or empty
    contact: Contact

    def unless(self, are_fixed: bool) -> _Touch:
        """It touches nothing if both bodies are fixed: such pairs are not tested."""
        return replace(self, contact=replace(self.contact, touches=self.contact.touches and not are_fixed))


def cell_draw(family: str, rng: np.random.Generator) -> Draw:
    """A random cell among contacts."""
    recipe: CellRecipe = {"kind": "cell", "robots": {}, "moving": [], "obstacles": [], "padding": 0.0}
    is_whole = rng.random() < _WHOLE
    for name in "abcd"[: _count(_ROBOTS, rng)]:
        recipe["robots"][name] = {"robot": _robot(FAMILIES[family], is_whole, rng), "pose": np.eye(4).tolist()}
    if rng.random() < _PADDED:
        recipe["padding"] = float(10.0 ** rng.uniform(-4, -2))
    robots = {name: part.robot for name, part in cell_of(recipe).parts.items()}
    touches = [_base(recipe, robots, name, rng) for name in list(robots)[1:]]
    for _ in range(_count(_MOVING, rng)):
        touches += _moving(recipe, robots, rng)
    for _ in range(_count(_OBSTACLES, rng)):
        shape = random_shape(rng)
        found = _touch(recipe, robots, shape, rng)
        touches.append(found.unless(_is_fixed(robots, found.link)))
        pose = found.contact.pose.tolist()
        recipe["obstacles"].append({"link": "", "shape": _scattered(shape, rng), "pose": pose})
    cell = cell_of(recipe)
    return Draw(
        family, recipe, _motions(CellSubject(recipe, cell), touches, rng), float(rng.choice([1e-4, 1e-4, 1e-3]))
    )


def _count(weights: Sequence[float], rng: np.random.Generator) -> int:
    return int(rng.choice(len(weights), p=weights))


# ----- robots, and what they touch


def _robot(wishes: Wishes, is_whole: bool, rng: np.random.Generator) -> SpaceRecipe:
    """A tree with bodies, some with pairs of its own, in Pinocchio's own numbers or with a group."""
    while True:
        recipe = random_tree(Wishes(**{**vars(wishes), "whole": 2.0 * is_whole}), rng)
        robot = robot_of(recipe)
        if robot.nq > 0:
            break
    add_bodies(recipe, rng, False)
    if rng.random() < _SELF:
        choose_pairs(Stage(recipe, robot, tangents_of(robot, "slerp")), [], rng)
        tidy(recipe, rng)
    return recipe


def _touch(
    recipe: CellRecipe,
    robots: Mapping[str, Robot],
    shape: list[Any],
    rng: np.random.Generator,
    among: Sequence[str] | None = None,
) -> _Touch:
    """A shape laid upon a body of a robot, one that moves if some do."""
    name = str(rng.choice(among if among is not None else list(robots)))
    states = {each: random_states(robot, 1, rng)[0] for each, robot in robots.items()}
    bodies = recipe["robots"][name]["robot"]["bodies"]
    some = [body for body in bodies if not _is_fixed(robots, f"{name}/{body['link']}")] or bodies
    body = some[int(rng.integers(len(some)))]
    pose = _body_pose(recipe, robots, name, body, states[name])
    contact = random_contact(extent_of(shape_of(body["shape"])), pose, shape, rng)
    return _Touch(states, float(rng.uniform(0, 60)), f"{name}/{body['link']}", "", contact)


def _is_fixed(robots: Mapping[str, Robot], link: str) -> bool:
    """Whether no joint of the group moves a link, "robot/link"."""
    name, own = link.split("/")
    q = random_states(robots[name], 2, np.random.default_rng(0))
    first, second = robots[name].link_poses(q)[:, robots[name].link_index(own)]
    return bool((first == second).all())


def _body_pose(recipe: CellRecipe, robots: Mapping[str, Robot], name: str, body: Any, state: Floats) -> Floats:
    """(4, 4) of a body of a robot in the world."""
    link = robots[name].link_poses(state)[robots[name].link_index(body["link"])]
    return np.asarray(np.array(recipe["robots"][name]["pose"]) @ link @ np.array(body["pose"]))


def _base(recipe: CellRecipe, robots: Mapping[str, Robot], name: str, rng: np.random.Generator) -> _Touch:
    """Places the base of a robot so that one of its bodies touches an earlier robot."""
    bodies = recipe["robots"][name]["robot"]["bodies"]
    body = bodies[int(rng.integers(len(bodies)))]
    earlier = list(robots)[: list(robots).index(name)]
    found = _touch(recipe, robots, body["shape"], rng, earlier)
    own = _body_pose(recipe, robots, name, body, found.states[name])
    recipe["robots"][name]["pose"] = (found.contact.pose @ np.linalg.inv(own)).tolist()
    other = f"{name}/{body['link']}"
    are_fixed = _is_fixed(robots, found.link) and _is_fixed(robots, other)
    return replace(found, other=other).unless(are_fixed)


def _moving(recipe: CellRecipe, robots: Mapping[str, Robot], rng: np.random.Generator) -> list[_Touch]:
    """Adds a body that touches robots at chosen instants: at a time of its poses, or on its way between two."""
    shape, times, poses, touches = random_shape(rng), [], [], []
    for k in range(int(rng.integers(*_CONTACTS))):
        found = _touch(recipe, robots, shape, rng)
        time = _APART * k + float(rng.choice([5.0, rng.uniform(4, 8)]))
        before, after = rng.uniform(*_BESIDE, 2)
        axis, way = random_directions(2, rng)
        turn, go = 10.0 ** rng.uniform(*_TURNS), 10.0 ** rng.uniform(*_GOES) * way
        steps = [-before, after] if rng.random() < 0.5 else [-before, 0.0, after]
        times += [time + step for step in steps]
        poses += [_aside(found.contact.pose, turn / 6 * step * axis, step * go) for step in steps]
        touches.append(_Touch(found.states, time, found.link, "", found.contact))
    stands = bool(rng.random() < _STANDS_OUTSIDE)
    if not stands:
        times, poses = [-_ENDS, *times, _ENDS], [poses[0], *poses, poses[-1]]
    recipe["moving"].append({"shape": _scattered(shape, rng), "times": times, "poses": poses, "stands": stands})
    return touches


def _aside(pose: Floats, turn: Floats, go: Floats) -> Matrix:
    """A pose (4, 4) turned about its origin and moved, rad and m."""
    angle = float(np.linalg.norm(turn))
    axis = turn / angle if angle else turn
    out = pose.copy()
    quaternion = [*(np.sin(angle / 2) * axis).tolist(), float(np.cos(angle / 2))]
    out[:3, :3] = np.array(rotation_of_quaternion(quaternion)) @ pose[:3, :3]
    out[:3, 3] += go
    return [[float(x) for x in row] for row in out]


def _scattered(shape: list[Any], rng: np.random.Generator) -> list[Any]:
    """Some boxes and hulls become the clouds of their corners, one of which touches."""
    return ["corners", shape] if shape[0] in ("box", "hull") and rng.random() < _CLOUDS else shape


# ----- trajectories


def _motions(subject: CellSubject, touches: Sequence[_Touch], rng: np.random.Generator) -> Motions:
    each = CELL_MOTIONS * _CANDIDATES // len(touches) + 1
    tangents, units = tangents_of(subject.robot, "slerp"), unit_columns(subject.robot)
    passed = []
    for touch in touches:
        link = subject.robot.link_index(touch.link)
        other = subject.robot.link_index(touch.other) if touch.other else -1
        at, normal = touch.contact.point, touch.contact.normal
        aim = Aim(subject.robot.join(touch.states), link, other, at, normal, touch.contact.touches)
        passed.append(through(subject.robot, tangents, aim, each, rng))
    times = np.repeat([touch.time for touch in touches], each)
    motions = joined(passed)

    def check(q: Floats) -> Bools:
        return subject.check_states(np.column_stack([q, times]))

    tube, middle = tube_around(check, motions.through, units, rng)
    parts = np.split(np.arange(len(times)), len(touches))
    found = [each for part in parts for each in _rows(subject.robot, motions, middle, times, part, rng)]
    width, at = max(len(row) for row, _ in found), np.array([instant for _, instant in found])
    q0 = np.array([np.pad(row, (0, width - len(row))) for row, _ in found])
    states = np.column_stack([motions.through, times])
    made = Motions(q0, np.tile(tube, (len(q0), 1)), at, states, motions.touching)
    first, last = subject.ends(made.q0, made.q1)
    return made.of(sharpest_rows(subject.check_states(first) & subject.check_states(last), CELL_MOTIONS, rng))


def _rows(
    cell: Robot, motions: Motions, middle: Floats, times: Floats, rows: Any, rng: np.random.Generator
) -> list[tuple[Floats, float]]:
    """The numbers of trajectories through one contact, and the parameter of the contact."""
    own, names = motions.of(rows), [name for name, part in cell.parts.items() if len(part.columns)]
    mover = str(rng.choice(names))
    moves = [name for name in names if name == mover or rng.random() >= _STANDING]
    curves = {name: _curves(cell.parts[name], own, middle[rows], rng) for name in moves}
    found = []
    for k, row in enumerate(rows.tolist()):
        instant = max(curves[name][k][1] for name in moves)
        instant += 10.0 ** rng.uniform(*_LATE) if rng.random() < _NOT_AT_ONCE else 0.0
        runs = {}
        for name in names:
            columns = cell.parts[name].columns
            if name in moves:
                curve, passes = curves[name][k]
                runs[name] = Run(instant - passes, curve)
            else:
                runs[name] = Run(0.0, middle[row, columns])
        at = min(instant / duration(runs), 1.0)
        found.append((row_of(float(times[row] - instant), list(runs.values())), at))
    return found


def _curves(part: CellPart, motions: Motions, middle: Floats, rng: np.random.Generator) -> list[tuple[Curve, float]]:
    """Curves of one robot through its part of states, and when they pass it, s of their own clock."""
    own = Motions(
        motions.q0[:, part.columns],
        motions.q1[:, part.columns],
        motions.at,
        motions.through[:, part.columns],
        motions.touching,
    )
    units = unit_columns(part.robot)
    at = own.at if units.any() else instants(own.at, rng)
    degree = int(rng.integers(1, MOST_DEGREE + 1))
    points = points_through(own, at, middle[:, part.columns], degree, rng)
    points[:, :, units] = own.through[:, None, units]
    points[:, 0, units], points[:, -1, units] = own.q0[:, units], own.q1[:, units]
    is_controlled = degree in _CONTROLLERS and not units.any() and rng.random() < _CONTROLLED
    found = []
    for k in range(len(at)):
        pieces, lengths, before = [points[k]], [_length(rng)], 0
        if rng.random() < _BEFORE:
            pieces.insert(0, _beside(points[k][0], units, rng)[::-1])
            lengths.insert(0, _length(rng))
            before = 1
        if is_controlled or rng.random() < _BEFORE:  # controllers end at rest
            pieces.append(_beside(points[k][-1], units, rng))
            lengths.append(_length(rng))
        breaks = float(rng.choice(_BEGINS)) + np.cumsum([0.0, *lengths])
        passes = float(breaks[before] + at[k] * (breaks[before + 1] - breaks[before]))
        curve = Curve(breaks, tuple(pieces), np.zeros(len(units)))
        found.append((_controlled(curve, before, rng) if is_controlled else curve, passes))
    return found


def _length(rng: np.random.Generator) -> float:
    return float(rng.choice(_EVEN) if rng.random() < _LENGTH_IS_EVEN else 10.0 ** rng.uniform(*_LENGTHS))


def _beside(point: Floats, units: Any, rng: np.random.Generator) -> Floats:
    """Control points of a piece from a point to anywhere; unit vectors stand."""
    size = 10.0 ** rng.uniform(*_SIZES)
    points = np.asarray(point + size * rng.normal(size=(int(rng.integers(2, MOST_DEGREE + 2)), len(point))))
    points[0], points[:, units] = point, point[units]
    return points


def _controlled(curve: Curve, through: int, rng: np.random.Generator) -> Curve:
    """The same piece through the contact by a controller, which runs others before and after."""
    points, length = curve.pieces[through], curve.breaks[through + 1] - curve.breaks[through]
    degree = len(points) - 1
    q = np.array([curve.pieces[0][0], *(piece[-1] for piece in curve.pieces)])
    v, a = (rng.normal(size=q.shape) for _ in range(2))
    v[-1] = a[-1] = 0.0
    velocity, acceleration = (
        np.diff(points, axis=0) * degree / length,
        np.diff(points, 2, axis=0) * degree * (degree - 1),
    )
    v[[through, through + 1]] = velocity[[0, -1]]
    if degree == 5:
        a[[through, through + 1]] = acceleration[[0, -1]] / length**2
    return Trajectory(
        curve.breaks, q, v if degree > 1 else None, a if degree == 5 else None, controller=_CONTROLLERS[degree]
    ).curve
