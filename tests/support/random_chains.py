"""Random tables of joints in a row, of the kinds that cpp/robots/kinematics.hpp numbers, and configurations of them."""

import numpy as np

from plannercheck.robots.kinematics import JointTable

# By kind, which of a joint's seven numbers are a cosine and a sine or a quaternion.
UNIT_PARTS = {4: (0, 2), 5: (0, 2), 6: (0, 2), 7: (0, 2), 9: (2, 4), 10: (0, 4), 11: (3, 7)}


def random_placement(rng):
    """A rotation, half the time about one axis or by right angles, and a shift of up to 1 m."""
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    if rng.random() < 0.5:
        angle = rng.choice([np.pi / 2, np.pi, rng.uniform(-3, 3)])
        c, s = np.cos(angle), np.sin(angle)
        rotation = np.roll([[1, 0, 0], [0, c, -s], [0, s, c]], rng.integers(3), axis=(0, 1))
    shift = rng.uniform(-1, 1, 3) * rng.integers(0, 2, 3)
    return np.column_stack([rotation * np.sign(np.linalg.det(rotation)), shift])


def random_axis(rng, kind):
    axis = rng.normal(size=3) if rng.random() < 0.7 else np.eye(3)[rng.integers(3)]
    return axis / np.linalg.norm(axis) if kind in (3, 7, 8) else np.zeros(3)


def random_chain(rng, kinds, held=0.2, mimics=0.3):
    """A table of joints in a row, one link on each; some held, some values with a multiplier and an offset."""
    n = len(kinds)
    columns = np.arange(7 * n, dtype=np.int32).reshape(n, 7)
    multipliers, offsets = np.ones((n, 7)), np.zeros((n, 7))
    for i, kind in enumerate(kinds):
        if kind in UNIT_PARTS:
            continue
        if rng.random() < held:
            columns[i], multipliers[i], offsets[i] = -1, 0.0, rng.uniform(-1, 1, 7)
        elif rng.random() < mimics:
            multipliers[i], offsets[i] = rng.uniform(-3, 3, 7), rng.uniform(-1, 1, 7)
    return JointTable(
        7 * n,
        np.arange(-1, n - 1, dtype=np.int32),
        np.array(kinds, dtype=np.int32),
        np.array([random_axis(rng, kind) for kind in kinds]),
        np.array([random_placement(rng) for _ in kinds]),
        columns,
        multipliers,
        offsets,
        np.arange(n, dtype=np.int32),
        np.array([random_placement(rng) for _ in kinds]),
    )


def random_rows(rng, kinds, n):
    q = rng.uniform(-2, 2, (n, len(kinds), 7))
    for i, kind in enumerate(kinds):
        start, stop = UNIT_PARTS.get(kind, (0, 0))
        length = np.linalg.norm(q[:, i, start:stop], axis=1, keepdims=True)
        q[:, i, start:stop] /= np.where(length > 0, length, 1) * rng.uniform(1 - 1e-7, 1 + 1e-7)
    return q.reshape(n, -1)
