"""Signed distances of bodies that are unions of convex parts, by brute force: all pairs of parts in 113 bits.

In: two prepared bodies. Out: their signed distances at poses, as doubles; where they overlap both have to be hulls. The
depth of two unions of hulls is the distance of the origin from the complement of the union of all pairs' differences:
`DifferenceOracle` estimates it by many translations, in doubles.
"""

import itertools

import numpy as np
from scipy.spatial import ConvexHull
from signed_distance_oracle import OracleBody, signed_distances


def parts_of(body):
    """The convex parts of a body: triangles, balls, cells, prisms, or the hull itself."""
    radius = body.inflation_radius
    if body.solid is not None:
        corners = body.solid.points()[body.solid.triangles()]
        return [OracleBody(each, radius) for each in corners]
    if body.parts is not None:
        places = [body.parts.part(place) for place in range(body.parts.places)]
        return [OracleBody(corners, radius + more) for corners, more, _ in places if len(corners)]
    return [OracleBody(body.vertices, radius)]


class PartOracle:
    """All pairs of the parts of two bodies."""

    def __init__(self, first, second):
        self.parts = [parts_of(first), parts_of(second)]
        self._balls = [
            (np.array([p.vertices.mean(axis=0) for p in parts]), np.array([_radius(p) for p in parts]))
            for parts in self.parts
        ]

    def near(self, poses, room):
        """Pairs of places of parts whose balls are no further apart than two parts are, and some room, m."""
        (a, r), (b, s) = self._balls
        a, b = (points @ pose[:3, :3].T + pose[:3, 3] for points, pose in zip((a, b), poses, strict=True))
        between = np.linalg.norm(a[:, None] - b, axis=2)
        first = np.unravel_index(between.argmin(), between.shape)
        least = self.of_parts(*first, *(pose[None] for pose in poses))[0]
        return np.argwhere(between - r[:, None] - s <= least + room)

    def nearest(self, poses):
        """The pairs of places of parts that are nearest at poses (2, 4, 4), up to rounding."""
        pairs = self.near(poses, 1e-6)
        found = np.array([self.of_parts(i, j, *(pose[None] for pose in poses))[0] for i, j in pairs])
        return pairs[found <= found.min() + 1e-13]

    def of_parts(self, i, j, poses_p, poses_r):
        """(n,) of one part of each body."""
        return signed_distances(self.parts[0][i], self.parts[1][j], poses_p, poses_r)[0]

    def distances(self, poses_p, poses_r):
        """(n,) at poses (n, 4, 4) that are within a millimetre of the first ones."""
        pairs = self.near((poses_p[0], poses_r[0]), 4e-3)
        return np.min([self.of_parts(i, j, poses_p, poses_r) for i, j in pairs], axis=0)


def _radius(part):
    return np.linalg.norm(part.vertices - part.vertices.mean(axis=0), axis=1).max() + part.inflation_radius


class DifferenceOracle:
    """Translations of one union of hulls that part it from another one, by the hulls of all differences of vertices."""

    def __init__(self, hulls_p, hulls_r):
        """Of vertices (n, 3) of hulls in the world, m."""
        self.facets = [
            ConvexHull((r[:, None] - p).reshape(-1, 3)).equations for p, r in itertools.product(hulls_p, hulls_r)
        ]

    def exits(self, directions):
        """(n,) how far the first union has to go along unit vectors (n, 3) until it shares only the boundary, m."""
        ends = np.array([_between(facets, directions) for facets in self.facets])
        reached = np.zeros(len(directions))
        for _ in self.facets:
            reached = np.where(ends[:, 0] <= reached, np.maximum(ends[:, 1], reached), reached).max(axis=0)
        return reached

    def depth_estimate(self, directions):
        """An upper estimate of the depth, m: along directions, and those of all facets, then around the best ones."""
        normals = np.concatenate([facets[:, :3] for facets in self.facets])
        tried = np.concatenate([directions, np.unique(normals.round(9), axis=0)])
        for spread in (0.1, 0.02, 4e-3, 1e-3):
            exits = self.exits(tried)
            best = tried[np.argsort(exits)[:10]]
            tried = np.concatenate([best, (best + spread * directions[:50, None]).reshape(-1, 3)])
            tried /= np.linalg.norm(tried, axis=1)[:, None]
        return self.exits(tried).min()


def _between(facets, directions):
    """(2, n) the first and last place on rays from the origin that is in a hull; the first beyond the last if none."""
    slopes, offsets = facets[:, :3] @ directions.T, facets[:, 3, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        places = -offsets / slopes
    last = np.where(slopes > 0, places, np.inf).min(axis=0)
    first = np.where(slopes < 0, places, -np.inf).max(axis=0)
    outside = ((slopes == 0) & (offsets > 0)).any(axis=0) | (first >= last)
    return np.where(outside, [[np.inf], [-np.inf]], [first, last])
