"""What a depth camera gets wrong: noise, pixels that see nothing, and points in the air at edges.

In: a true depth image, m. Out: the image as a camera would give it. Noise grows with the square of the depth (Nguyen,
Izadi and Lovell, "Modeling Kinect sensor noise for improved 3D reconstruction and tracking", 2012).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plannercheck.common.array_types import Bools, Floats


@dataclass(frozen=True)
class DepthNoise:
    """How much a camera gets wrong.

    Attributes:
        least: Standard deviation of a near pixel's depth, m.
        growth: What is added to it at twice the nearest usual depth and so on: growth (z - 0.4 m)², 1/m.
        dropouts: Part of the pixels that see nothing.
        flying: Part of the pixels at an edge that see a point between what is before and what is behind; 0 as behind
            the filters of the cameras' drivers.
        step: Depths are multiples of this, m; 0 for none.
    """

    least: float = 0.0012
    growth: float = 0.0019
    dropouts: float = 0.02
    flying: float = 0.0
    step: float = 0.001

    def of(self, depth: Floats, rng: np.random.Generator) -> Floats:
        """The image (height, width), m, as such a camera gives it."""
        seen = depth > 0
        shown = np.where(_at_edges(depth) & (rng.random(depth.shape) < self.flying), _between(depth, rng), depth)
        shown = shown + (self.least + self.growth * (shown - _USUAL) ** 2) * rng.normal(size=depth.shape)
        if self.step > 0:
            shown = np.round(shown / self.step) * self.step
        return np.where(seen & (rng.random(depth.shape) >= self.dropouts), np.maximum(shown, 0.0), 0.0)


# The depth at which a camera measures best, m.
_USUAL = 0.4
# An edge is where the next pixel is so much deeper, m.
_EDGE = 0.05


def _at_edges(depth: Floats) -> Bools:
    """Pixels whose right neighbour sees something at another depth."""
    beside = np.roll(depth, -1, axis=1)
    edges: Bools = (depth > 0) & (beside > 0) & (np.abs(beside - depth) > _EDGE)
    edges[:, -1] = False
    return edges


def _between(depth: Floats, rng: np.random.Generator) -> Floats:
    """A depth between each pixel's and its right neighbour's."""
    share = rng.random(depth.shape)
    return share * depth + (1 - share) * np.roll(depth, -1, axis=1)
