"""Pairs of polytopes in any dimension, random and near contact, and a linear program to judge them.

Near contact: the second body is moved along a direction u so that the bodies' supports along u meet up to a chosen gap,
and u is made a direction in which they truly touch: a facet normal of the first body, or a vertex against a vertex.
"""

import itertools
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import block_diag
from scipy.spatial import ConvexHull
from scipy.stats import ortho_group

from plannercheck import ndim

NEAR_GAPS = (0.0, 1e-16, -1e-16, 1e-15, -1e-15, 1e-14, -1e-13, 1e-12, -1e-10, 1e-9, -1e-7, 1e-6, -1e-4, 1e-3)


@dataclass
class Body:
    """Points, and the same body as the library takes it: by points or by the halfspaces of their hull."""

    points: np.ndarray
    polytope: ndim.Polytope


def random_body(rng, d, most=8, kinds=("points", "halfspaces")):
    """A random body: round, a box, a cross, on a lattice, flat or thin."""
    shape = rng.choice(["round", "cloud", "box", "cross", "lattice", "thin"])
    n = int(rng.integers(d + 1, d + most))
    if shape == "round":
        points = rng.normal(size=(n, d))
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    elif shape == "box" and d <= 4:
        points = np.array(np.meshgrid(*[[-1.0, 1.0]] * d)).reshape(d, -1).T * rng.uniform(0.2, 1.0, size=d)
    elif shape == "cross":
        points = np.concatenate([np.eye(d), -np.eye(d)]) * rng.uniform(0.5, 1.5)
    elif shape == "lattice":
        points = rng.integers(-2, 3, size=(n + d, d)) / 2.0
    else:
        points = rng.normal(size=(n, d))
        if shape == "thin":
            points[:, 0] *= 1e-3
    kind = rng.choice(kinds)
    hull = _hull(points)
    if hull is None or kind == "points":
        return Body(points, ndim.Polytope(points))
    return Body(points, ndim.Polytope.from_halfspaces(hull.equations[:, :-1], -hull.equations[:, -1]))


def _hull(points):
    try:
        return ConvexHull(points)
    except Exception:  # flat
        return None


def random_pose(rng, d, distance, affine=False):
    """A rotation, or any affine map, and a translation."""
    matrix = ortho_group.rvs(d, random_state=rng)
    if affine:
        matrix = matrix @ np.diag(rng.uniform(0.3, 2.0, size=d)) @ ortho_group.rvs(d, random_state=rng)
    shift = rng.normal(size=d)
    return matrix, distance * shift / np.linalg.norm(shift)


def near_poses(rng, first, second, d):
    """Poses at which the bodies touch up to a small gap."""
    matrix_p, shift_p = random_pose(rng, d, 1.0)
    matrix_r, _ = random_pose(rng, d, 1.0)
    if rng.random() < 0.3:
        matrix_p = matrix_r = np.eye(d)
    p, r = first.points @ matrix_p.T + shift_p, second.points @ matrix_r.T
    hull = _hull(p)
    if hull is not None and rng.random() < 0.8:
        u = -hull.equations[rng.integers(len(hull.equations)), :-1]
    else:
        u = rng.normal(size=d)
        u /= np.linalg.norm(u)
    # The first body's lowest point along u, and the second's highest, meet.
    low, high = p[(p @ u).argmin()], r[(r @ u).argmax()]
    if hull is not None:
        on_facet = np.flatnonzero(p @ u <= (p @ u).min() + 1e-9)
        weights = rng.dirichlet(np.ones(len(on_facet)))
        low = weights @ p[on_facet]
    shift_r = low - high - float(rng.choice(NEAR_GAPS)) * u
    return (matrix_p, shift_p), (matrix_r, shift_r)


@dataclass
class Program:
    """A linear program in inequality and equality form; `depth_of` says which unknown is maximised."""

    cost: np.ndarray
    upper: np.ndarray
    upper_b: np.ndarray
    equal: np.ndarray
    equal_b: np.ndarray
    least: np.ndarray
    depth_of: int


def depth(first, second, pose_p, pose_r):
    """By a linear program: clearly positive if the bodies overlap, clearly negative if they are apart.

    Two bodies of points: the largest least weight of mixtures of all vertices that are the same point. Else: how deep
    a point of both can be inside the halfspaces.
    """
    return depths([depth_program(first, second, pose_p, pose_r)])[0]


def depths(programs):
    """The depths of several programs, solved as one whose blocks have nothing to do with each other: that saves time.

    0 where a program has no solution.
    """
    answer = linprog(
        np.concatenate([p.cost for p in programs]),
        A_ub=block_diag([p.upper for p in programs], format="csc"),
        b_ub=np.concatenate([p.upper_b for p in programs]),
        A_eq=block_diag([p.equal for p in programs], format="csc"),
        b_eq=np.concatenate([p.equal_b for p in programs]),
        bounds=[(low if np.isfinite(low) else None, None) for p in programs for low in p.least],
        method="highs",
    )
    if answer.status == 0:
        starts = np.cumsum([0, *(len(p.cost) for p in programs)])
        return [float(answer.x[start + p.depth_of]) for start, p in zip(starts, programs, strict=False)]
    return [0.0] if len(programs) == 1 else [depth for p in programs for depth in depths([p])]


def depth_program(first, second, pose_p, pose_r):
    """The program of `depth`."""
    d = first.polytope.dimension
    blocks = [_unknowns(body.polytope, pose) for body, pose in ((first, pose_p), (second, pose_r))]
    counts = [0 if b[0] is None else len(b[0]) for b in blocks]
    width = d + 1 + sum(counts)
    both_points = all(b[0] is not None for b in blocks)
    upper, upper_b, column = [], [], d + 1
    equal, equal_b = [np.zeros((0, width))], [np.zeros(0)]
    for points, normals, offsets in blocks:
        if points is None:
            sizes = np.linalg.norm(normals, axis=1)
            rows = np.zeros((len(normals), width))
            rows[:, :d], rows[:, d] = normals / sizes[:, None], 1.0
            upper.append(rows)
            upper_b.append(offsets / sizes)
            continue
        rows = np.zeros((d + 1, width))
        rows[:d, :d] = -np.eye(d)
        rows[:d, column : column + len(points)] = points.T
        rows[d, column : column + len(points)] = 1.0
        equal.append(rows)
        equal_b.append(np.append(np.zeros(d), 1.0))
        if both_points:
            rows = np.zeros((len(points), width))
            rows[:, d] = 1.0
            rows[:, column : column + len(points)] = -np.eye(len(points))
            upper.append(rows)
            upper_b.append(np.zeros(len(points)))
        column += len(points)
    cost = np.zeros(width)
    cost[d] = -1.0
    least = np.full(width, -np.inf)
    if not both_points:
        least[d + 1 :] = 0.0
    return Program(*map(np.concatenate, ([cost], upper, upper_b, equal, equal_b, [least])), d)


def _unknowns(polytope, pose):
    matrix, shift = (np.eye(polytope.dimension), np.zeros(polytope.dimension)) if pose is None else pose
    if polytope.vertices is not None:
        return polytope.vertices @ matrix.T + shift, None, None
    normals = polytope.normals @ np.linalg.inv(matrix)
    return None, normals, polytope.offsets + normals @ shift


def box(low, high):
    return np.array(list(itertools.product(*zip(low, high, strict=True))), dtype=np.float64)


def box_halfspaces(low, high):
    d = len(low)
    return np.concatenate([np.eye(d), -np.eye(d)]), np.concatenate([high, -np.asarray(low)])


def both_kinds(low, high):
    return ndim.Polytope(box(low, high)), ndim.Polytope.from_halfspaces(*box_halfspaces(low, high))
