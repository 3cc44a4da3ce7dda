"""Signed distances of bodies that are unions of convex parts, by brute force: all pairs of parts in 113 bits.

In: two prepared bodies. Out: their signed distances at poses, as doubles; where they overlap both have to be hulls.
"""

import numpy as np
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
