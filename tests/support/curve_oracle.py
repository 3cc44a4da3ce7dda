"""Curves and tubes of proofs at 60 digits: where bodies are, written with nothing of plannercheck.

In: a proof in space. Out: world points of its bodies at a parameter, the numbers changed by given offsets; and the
least gap along an entry's direction over parameters and corners of the tube.
"""

import itertools
from dataclasses import replace

import mpmath
import numpy as np
from proof_cases import claim

from plannercheck.proofs import Motion

mpmath.mp.dps = 60


def curve(joints, bodies, control, entries, tube=(), path="screw", **options):
    """A proof of a motion along control points (degree + 1, columns)."""
    rows = [tuple(map(float, row)) for row in control]
    proof = claim(joints, bodies, rows[0], rows[-1], entries, **options)
    inner = tuple(x for row in rows[1:-1] for x in row)
    return replace(proof, motion=Motion(rows[0], rows[-1], rows[-1], path, inner, tuple(map(float, tube))))


def value(control, t):
    """A polynomial by its Bernstein coefficients."""
    n = len(control) - 1
    return mpmath.fsum(
        mpmath.binomial(n, k) * mpmath.mpf(t) ** k * (1 - mpmath.mpf(t)) ** (n - k) * mpmath.mpf(c)
        for k, c in enumerate(control)
    )


def state(proof, t, offsets=None):
    """The numbers at a parameter; quaternions by slerp."""
    motion, t = proof.motion, mpmath.mpf(t)
    width = len(motion.start)
    inner = [motion.inner[k : k + width] for k in range(0, len(motion.inner), width)]
    rows = [motion.start, *inner, motion.end]
    q = [value([row[c] for row in rows], t) for c in range(width)]
    for joint in proof.model.joints:
        if joint.kind == "free":
            first = joint.columns[3]
            q[first : first + 4] = slerp(*(row[first : first + 4] for row in (motion.start, motion.end)), t)
    return [x + mpmath.mpf(float(e)) for x, e in zip(q, offsets if offsets is not None else [0] * width, strict=True)]


def slerp(a, b, t):
    a, b = ([mpmath.mpf(x) / mpmath.sqrt(mpmath.fsum(mpmath.mpf(y) ** 2 for y in q)) for x in q] for q in (a, b))
    dot = mpmath.fsum(x * y for x, y in zip(a, b, strict=True))
    if dot < 0:
        b, dot = [-x for x in b], -dot
    angle = mpmath.acos(min(dot, mpmath.mpf(1)))
    if angle == 0:
        return a
    first, second = mpmath.sin((1 - t) * angle), mpmath.sin(t * angle)
    return [(first * x + second * y) / mpmath.sin(angle) for x, y in zip(a, b, strict=True)]


def affine(rows):
    return mpmath.matrix([list(rows[0:4]), list(rows[4:8]), list(rows[8:12]), [0, 0, 0, 1]])


def joint_map(joint, q):
    values = [
        mpmath.mpf(o) if c < 0 else mpmath.mpf(m) * q[c] + mpmath.mpf(o)
        for c, m, o in zip(joint.columns, joint.multipliers, joint.offsets, strict=True)
    ]
    out = mpmath.eye(4)
    if joint.kind == "turn":
        a = [mpmath.mpf(x) for x in joint.axis]
        c, s = mpmath.cos(values[0]), mpmath.sin(values[0])
        cross = [[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]]
        for i, j in itertools.product(range(3), range(3)):
            out[i, j] = c * (i == j) + (1 - c) * a[i] * a[j] + s * cross[i][j]
    elif joint.kind == "slide":
        for i in range(3):
            out[i, 3] = values[0] * mpmath.mpf(joint.axis[i])
    elif joint.kind == "free":
        x, y, z, w = values[3:]
        rows = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), values[0]],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), values[1]],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), values[2]],
            [0, 0, 0, 1],
        ]
        out = mpmath.matrix(rows)
    else:
        raise KeyError(joint.kind)
    return affine(joint.placement) * out


def link_maps(proof, q):
    """World maps of all links; the last is the world's."""
    joints = []
    for joint in proof.model.joints:
        above = joints[joint.parent] if joint.parent >= 0 else mpmath.eye(4)
        joints.append(above * joint_map(joint, q))
    on = [
        (joints[link.joint] if link.joint >= 0 else mpmath.eye(4)) * affine(link.placement)
        for link in proof.model.links
    ]
    return [*on, mpmath.eye(4)]


def points(proof, body, maps):
    """World points of a body's vertices."""
    own = proof.model.bodies[body]
    pose = maps[own.link] * affine(own.pose)
    return [pose * mpmath.matrix([*map(float, v), 1]) for v in own.vertices.reshape(-1, 3)]


def seen(proof, t, offsets=None):
    """By frame, -1 for the world, and body: points in doubles."""
    maps = link_maps(proof, state(proof, t, offsets))
    world = [
        np.array([[float(x) for x in p[:3]] for p in points(proof, k, maps)]) for k in range(len(proof.model.bodies))
    ]
    frames = {k: np.array(maps[k].tolist(), dtype=float) for k in range(-1, len(maps) - 1)}
    return {k: [(own - m[:3, 3]) @ m[:3, :3] for own in world] for k, m in frames.items()}


def corners(tube, count, generator):
    """Offsets: the tube's corners, at most `count` of them drawn, and none."""
    if not any(tube):
        return [[0.0] * len(tube)]
    signs = list(itertools.product((-1, 1), repeat=len(tube)))
    chosen = generator.permutation(len(signs))[:count]
    return [[0.0] * len(tube), *([s * w for s, w in zip(signs[k], tube, strict=True)] for k in chosen)]


def gap(proof, entry, maps):
    """How far the pair is apart along a plane's direction, radii taken off."""
    a, b = proof.model.pairs[entry.pair]
    frame = maps[entry.frame]
    normal = [mpmath.fsum(frame[i, j] * mpmath.mpf(entry.direction[j]) for j in range(3)) for i in range(3)]
    length = mpmath.sqrt(mpmath.fsum(x * x for x in normal))
    low, high = (
        [mpmath.fsum(normal[i] * p[i] for i in range(3)) / length for p in points(proof, body, maps)] for body in (a, b)
    )
    return min(low) - max(high) - proof.model.bodies[a].radius - proof.model.bodies[b].radius


def least_gap(proof, samples=9, count=8, seed=0):
    """The least gap over entries by planes, parameters of each and corners of the tube, m."""
    generator = np.random.default_rng(seed)
    offsets = corners(proof.motion.tube or (0.0,) * len(proof.motion.start), count, generator)
    found = [
        gap(proof, entry, link_maps(proof, state(proof, t, offset)))
        for entry in proof.entries
        for t in np.linspace(entry.start, entry.end, samples).tolist()
        for offset in offsets
    ]
    return min(found)
