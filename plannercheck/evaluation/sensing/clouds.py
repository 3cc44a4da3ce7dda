"""Clouds of a scene: what several cameras around it see, and as many points of that as are wanted.

In: a scene, a number of points, a seed; a robot and a configuration, if it is to be seen as well. Out: points
(n, 3) in the world, m. All cameras have the same number of pixels, enough for the wanted points.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plannercheck.bodies.shapes import GeometryObject
from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.sensing.cameras import DepthCamera, looking
from plannercheck.evaluation.sensing.noise import DepthNoise
from plannercheck.evaluation.sensing.rays import depth_image
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene

Placed = Sequence[tuple[GeometryObject, Floats]]

# What the cameras look at, and where they stand, m: in front of a robot arm, at both sides, above it.
TARGET = (0.6, 0.0, 0.5)
EYES = ((-0.6, 1.2, 1.5), (-0.6, -1.2, 1.5), (1.0, 1.6, 1.7), (1.0, -1.6, 1.7))
# An image is so much wider than high.
_ASPECT = 4 / 3
# Pixels of the images from which the part that sees something is estimated.
_TRIAL = 64
# So many pixels more are asked for than the estimate says.
_SPARE = 1.1


def scene_bodies(scene: Scene) -> Placed:
    """A scene's obstacles at their poses in the world."""
    return [(body, np.asarray(body.pose)) for body in scene.bodies]


def robot_bodies(robot: Robot, q: Floats) -> Placed:
    """A robot's own bodies at a configuration (nq,)."""
    poses = robot.link_poses(q)
    return [(body, poses[robot.link_index(str(body.link))] @ body.pose) for body in robot.bodies]


def camera_poses() -> list[Floats]:
    """Poses (4, 4) of the cameras, m."""
    return [looking(eye, TARGET) for eye in EYES]


def cloud(
    bodies: Placed,
    count: int,
    seed: int,
    noise: DepthNoise | None = None,
    base: tuple[float, float] = (0.0, 0.0),
) -> Floats:
    """Exactly so many points of bodies, as cameras see them.

    Args:
        bodies: What is seen, with poses in the world, m.
        count: Number of points.
        seed: Seed of noise and choice.
        noise: What the cameras get wrong; None for the usual noise.
        base: Radius and height, m, of a cylinder about the world's z axis: what is seen of the floor in there is left
            out, since a robot stands there.

    Returns:
        (count, 3) m.

    Raises:
        PlannercheckError: If the cameras see nothing, or a body has no volume.
    """
    rng, placed = np.random.default_rng(seed), camera_poses()
    wrong = DepthNoise() if noise is None else noise
    points = outside(_seen(bodies, placed, _pixels(bodies, placed, wrong, count), wrong, rng), base)
    while len(points) < count:
        more = _seen(bodies, placed, _camera(max(_TRIAL * _TRIAL, count // 8)), wrong, rng)
        points = np.concatenate([points, outside(more, base)])
    return np.ascontiguousarray(points[np.sort(rng.choice(len(points), count, replace=False))])


def outside(points: Floats, base: tuple[float, float]) -> Floats:
    """The points (n, 3) that are not where the robot stands."""
    return points[(np.hypot(points[:, 0], points[:, 1]) >= base[0]) | (points[:, 2] >= base[1])]


def _pixels(bodies: Placed, poses: Sequence[Floats], noise: DepthNoise, count: int) -> DepthCamera:
    """The camera whose pixels suffice for so many points."""
    trial = _camera(_TRIAL * _TRIAL)
    part = len(_seen(bodies, poses, trial, noise, np.random.default_rng(0))) / (trial.width * trial.height)
    if part == 0:
        raise PlannercheckError("the cameras see none of the bodies")
    return _camera(int(_SPARE * count / part) + 1)


def _camera(pixels: int) -> DepthCamera:
    width = int(np.ceil(np.sqrt(pixels * _ASPECT)))
    return DepthCamera(width, int(np.ceil(pixels / width)))


def _seen(
    bodies: Placed, poses: Sequence[Floats], camera: DepthCamera, noise: DepthNoise, rng: np.random.Generator
) -> Floats:
    """All points (n, 3) that all cameras see, m."""
    images = ((noise.of(depth_image(bodies, camera, pose), rng), pose) for pose in poses)
    return np.concatenate([camera.points(depth, pose) for depth, pose in images])
