"""Planar motions, and where bodies are on the way, by shapely.

In: a checker, a seed. Out: motions q0 to q1 (n, nq) from valid states; their states (k, nq), polygons, distances, m.
"""

import numpy as np
import shapely

import plannercheck as pc

P = pc.planar
KINDS = [("straight", None), ("dubins", 1.5), ("reeds_shepp", 2.5)]
TOLERANCE = 1e-4


def curve_of(kind):
    return {"curve": kind[0], "turning_radius": kind[1]}


def arm():
    """Three links on a fixed foot."""
    return P.Robot(
        [
            P.Link("foot", [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]], anchor=(-1.5, -1, 0.3)),
            P.Link("upper", [[0, -0.05], [1, -0.05], [1, 0.05], [0, 0.05]], "foot", joint="revolute", limits=(-4, 4)),
            P.Link("bend", [[0, 0], [0.3, 0]], "upper", (1, 0, 0.5)),
            P.Link("lower", [[0, 0], [1, 0]], "bend", (0.3, 0, 0), "revolute", (-3, 3)),
        ],
        name="arm",
    )


def motions(checker, n, seed, scale=1.0):
    """Motions from valid states, lengths of some metres and radians: (n, nq) to (n, nq)."""
    generator = np.random.default_rng(seed)
    q = checker.robot.random_configurations(30 * n, generator)
    starts = q[checker.check_states(q)][:n]
    ways = generator.normal(size=starts.shape) * generator.uniform(0.05, scale, (len(starts), 1))
    return starts, starts + ways * np.where(np.arange(starts.shape[1]) < 2, 2.0, 0.7)


def states_of(checker, q0, q1, parameters, kind):
    """States of a motion as the certifier has them."""
    (start,), (end,), _ = checker._motion_ends(q0[None], q1[None], kind[0])
    return checker.motion_certifier.states(start, end, parameters, checker._motions.pieces(start, end, *kind))


def posed(checker, body, states):
    """(k, n, 2): vertices of a body in the world at states (k, nq)."""
    poses = checker.body_poses(states)[:, body]
    return checker.bodies[body].vertices @ poses[:, :2, :2].transpose(0, 2, 1) + poses[:, None, :2, 2]


def clearances(checker, states):
    """(k,) m: least distance of all pairs by shapely, 0 where they touch."""
    least = np.full(len(states), np.inf)
    made = {1: lambda v: shapely.points(v[:, 0]), 2: shapely.linestrings}
    shapes = [
        made.get(len(body.vertices), lambda v: shapely.convex_hull(shapely.multipoints(v)))(posed(checker, k, states))
        for k, body in enumerate(checker.bodies)
    ]
    for a, b in checker.pairs.tolist():
        least = np.minimum(least, shapely.distance(shapes[a], shapes[b]))
    return least
