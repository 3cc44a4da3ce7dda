"""The signed distance of two bodies on a robot's links and its derivatives in 300 bits, by Pinocchio's own joints.

In: a robot whose joints turn or slide, one row of a table of distances. Out: the derivative by each number of the
configuration, by central differences at steps of 1e-25. Shares nothing with cpp/: kinematics are products of the
model's placements in python-flint, and the distance is that of the features (vertex, edge, face) that hold the nearest
points, whose place inside the features is checked. Of bodies with parts, each pair of parts that is nearest by brute
force gives a derivative.
"""

from dataclasses import dataclass
from typing import Any

import flint
import numpy as np
import pinocchio as pin
from part_oracle import PartOracle
from solid_meshes import ring

import plannercheck as pc

STEP = "1e-25"
BITS = 300  # set where they are needed: the precision is the process's

Matrix = Any  # flint.arb_mat


class NoSingleFeatureError(ValueError):
    """The nearest points are on no features that this oracle can tell."""


def _matrix(values: Any) -> Matrix:
    return flint.arb_mat([[flint.arb(float(x)) for x in row] for row in np.asarray(values)])


def _column(point: Any) -> Matrix:
    return flint.arb_mat([[x] for x in point])


def _dot(a: list[Any], b: list[Any]) -> Any:
    return sum((x * y for x, y in zip(a, b, strict=True)), flint.arb(0))


def _cross(a: list[Any], b: list[Any]) -> list[Any]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _minus(a: list[Any], b: list[Any]) -> list[Any]:
    return [x - y for x, y in zip(a, b, strict=True)]


@dataclass(frozen=True)
class Joint:
    """One of Pinocchio's joints: where it is placed on its parent, what it turns about or slides along."""

    parent: int
    placement: Matrix
    axis: list[Any]
    slides: bool
    column: int
    multiplier: Any
    offset: Any

    def motion(self, q: list[Any]) -> Matrix:
        """(4, 4) at a configuration."""
        value = (q[self.column] * self.multiplier if self.column >= 0 else flint.arb(0)) + self.offset
        if self.slides:
            x, y, z = (value * a for a in self.axis)
            return flint.arb_mat([[1, 0, 0, x], [0, 1, 0, y], [0, 0, 1, z], [0, 0, 0, 1]])
        s, c = value.sin_cos()
        x, y, z = self.axis
        rest = 1 - c
        return flint.arb_mat(
            [
                [c + x * x * rest, x * y * rest - z * s, x * z * rest + y * s, 0],
                [y * x * rest + z * s, c + y * y * rest, y * z * rest - x * s, 0],
                [z * x * rest - y * s, z * y * rest + x * s, c + z * z * rest, 0],
                [0, 0, 0, 1],
            ]
        )


class Chains:
    """A robot's joints; all of them turn or slide."""

    def __init__(self, robot: Any) -> None:
        model, known = robot.model, robot.configuration_map
        self.joints: list[Joint] = []
        for k in range(1, model.njoints):
            joint = model.joints[k]
            if joint.nv != 1:
                raise NoSingleFeatureError(f"joint {model.names[k]} has more than one degree of freedom")
            data = joint.createData()
            joint.calc(data, np.eye(1, joint.idx_q + joint.nq, joint.idx_q)[0])
            linear, angular = np.reshape(data.S, (2, 3))
            slides, entry = bool(np.any(linear)), joint.idx_q
            self.joints.append(
                Joint(
                    model.parents[k] - 1,
                    _matrix(model.jointPlacements[k].homogeneous),
                    [flint.arb(float(x)) for x in (linear if slides else angular)],
                    slides,
                    int(known.columns[entry]),
                    flint.arb(float(known.multipliers[entry])),
                    flint.arb(float(known.offsets[entry])),
                )
            )
        self._frames = [model.frames[i] for i in (model.getFrameId(n, _BODIES) for n in robot.link_names)]
        self._names = list(robot.link_names)

    def pose(self, link: str | None, q: list[Any], placement: Any) -> Matrix:
        """World pose of a body on a link, None for the world."""
        if link is None:
            return _matrix(placement)
        frame = self._frames[self._names.index(link)]
        pose = _matrix(frame.placement.homogeneous) * _matrix(placement)
        joint = frame.parentJoint - 1
        while joint >= 0:
            pose = self.joints[joint].placement * self.joints[joint].motion(q) * pose
            joint = self.joints[joint].parent
        return pose


_BODIES = pin.FrameType.BODY


def _features(vertices: np.ndarray[Any, Any], pose: np.ndarray[Any, Any], normal: Any) -> np.ndarray[Any, Any]:
    """Up to three corners of the feature that lies lowest along the normal."""
    heights = (vertices @ pose[:3, :3].T) @ normal
    size = float(np.ptp(vertices, axis=0).max())
    lowest = np.flatnonzero(heights <= heights.min() + 1e-13 * max(size, 1e-2))
    if len(lowest) <= 2:
        return vertices[lowest]
    corners = vertices[lowest]
    first, second = corners[0], corners[np.argmax(((corners - corners[0]) ** 2).sum(axis=1))]
    third = corners[np.argmax((np.cross(corners - first, second - first) ** 2).sum(axis=1))]
    return np.array([first, second, third])


def _world(points: Any, pose: Matrix) -> list[list[Any]]:
    return [
        [x[0] for x in (pose * _column([*(flint.arb(float(c)) for c in p), flint.arb(1)])).tolist()[:3]] for p in points
    ]


def _apart(a: list[list[Any]], b: list[list[Any]]) -> Any:
    """The distance of two features' lines or planes, one of which is a vertex, or both are edges."""
    if len(a) > len(b):
        a, b = b, a
    difference = _minus(a[0], b[0])
    if (len(a), len(b)) == (1, 1):
        return _dot(difference, difference).sqrt()
    if (len(a), len(b)) == (1, 2):
        edge = _minus(b[1], b[0])
        rest = _cross(difference, edge)
        return (_dot(rest, rest) / _dot(edge, edge)).sqrt()
    if (len(a), len(b)) == (1, 3):
        normal = _cross(_minus(b[1], b[0]), _minus(b[2], b[0]))
    elif (len(a), len(b)) == (2, 2):
        normal = _cross(_minus(a[1], a[0]), _minus(b[1], b[0]))
    else:
        raise NoSingleFeatureError("faces or edges are parallel")
    return abs(_dot(difference, normal)) / _dot(normal, normal).sqrt()


class Differences:
    """Derivatives of the distances of a checker's pairs."""

    def __init__(self, checker: Any) -> None:
        with flint.ctx.workprec(BITS):
            self._checker, self._chains = checker, Chains(checker.robot)
        self._oracles: dict[int, PartOracle] = {}

    def gradients(self, q: Any, pair: int, normal: Any, distance: float) -> tuple[Any, float]:
        """(k, nq) at a configuration (nq,), of each of the k nearest pairs of parts, and the distance.

        Raises:
            NoSingleFeatureError: If the features' lines or planes have another distance: the nearest points are
                elsewhere.
        """
        places = self._checker.pairs[pair].tolist()
        hulls = [self._checker._preparation.polytope(k) for k in places]
        poses = self._checker.body_poses(q[None])[0][places]
        oracle = self._oracles.setdefault(pair, PartOracle(*hulls))
        with flint.ctx.workprec(BITS):
            bodies = [self._checker.bodies[k] for k in places]
            found = [
                self._gradient(q, bodies, [oracle.parts[0][i], oracle.parts[1][j]], poses, normal, distance)
                for i, j in oracle.nearest(poses)
            ]
        return np.array([gradient for gradient, _ in found]), found[0][1]

    def _gradient(
        self, q: Any, bodies: list[Any], parts: list[Any], poses: Any, normal: Any, distance: float
    ) -> tuple[Any, float]:
        features = [_features(parts[0].vertices, poses[0], normal), _features(parts[1].vertices, poses[1], -normal)]
        inflation = sum(flint.arb(part.inflation_radius) for part in parts)
        exact = [flint.arb(float(x)) for x in q]
        overlap = bool(distance + inflation < 0)
        if overlap and sum(map(len, features)) < 4:
            raise NoSingleFeatureError("no facet of the difference holds the deepest points")

        def apart(numbers: list[Any]) -> Any:
            world = [
                _world(feature, self._chains.pose(body.link, numbers, body.pose))
                for feature, body in zip(features, bodies, strict=True)
            ]
            return (-_apart(*world) if overlap else _apart(*world)) - inflation

        found = float(apart(exact).mid())
        if abs(found - distance) > 1e-11:
            raise NoSingleFeatureError(f"the features are {found} m apart, not {distance} m")
        gradient, step = [], flint.arb(STEP)
        for k in range(len(exact)):
            ends = [apart([x + (h if j == k else 0) for j, x in enumerate(exact)]) for h in (step, -step)]
            gradient.append(float(((ends[0] - ends[1]) / (2 * step)).mid()))
        return np.array(gradient), found


def scene_around(robot, seed: int, parts: bool = False) -> pc.Scene:
    """Boxes, balls and a pole in the robot's reach; with `parts`, also a ring, a cloud and a grid."""
    rng = np.random.default_rng(seed)
    scene = pc.Scene("around")
    for k in range(8):
        pose = np.eye(4)
        pose[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        pose[:3, 0] *= np.linalg.det(pose[:3, :3])
        pose[:3, 3] = rng.uniform(-1, 1, 3) * 0.9
        shape = (pc.Box(rng.uniform(0.05, 0.3, 3)), pc.Sphere(0.1), pc.Capsule(0.05, 0.3))[k % 3]
        scene.add(f"body{k}", shape, pose)
    if parts:
        points, triangles = ring(16, 8, 0.3)
        scene.add("ring", pc.Solid(0.3 * points + (0.5, 0.5, 0.9), triangles))
        scene.add("cloud", pc.PointCloud(rng.uniform(-0.8, 0.8, size=(200, 3)), 0.01))
        scene.add("grid", pc.VoxelGrid(rng.random((12, 12, 12)) < 0.02, 0.1, (-0.6, -0.6, 0.0)))
    return scene
