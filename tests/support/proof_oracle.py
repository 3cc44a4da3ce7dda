"""What a proof in space claims, seen in doubles at sampled states: an oracle that shares nothing with the verifier.

A claim counts as false where a sampled state contradicts it by more than rounding; nothing is proved by it.
"""

import numpy as np
import pinocchio as pin

# What sampled gaps may be off by, m.
ROUNDING = 1e-10


def states(proof, parameters):
    """(k, columns) on the motion, by Pinocchio's exponentials and logarithms."""
    start, end = np.array(proof.motion.start), np.array(proof.motion.end)
    q = start + np.asarray(parameters)[:, None] * (end - start)
    for joint in proof.model.joints:
        columns = list(joint.columns)
        if columns[0] >= 0 and joint.kind in ("circle", "planar", "ball", "free"):
            first, last = (placed(joint.kind, values[columns]) for values in (start, end))
            twist = pin.log6(first.actInv(last))
            for row, t in zip(q, parameters, strict=True):
                row[columns] = numbers(joint.kind, first * pin.exp6(pin.Motion(t * twist.vector)))
    return q


def placed(kind, x):
    """The pose of a joint of several numbers."""
    if kind == "circle":
        return pin.SE3(pin.exp3(np.array([0, 0, np.arctan2(x[1], x[0])])), np.zeros(3))
    if kind == "planar":
        return pin.SE3(pin.exp3(np.array([0, 0, np.arctan2(x[3], x[2])])), np.array([x[0], x[1], 0]))
    quaternion = pin.Quaternion(np.array(x[-4:]))
    quaternion.normalize()
    return pin.SE3(quaternion.matrix(), np.array(x[:3]) if kind == "free" else np.zeros(3))


def numbers(kind, pose):
    """The numbers of a joint with this pose."""
    turn = [pose.rotation[0, 0], pose.rotation[1, 0]]
    if kind == "circle":
        return turn
    if kind == "planar":
        return [*pose.translation[:2], *turn]
    quaternion = pin.Quaternion(pose.rotation).coeffs()
    return [*pose.translation, *quaternion] if kind == "free" else quaternion


def joint_pose(joint, q):
    """4 x 4 of a joint on its parent."""
    values = [o if c < 0 else m * q[c] + o for c, m, o in zip(*numbers_of(joint), strict=True)]
    axis, out = np.array(joint.axis), np.eye(4)
    if joint.kind == "slide":
        out[:3, 3] = axis * values[0]
    elif joint.kind in ("turn", "circle"):
        c, s = (np.cos(values[0]), np.sin(values[0])) if joint.kind == "turn" else values
        out[:3, :3] = c * np.eye(3) + (1 - c) * np.outer(axis, axis) + s * pin.skew(axis)
    else:
        out = placed(joint.kind, values).homogeneous
    return affine(joint.placement) @ out


def numbers_of(joint):
    return joint.columns, joint.multipliers, joint.offsets


def affine(rows):
    return np.vstack([np.reshape(rows, (3, 4)), [0, 0, 0, 1]])


def link_poses(model, q):
    """(links + 1, 4, 4) at one configuration; the last is the world's."""
    joints = []
    for joint in model.joints:
        above = joints[joint.parent] if joint.parent >= 0 else np.eye(4)
        joints.append(above @ joint_pose(joint, q))
    on = [(joints[link.joint] if link.joint >= 0 else np.eye(4)) @ affine(link.placement) for link in model.links]
    return np.array([*on, np.eye(4)])


def gap(proof, entry, poses):
    """How far apart an entry says that its pair is, at one state, m, radii taken off."""
    a, b = (proof.model.bodies[k] for k in proof.model.pairs[entry.pair])
    in_world = [poses[body.link] @ affine(body.pose) for body in (a, b)]
    if entry.by == "balls":
        centres = [pose[:3, :3] @ body.centre + pose[:3, 3] for pose, body in zip(in_world, (a, b), strict=True)]
        return np.linalg.norm(centres[0] - centres[1]) - a.reach - b.reach - a.radius - b.radius
    normal = poses[entry.frame][:3, :3] @ entry.direction
    length = np.linalg.norm(normal)
    if not length > 0:
        return -np.inf
    heights = [
        (body.vertices @ pose[:3, :3].T + pose[:3, 3]) @ normal / length
        for pose, body in zip(in_world, (a, b), strict=True)
    ]
    return heights[0].min() - heights[1].max() - a.radius - b.radius


def holds_all(proof, body):
    """Whether a body's ball holds its vertices."""
    body = proof.model.bodies[body]
    return np.linalg.norm(body.vertices - np.array(body.centre), axis=1).max() <= body.reach + ROUNDING


def is_false(proof, samples=5, only=None):
    """Whether some entry is contradicted at a sampled state."""
    known = {}
    for entry in proof.entries if only is None else [proof.entries[k] for k in only]:
        if entry.by == "balls" and not all(holds_all(proof, body) for body in proof.model.pairs[entry.pair]):
            return True
        span = entry.start, entry.end
        if span not in known:
            known[span] = [link_poses(proof.model, q) for q in states(proof, np.linspace(*span, samples))]
        if any(gap(proof, entry, poses) < proof.margin - ROUNDING for poses in known[span]):
            return True
    return False
