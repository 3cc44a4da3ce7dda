"""Random draws of the motion stress in the plane: chains and trailers, straight motions, Dubins and Reeds-Shepp curves.

In: a family's name, a random generator. Out: a `Draw`. As in space, a state is chosen first, and an obstacle is put
where it touches a body of the robot at that state. Straight motions pass the state. For curves, a curve is drawn first
and the state is a state on it; further curves differ a little.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from plannercheck import planar
from plannercheck.common.array_types import Floats
from plannercheck.evaluation.stress_motions.aims import Motions, joined, lengths, lifted, parameters
from plannercheck.evaluation.stress_motions.draws import MOTIONS, Draw, sharpest
from plannercheck.evaluation.stress_motions.recipes import LinkRecipe, PlaneRecipe, PolygonRecipe, planar_robot_of
from plannercheck.evaluation.stress_motions.subjects import PlaneSubject

PLANAR_FAMILIES = ("plane chain", "plane swing", "plane shipped", "plane curves")
# Motions of a draw on curves: taking a curve apart costs more than all else.
CURVES = 30
_SHIPPED = (("forklift", "warehouse"), ("forklift", "parking"), ("truck_trailer", "parking"), ("truck_trailer", ""))

_OBSTACLES, _TRAILERS = (3, 9), (0, 4)
# Footprints: corners, sizes, m, and how far off their link's origin they lie, m.
_CORNERS, _SIZES, _OFFSETS = (3, 9), (-3.0, 0.3), (0.0, 0.0, 1.0, 8.0)
_LARGE, _LARGE_SIZES = 0.4, (2.0, 8.0)
_DEPTHS, _GAPS, _TOUCHING = (-6.0, -1.5), (-3.9, -0.5), 4 / 6
# Contacts at the corner that is furthest from the joint; contacts that are deeper, of so many.
_OUTERMOST, _DEEPER, _DEEP = 0.5, 0.5, (-3.0, -1.3)
# A square about its centre; motions of a swinging arm that are drawn back from the post.
_SQUARE, _DRAWN_BACK = np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]]), 0.4
# Positions of the root without bounds, m; headings and hinges go further round now and then, by whole turns up to
# this power of ten.
_AREA, _FAR, _FARTHEST = 5.0, 0.1, 15.0
_LONGEST_TURN = 3.1
_STEP = 1e-5
_ALONG, _FEW, _FIXED_ROOT = 0.6, 0.3, 0.2
_JITTER = (-7.0, -2.0)
_CANDIDATES = 3


def planar_draw(family: str, rng: np.random.Generator) -> Draw:
    """A planar robot among contacts."""
    recipe = _recipe(family, rng)
    robot = planar_robot_of(recipe)
    if family == "plane swing":
        return _swing(recipe, rng)
    curve = family == "plane curves"
    makers = [_curve_motions if curve else _straight_motions for _ in range(int(rng.integers(*_OBSTACLES)))]
    motions = joined([make(recipe, robot, len(makers), rng) for make in makers])
    tolerance = float(rng.choice([1e-4, 1e-4, 1e-3]))
    if curve:
        return Draw(family, recipe, motions, tolerance)
    return Draw(family, recipe, sharpest(PlaneSubject(recipe).checker, motions, MOTIONS, rng), tolerance)


def _recipe(family: str, rng: np.random.Generator) -> PlaneRecipe:
    recipe: PlaneRecipe = {
        "kind": "plane",
        "shipped": "",
        "links": [],
        "scene": "",
        "obstacles": [],
        "self_collision": bool(rng.random() < _TOUCHING),
        "curve": "straight",
        "radius": None,
    }
    if family == "plane curves":
        recipe["curve"] = str(rng.choice(["dubins", "reeds_shepp"]))
        recipe["radius"] = float(10.0 ** rng.uniform(-0.7, 1.0))
    if family == "plane shipped" or (family == "plane curves" and rng.random() < _FEW):
        recipe["shipped"], recipe["scene"] = _SHIPPED[int(rng.integers(len(_SHIPPED)))]
        return recipe
    free = family == "plane curves" or rng.random() >= _FIXED_ROOT
    recipe["links"].append(_link("root", None, "free" if free else "revolute", rng))
    for k in range(int(rng.integers(*_TRAILERS))):
        parent = recipe["links"][int(rng.integers(len(recipe["links"])))]["name"]
        joint = "fixed" if rng.random() < _FAR else "revolute"
        recipe["links"].append(_link(f"link {k}", parent, joint, rng))
    return recipe


def _link(name: str, parent: str | None, joint: str, rng: np.random.Generator) -> LinkRecipe:
    reach = float(rng.choice([0.3, 3.0]))
    limited = joint == "revolute" and rng.random() < _FEW
    return {
        "name": name,
        "footprint": _polygon(float(rng.choice(_OFFSETS)), rng).tolist(),
        "parent": parent,
        "anchor": [float(x) for x in (*rng.uniform(-reach, reach, 2), rng.uniform(-3, 3))],
        "joint": joint,
        "limits": [-float(rng.uniform(0.3, 4)), float(rng.uniform(0.3, 4))] if limited else None,
    }


def _polygon(offset: float, rng: np.random.Generator, large: float = _LARGE) -> Floats:
    """A convex polygon (n, 2): points on a stretched circle, a thin or small box, or an arm that points outwards."""
    size = float(rng.uniform(*_LARGE_SIZES)) if rng.random() < large else 10.0 ** rng.uniform(*_SIZES)
    thin = 10.0 ** rng.uniform(-3, 0)
    kind = rng.integers(4)
    if kind == 3:  # as it lies: it swings about its root, its end ahead
        return np.array([offset * rng.random(), 0.0]) + 0.5 * np.array(
            [[0, -thin], [size, -thin], [size, thin], [0, thin]]
        )
    if kind == 0:
        points = 0.5 * np.array([[-size, -thin], [size, -thin], [size, thin], [-size, thin]])
    elif kind == 1:
        points = 5e-4 * np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]])
    else:
        n = int(rng.integers(*_CORNERS))
        angles = (np.arange(n) + 0.8 * rng.random(n)) * 2 * np.pi / n
        points = 0.5 * size * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    turn = rng.uniform(-np.pi, np.pi)
    c, s = np.cos(turn), np.sin(turn)
    return np.asarray(points @ np.array([[c, s], [-s, c]]) + offset * rng.uniform(-1, 1, 2))


def _swing(recipe: PlaneRecipe, rng: np.random.Generator) -> Draw:
    """A long arm, far off its root, that swings past a post at its end; and the same drawn back a little.

    What is kept of a motion that just misses is what the next one, which does not, is looked at with.
    """
    inner, length, thick = float(rng.uniform(0, 10)), float(rng.uniform(0.5, 6)), 10.0 ** rng.uniform(-3, 0)
    outline = [[inner, -thick / 2], [inner + length, -thick / 2], [inner + length, thick / 2], [inner, thick / 2]]
    recipe["links"] = [_link("root", None, "free", rng)]
    recipe["links"][0].update({"footprint": outline, "anchor": [0.0, 0.0, 0.0]})
    x, y, heading = rng.uniform(-_AREA, _AREA, 3)
    axis = np.array([np.cos(heading), np.sin(heading)])
    small = 10.0 ** rng.uniform(-3, -1)
    post = np.array([x, y]) + (inner + length) * axis
    pose = planar.pose_of(post - (10.0 ** rng.uniform(*_DEEP) - small / 2) * axis, float(heading))
    recipe["obstacles"] = [{"vertices": (0.5 * small * _SQUARE).tolist(), "pose": pose.tolist()}]
    n = MOTIONS
    at, turn = parameters(n, rng), 10.0 ** rng.uniform(-2, -0.3, n) * rng.choice([-1, 1], n)
    back = np.where(rng.random(n) < _DRAWN_BACK, 10.0 ** rng.uniform(-2, -0.5, n), 0.0)
    passed = np.column_stack([x - back * axis[0], y - back * axis[1], np.full(n, heading)])
    way = np.column_stack([np.zeros((n, 2)), turn])
    q0, q1 = passed - at[:, None] * way, passed + (1 - at)[:, None] * way
    return Draw("plane swing", recipe, Motions(q0, q1, at, passed, back == 0), float(rng.choice([1e-4, 1e-3])))


def _states(robot: planar.Robot, n: int, rng: np.random.Generator) -> Floats:
    q = robot.random_configurations(n, rng)
    unlimited = np.isinf(robot.lower) & ~robot.angles
    q[:, unlimited] *= _AREA
    if rng.random() < _FAR:
        turns = 2 * np.pi * np.round(rng.choice([-1, 1]) * 10.0 ** rng.uniform(0, _FARTHEST - 1))
        q[:, robot.angles] += turns * rng.integers(0, 2, robot.angles.sum())
    return q


def _touch(robot: planar.Robot, state: Floats, rng: np.random.Generator) -> tuple[PolygonRecipe, Any, bool]:
    """An obstacle laid upon a body at a state; the link, point and normal of the contact; whether it touches."""
    moving = [k for k, body in enumerate(robot.bodies) if _moves(robot, body.link)]
    body = robot.bodies[moving[int(rng.integers(len(moving)))]]
    pose = robot.link_poses(state)[body.link]
    corners = body.vertices @ pose[:2, :2].T + pose[:2, 2]
    turn = rng.uniform(-np.pi, np.pi)
    normal = np.array([np.cos(turn), np.sin(turn)])
    if rng.random() < _OUTERMOST:  # what swings about its joint comes nearest where it is furthest out
        arms = corners - pose[:2, 2]
        furthest = arms[int(np.argmax((arms**2).sum(axis=1)))]
        normal = furthest / max(float(np.linalg.norm(furthest)), 1e-300)
    point = corners[int(np.argmax(corners @ normal))]
    vertices, placed = _polygon(0.0, rng, large=0.0), np.eye(3)
    spin = rng.uniform(-np.pi, np.pi)
    placed[:2, :2] = [[np.cos(spin), -np.sin(spin)], [np.sin(spin), np.cos(spin)]]
    other = vertices @ placed[:2, :2].T
    foot = other[int(np.argmin(other @ normal))]
    touches = bool(rng.random() < _TOUCHING)
    if touches:
        inward = corners.mean(axis=0) - point
        length = float(np.linalg.norm(inward))
        depth = min(10.0 ** rng.uniform(*(_DEEP if rng.random() < _DEEPER else _DEPTHS)), 0.5 * length)
        placed[:2, 2] = point + depth * inward / max(length, 1e-300) - foot
    else:
        placed[:2, 2] = point + 10.0 ** rng.uniform(*_GAPS) * normal - foot
    obstacle: PolygonRecipe = {"vertices": vertices.tolist(), "pose": placed.tolist()}
    return obstacle, (body.link, point, normal), touches


def _moves(robot: planar.Robot, link: int) -> bool:
    while link >= 0:
        if robot.links[link].joint != "fixed":
            return True
        link = robot.parent_index(link)
    return False


def _straight_motions(recipe: PlaneRecipe, robot: planar.Robot, shares: int, rng: np.random.Generator) -> Motions:
    """An obstacle, and straight motions through the state of its contact."""
    (state,) = _states(robot, 1, rng)
    obstacle, where, touches = _touch(robot, state, rng)
    recipe["obstacles"].append(obstacle)
    n = MOTIONS * _CANDIDATES // shares + 1
    way = rng.normal(size=(n, robot.nq))
    few = rng.random(n) < _FEW
    way[few] *= rng.random((int(few.sum()), robot.nq)) < 1.5 / robot.nq
    rates = _rates(robot, state, *where)
    along = rng.random(n) < _ALONG
    square = float(rates @ rates)
    way -= np.where(along & (square > 0), way @ rates / max(square, 1e-300), 0.0)[:, None] * rates
    largest = np.abs(way).max(axis=1)
    way *= (lengths(n, rng) / np.where(largest > 0, largest, 1))[:, None]
    turned = np.abs(way[:, robot.angles]).max(axis=1, initial=0.0)
    way *= np.minimum(1, _LONGEST_TURN / np.maximum(turned, 1e-300))[:, None]
    at = parameters(n, rng)
    passed, touching = lifted(state, rates, touches, n, rng)
    q0, q1 = passed - at[:, None] * way, passed + (1 - at)[:, None] * way
    q0[at == 0], q1[at == 1] = passed[at == 0], passed[at == 1]
    return Motions(q0, q1, at, passed, touching)


def _rates(robot: planar.Robot, state: Floats, link: int, point: Floats, normal: Floats) -> Floats:
    """(nq,) how fast each number lifts a link's point along the normal; m per rad or m."""
    steps = _STEP * np.eye(robot.nq)
    poses = robot.link_poses(np.vstack([state, state + steps, state - steps]))[:, link]
    own = poses[0, :2, :2].T @ (point - poses[0, :2, 2])
    seen = poses[:, :2, :2] @ own + poses[:, :2, 2]
    return np.asarray((seen[1 : robot.nq + 1] - seen[robot.nq + 1 :]) @ normal / (2 * _STEP))


def _curve_motions(recipe: PlaneRecipe, robot: planar.Robot, shares: int, rng: np.random.Generator) -> Motions:
    """An obstacle on a curve, that curve, and some a little off it: of these no contact is known."""
    q0, q1 = _states(robot, 2, rng)
    at = float(rng.uniform(0.05, 0.95))
    q1 = q0 + (q1 - q0) * float(rng.choice([1.0, 0.3, 0.01]))
    bare: PlaneRecipe = {**recipe, "obstacles": []}
    (state,) = PlaneSubject(bare, robot).states(q0, q1, np.array([at]))
    obstacle, _, touches = _touch(robot, state, rng)
    recipe["obstacles"].append(obstacle)
    n = CURVES // shares + 1
    shift = rng.normal(size=(2, n, robot.nq)) * 10.0 ** rng.uniform(*_JITTER, (1, n, 1))
    shift[:, 0] = 0
    known = np.zeros(n, dtype=bool)
    known[0] = touches
    inside = np.where(np.arange(n) == 0, at, 1.0)
    starts, ends = q0 + shift[0], q1 + shift[1]
    passed = ends.copy()  # of the others only the end is known
    passed[0] = state
    return Motions(starts, ends, inside, passed, known)
