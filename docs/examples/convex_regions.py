"""Convex regions of free configurations, and a plan through their graph: `python docs/examples/convex_regions.py`.

Around configurations of the Panda in a shipped scene, regions of halfspaces are grown in its seven joint angles in the
manner of IRIS: from the box of the joint limits, each sample that collides is cut off by a halfspace between it and the
seed, until a batch of samples is all free. `pc.ndim.overlap_graph` finds which regions share a point, exactly. A plan
from start to goal goes from common point to common point, straight inside each region.

What is exact and what is not: that regions share a point is exact. That a region is free is checked by sampling, and
the share of colliding samples is printed; a motion validator judges the plan at the end.
"""

from __future__ import annotations

import argparse
import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import plannercheck as pc

Floats = NDArray[np.float64]

# Part of the way from the seed to the collision at which a halfspace cuts.
CUT_AT = 0.9
# Bisections on the way from the seed to a colliding sample: to about 2^-10 of it.
BISECTIONS = 10
# Hit-and-run steps between samples; samples are cheap and need not be uniform.
STEPS = 25
# Halfspaces of a region besides the limits.
MOST_CUTS = 200


@dataclass(frozen=True)
class Region:
    """A convex region of configurations: normals · q ≤ offsets, around its seed, rad."""

    seed: Floats
    normals: Floats
    offsets: Floats

    def polytope(self, name: str) -> pc.ndim.Polytope:
        """The region for overlap tests."""
        return pc.ndim.Polytope.from_halfspaces(self.normals, self.offsets, name=name)


def grow_region(checker: pc.Checker, seed: Floats, rng: np.random.Generator, samples: int) -> Region:
    """Grows a region around a free configuration.

    Args:
        checker: Judges samples.
        seed: A free configuration (d,).
        rng: For the samples.
        samples: A batch; the region is done when one is all free.

    Returns:
        The region; it holds its seed.
    """
    robot = checker.robot
    d = len(seed)
    region = Region(seed, np.concatenate([np.eye(d), -np.eye(d)]), np.concatenate([robot.upper, -robot.lower]))
    while len(region.offsets) < 2 * d + MOST_CUTS:
        batch = sample(region, rng, samples)
        colliding = batch[~checker.check_states(batch)]
        if not len(colliding):
            break
        region = cut(checker, region, colliding)
    return region


def cut(checker: pc.Checker, region: Region, colliding: Floats) -> Region:
    """Cuts colliding samples off, the one whose collision is nearest to the seed first."""
    ways = first_collisions(checker, region.seed, colliding) - region.seed
    normals, offsets = [region.normals], [region.offsets]
    while len(ways):
        lengths = np.linalg.norm(ways, axis=1)
        nearest = int(lengths.argmin())
        normal = ways[nearest] / lengths[nearest]
        normals.append(normal[None])
        offsets.append(np.array([normal @ region.seed + CUT_AT * lengths[nearest]]))
        kept = (colliding - region.seed) @ normal <= CUT_AT * lengths[nearest]
        ways, colliding = ways[kept], colliding[kept]
    return Region(region.seed, np.concatenate(normals), np.concatenate(offsets))


def first_collisions(checker: pc.Checker, seed: Floats, colliding: Floats) -> Floats:
    """A colliding configuration on the way to each colliding sample, next to a free one."""
    free, hit = np.zeros(len(colliding)), np.ones(len(colliding))
    for _ in range(BISECTIONS):
        middle = (free + hit) / 2
        valid = checker.check_states(seed + middle[:, None] * (colliding - seed))
        free, hit = np.where(valid, middle, free), np.where(valid, hit, middle)
    return np.asarray(seed + hit[:, None] * (colliding - seed))


def sample(region: Region, rng: np.random.Generator, count: int) -> Floats:
    """Configurations in a region, by hit and run from the seed."""
    points = np.tile(region.seed, (count, 1))
    for _ in range(STEPS):
        directions = rng.normal(size=points.shape)
        room = np.maximum(region.offsets - points @ region.normals.T, 0.0)
        rates = directions @ region.normals.T
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios = room / rates
        ahead = np.where(rates > 0, ratios, np.inf).min(axis=1)
        behind = np.where(rates < 0, ratios, -np.inf).max(axis=1)
        points = points + (behind + (ahead - behind) * rng.random(count))[:, None] * directions
    return points


def plan(regions: list[Region], graph: pc.ndim.OverlapGraph, polytopes: list[pc.ndim.Polytope]) -> Floats | None:
    """Way points from the first region's seed to the second's, straight inside one region each, or None."""
    way = graph.path(0, 1)
    if way is None:
        return None
    points = [regions[0].seed]
    for i, j in itertools.pairwise(way):
        shared = pc.ndim.certify(polytopes[i], polytopes[j], method="oracle")
        assert isinstance(shared, pc.ndim.SharedPoint), "neighbours share a point"
        assert shared.verify(), "and its proof holds in fractions"
        points.append(shared.point)
    return np.array([*points, regions[1].seed])


def seeds_of(checker: pc.Checker, scene: pc.Scene, count: int, rng: np.random.Generator) -> Floats:
    """Start, goal, and free configurations between them and about them."""
    ends = np.array([scene.start("panda"), scene.goal("panda")])
    between = ends[0] + rng.random((20 * count, 1)) * (ends[1] - ends[0])
    drawn = np.clip(between + 0.4 * rng.normal(size=between.shape), checker.robot.lower, checker.robot.upper)
    return np.concatenate([ends, drawn[checker.check_states(drawn)][: count - 2]])


def main() -> None:
    """Grows the regions and prints what they give."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scene", default="bookshelf")
    parser.add_argument("--regions", type=int, default=12)
    parser.add_argument("--samples", type=int, default=1000)
    parser.add_argument("--check", type=int, default=20_000, help="samples that judge each region")
    options = parser.parse_args()
    rng = np.random.default_rng(0)
    scene = pc.Scene.load(options.scene)
    checker = pc.Checker(pc.Robot.load("panda"), scene)
    seeds = seeds_of(checker, scene, options.regions, rng)
    regions = [grow_region(checker, seed, rng, options.samples) for seed in seeds]
    print("region   halfspaces   colliding samples")
    for number, region in enumerate(regions):
        wrong = 1 - checker.check_states(sample(region, rng, options.check)).mean()
        print(f"{number:6d}   {len(region.offsets):10d}   {wrong:16.3%}")
    polytopes = [region.polytope(f"region {k}") for k, region in enumerate(regions)]
    graph = pc.ndim.overlap_graph(polytopes)
    print(f"{len(graph.edges)} pairs share a point, {graph.tested} were tested, {graph.skipped} have boxes apart")
    points = plan(regions, graph, polytopes)
    if points is None:
        print("start and goal are not connected: more regions may help (--regions)")
        return
    free = checker.check_motions(points[:-1], points[1:])
    print(f"a plan over {len(points) - 2} common points; free motions, sampled: {int(free.sum())} of {len(free)}")


if __name__ == "__main__":
    main()
