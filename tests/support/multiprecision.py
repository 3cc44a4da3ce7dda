"""Forward kinematics in 200 bits, from the same joint table that the compiled kernel gets: what rounding is held to."""

import functools

import mpmath
import numpy as np

from plannercheck.bodies.shapes import Cone, Cylinder, inflated_hull
from plannercheck.robots.kinematic_error import radius_of
from plannercheck.robots.kinematics import joint_table

# The exact poses' own error, about 1e-59, is nothing beside what is measured.
CONTEXT = mpmath.MPContext()
CONTEXT.prec = 200

exactly = np.frompyfunc(CONTEXT.mpf, 1, 1)
rounded = np.frompyfunc(float, 1, 1)


def table_of(robot):
    return joint_table(robot.model, robot._map, robot.link_tree.frames)


def link_poses(table, q):
    """(links, 3, 4) in multi-precision of one configuration (nq,)."""
    joints = []
    for i, parent in enumerate(table.parents):
        placed = times(joints[parent] if parent >= 0 else None, table.placements[i])
        values = values_of(table, i, q)
        joints.append(times(placed, motion(int(table.kinds[i]), exactly(table.axes[i]), values)))
    return np.array(
        [
            times(joints[joint] if joint >= 0 else None, placement)
            for joint, placement in zip(table.link_joints, table.link_placements, strict=True)
        ]
    )


def times(parent, placement):
    """parent * placement, both (3, 4); None is the world."""
    placement = exactly(placement)
    if parent is None:
        return placement
    out = parent[:, :3] @ placement
    out[:, 3] += parent[:, 3]
    return out


def values_of(table, joint, q):
    rows = zip(table.columns[joint], table.multipliers[joint], table.offsets[joint], strict=True)
    one = CONTEXT.mpf
    return [one(o) if c < 0 else one(m) * one(q[c]) + one(o) for c, m, o in rows]


def motion(kind, axis, v):
    """(3, 4) motion of a joint; kinds as in cpp/robots/kinematics.hpp."""
    if kind <= 3:
        return fixed(turn(axis if kind == 3 else unit(kind), CONTEXT.cos(v[0]), CONTEXT.sin(v[0])))
    if kind <= 7:
        return fixed(turn(axis if kind == 7 else unit(kind - 4), v[0], v[1]))
    if kind == 8:
        return fixed(unit(None), axis * v[0])
    if kind == 9:
        return fixed(turn(unit(2), v[2], v[3]), [v[0], v[1], CONTEXT.mpf(0)])
    return fixed(quaternion(*v[:4])) if kind == 10 else fixed(quaternion(*v[3:7]), v[:3])


def unit(axis):
    eye = exactly(np.eye(3))
    return eye if axis is None else eye[axis]


def fixed(rotation, shift=(0, 0, 0)):
    return np.column_stack([rotation, exactly(np.array(shift, dtype=object))])


def turn(a, c, s):
    """Rodrigues' formula with the axis as it is."""
    cross = np.array([[0 * s, -a[2], a[1]], [a[2], 0 * s, -a[0]], [-a[1], a[0], 0 * s]])
    return unit(None) * c + (1 - c) * np.outer(a, a) + s * cross


def quaternion(x, y, z, w):
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def composed(links, placements):
    """Bodies on links (n, 3, 4) each, in doubles, by the operations of checker.cpp's compose in their order."""
    a, b, c = (links[:, :, k, None] * placements[:, None, k] for k in range(3))
    out = (a + b) + c
    out[..., 3] += links[..., 3]
    return out


@functools.cache
def vertices_of(shape):
    """What a pose maps of a shape; of cylinders and cones what bounds any polytope around them."""
    if isinstance(shape, Cylinder | Cone):
        return radius_of(shape) * np.concatenate([np.eye(3), -np.eye(3)])
    return inflated_hull(shape)[0]


def deviation(table, kernel, bodies, links, q):
    """Largest distance, in m, of a body's vertex from where exact kinematics puts it, over configurations (n, nq)."""
    placements = np.array([b.pose[:3] for b in bodies])
    poses = kernel.link_poses(q, np.ones(kernel.link_count, dtype=np.uint8))[:, links, :3]
    worst = 0.0
    for row, computed in zip(q, poses, strict=True):
        exact = [times(link, p) for link, p in zip(link_poses(table, row)[links], placements, strict=True)]
        errors = rounded(exactly(composed(computed, placements)) - np.array(exact)).astype(float)
        worst = max(worst, *map(largest_shift, bodies, errors))
    return worst


def largest_shift(body, error):
    """Largest length, in m, of error * vertex for an error (3, 4) of a body's pose."""
    return float(np.linalg.norm(vertices_of(body.shape) @ error[:, :3].T + error[:, 3], axis=1).max())


def deviation_of_robot(robot, q):
    """`deviation` of all collision bodies of a robot."""
    links = [robot.link_index(body.link) for body in robot.bodies]
    return deviation(table_of(robot), robot.kinematics, robot.bodies, links, q)
