"""Signed distances in 113 bits by brute force: signed_distance_oracle.cpp, compiled where it is first asked for.

In: vertices (n, 3) in metres of two convex bodies of any dimension, inflation radii, poses. Out: signed distances as
sums of two doubles. It takes hulls from SciPy, and shares no code with the core.
"""

import ctypes
import subprocess
import tempfile
from functools import cache
from itertools import combinations
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull

from plannercheck.bodies import exact_reference as exact

_SOURCE = Path(__file__).with_suffix(".cpp")


class _Body(ctypes.Structure):
    _fields_ = [
        ("vertices", ctypes.c_void_p),
        ("count", ctypes.c_int32),
        ("triangles", ctypes.c_void_p),
        ("triangle_count", ctypes.c_int32),
        ("edges", ctypes.c_void_p),
        ("edge_count", ctypes.c_int32),
    ]


class OracleBody:
    """A body whose triangles and edges the oracle tries.

    Attributes:
        vertices: (n, 3) m.
        inflation_radius: In m.
    """

    def __init__(self, vertices, inflation_radius=0.0):
        self.vertices = np.ascontiguousarray(vertices, dtype=np.float64)
        self.inflation_radius = inflation_radius
        spread = self.vertices - self.vertices[0]
        rank = np.linalg.matrix_rank(spread, tol=1e-9 * max(np.abs(spread).max(), 1e-300))
        self._triangles, self._edges = _solid_features(self.vertices) if rank == 3 else _all_features(len(vertices))
        self._triangles = np.ascontiguousarray(self._triangles, dtype=np.int32)
        self._edges = np.ascontiguousarray(self._edges, dtype=np.int32)
        arrays = (self.vertices, self._triangles, self._edges)
        self.given = _Body(*(value for a in arrays for value in (a.ctypes.data, len(a))))


def _solid_features(vertices):
    """Triangles of the hull, and edges with the triangles on both sides."""
    hull = ConvexHull(vertices)
    triangles = hull.simplices.copy()
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    inward = (np.cross(b - a, c - a) * hull.equations[:, :3]).sum(axis=1) < 0
    triangles[inward, 1:] = triangles[inward, :0:-1]
    sides = {}
    for t, corners in enumerate(triangles.tolist()):
        for edge in combinations(sorted(corners), 2):
            sides.setdefault(edge, []).append(t)
    return triangles, [(*edge, *found) for edge, found in sides.items()]


def _all_features(n):
    """Of bodies without volume: any three vertices, and each pair with an arc that is unknown."""
    return np.array(list(combinations(range(n), 3)), dtype=np.int32).reshape(-1, 3), np.array(
        [(i, j, -1, -1) for i, j in combinations(range(n), 2)], dtype=np.int32
    ).reshape(-1, 4)


def signed_distances(first, second, poses_p, poses_r):
    """(n,) two doubles each: what their sum is, up to 1e-28 of the size.

    Where 113 bits leave a distance open, it is that of `exact_reference`, in Python integers.
    """
    high, low = _in_113_bits(first, second, poses_p, poses_r, overlap=False)
    for k in np.flatnonzero(np.isnan(high)):
        distance = exact.distance(first.vertices, second.vertices, poses_p[k], poses_r[k])
        if distance > 0:
            high[k], low[k] = distance, 0.0
            for body in (first, second):
                high[k], low[k] = _two_sum(high[k], low[k] - body.inflation_radius)
        else:
            high[k : k + 1], low[k : k + 1] = _in_113_bits(
                first, second, poses_p[k : k + 1], poses_r[k : k + 1], overlap=True
            )
    return high, low


def _two_sum(a, b):
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def _in_113_bits(first, second, poses_p, poses_r, overlap):
    poses = [np.ascontiguousarray(poses, dtype=np.float64) for poses in (poses_p, poses_r)]
    high, low = np.zeros(len(poses_p)), np.zeros(len(poses_p))
    radii = np.array([first.inflation_radius, second.inflation_radius])
    addresses = [ctypes.c_void_p(a.ctypes.data) for a in (*poses, radii)]
    bodies = [ctypes.byref(body.given) for body in (first, second)]
    found = [ctypes.c_void_p(a.ctypes.data) for a in (high, low)]
    _compiled().signed_distances(*bodies, ctypes.c_int64(len(high)), *addresses, ctypes.c_bool(overlap), *found)
    return high, low


@cache
def _compiled():
    folder = Path(tempfile.mkdtemp(prefix="signed_distance_oracle"))
    library = folder / "oracle.so"
    command = ["g++", "-std=gnu++20", "-O2", "-shared", "-fPIC", "-o", str(library), str(_SOURCE)]
    subprocess.run(command, check=True)
    return ctypes.CDLL(str(library))
