"""Random robots, scenes that move, and trajectories, with a contact at a chosen instant; and the merged robot."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin

import plannercheck as pc

_LINK = """<link name="{name}"><collision><origin xyz="{xyz}"/><geometry><box size="{size}"/></geometry></collision>
</link>"""
_JOINT = """<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}"
 rpy="{rpy}"/><axis xyz="{axis}"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
"""
_FLOATING = """<link name="pallet"><collision name="pallet"><geometry><box size="{size}"/></geometry></collision></link>
<joint name="z carries" type="floating"><parent link="world"/><child link="pallet"/></joint>
"""


def arm_urdf(rng: np.random.Generator, joints: int, pallet: tuple[float, ...] | None = None) -> str:
    """An arm on a base that is fixed to the world; with the size of a pallet also that, on a floating joint."""

    def row(*values: float) -> str:
        return " ".join(map(repr, map(float, values)))

    text = '<link name="world"/>' + _LINK.format(name="base", xyz="0 0 0.05", size="0.2 0.2 0.1")
    text += '<joint name="stands" type="fixed"><parent link="world"/><child link="base"/></joint>'
    for k in range(joints):
        length = rng.uniform(0.2, 0.4)
        axis = rng.standard_normal(3)
        placed = {"xyz": row(0, 0, 0.15 if k == 0 else rng.uniform(0.25, 0.4)), "rpy": row(*rng.uniform(-1, 1, 3))}
        text += _LINK.format(name=f"l{k}", xyz=row(0, 0, length / 2), size=row(0.06, 0.08, length))
        parent = "base" if k == 0 else f"l{k - 1}"
        text += _JOINT.format(
            name=f"j{k}", parent=parent, child=f"l{k}", axis=row(*axis / np.linalg.norm(axis)), **placed
        )
    text += "" if pallet is None else _FLOATING.format(size=row(*pallet))
    return f'<robot name="arm">{text}</robot>'


def random_pose(rng: np.random.Generator, position: np.ndarray | None = None) -> np.ndarray:
    """A pose (4, 4) at a position, by default within reach."""
    turn = rng.standard_normal(4)
    pose = np.eye(4)
    pose[:3, :3] = pin.Quaternion(turn / np.linalg.norm(turn)).matrix()
    pose[:3, 3] = rng.uniform(-0.8, 0.8, 3) if position is None else position
    return pose


class MovingCase(NamedTuple):
    """A checker of a scene that moves, a trajectory, and when it begins on the scene's clock."""

    checker: pc.Checker
    trajectory: pc.Trajectory
    start_time: float

    def sampled(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Configurations (n, nq) and times (n,) on the trajectory, its knots and the scene's included."""
        own = self.trajectory.curve.breaks
        knots = [item.moving.times for item in self.checker.scene.moving]
        times = np.concatenate([np.linspace(0, own[-1] - own[0], count), *(each - self.start_time for each in knots)])
        times = np.unique(np.clip(times, 0, own[-1] - own[0]))
        return self.trajectory.position(np.minimum(own[0] + times, own[-1])), times + self.start_time


def contact_case(rng: np.random.Generator, folder: Path) -> MovingCase:
    """An arm and a few boxes that move; at a chosen instant one of them is near a link, or touches it."""
    urdf = folder / "arm.urdf"
    urdf.write_text(arm_urdf(rng, int(rng.integers(1, 4))))
    robot = pc.Robot.from_urdf(urdf)
    knots = np.sort(rng.uniform(0, 4, int(rng.integers(2, 6))))
    knots[0], knots[-1] = 0.0, 4.0
    ways = rng.uniform(-0.8, 0.8, (len(knots), robot.nq))
    velocities = rng.uniform(-1, 1, ways.shape) if rng.random() < 0.5 else None
    if velocities is not None:
        velocities[-1] = 0.0
    trajectory = pc.Trajectory(knots + rng.choice([0.0, 1.5]), ways, velocities, controller="jtc")
    start_time = float(rng.choice([0.0, rng.uniform(-2, 2)]))
    instant = rng.uniform(0.3, 3.7)
    q = trajectory.position(trajectory.curve.breaks[0] + instant)
    body = robot.bodies[int(rng.integers(len(robot.bodies)))]
    there = robot.link_poses(q)[robot.link_index(body.link)] @ body.pose
    scene = pc.Scene("moving")
    scene.add_box("table", (0.3, 0.3, 0.02), random_pose(rng, np.array([0, 0, -0.7])))
    near = there[:3, 3] + rng.standard_normal(3) * rng.choice([0.1, 0.2, 0.35])
    for k in range(int(rng.integers(1, 3))):
        times = np.sort(rng.uniform(start_time - 0.5, start_time + 4.5, int(rng.integers(0, 4))))
        times = np.concatenate([[start_time - 1], times, [start_time + 5]])
        poses = np.array([random_pose(rng) for _ in times])
        if k == 0:
            times = np.sort(np.append(times, start_time + instant))
            place = int(np.searchsorted(times, start_time + instant))
            poses = np.insert(poses, place, random_pose(rng, near), axis=0)
        shape = [pc.Box(tuple(rng.uniform(0.03, 0.2, 3))), pc.Sphere(0.1), pc.Capsule(0.05, 0.2)][int(rng.integers(3))]
        scene.add(f"mover {k}", shape, pc.Moving(times, poses, path=("slerp", "screw")[int(rng.integers(2))]))
    return MovingCase(pc.Checker(robot, scene, self_collision=False), trajectory, start_time)
