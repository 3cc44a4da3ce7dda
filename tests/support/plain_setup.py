"""What a checker knows before its first verdict, computed anew by the plain functions, without anything that is kept.

In: a checker. Out: the pairs that never meet and those at rest, the table of pairs, the rounding bound, and the chains
of its motions, to be held against what the checker took from its robot's memory, an earlier checker, or the core.
"""

import numpy as np

import plannercheck as pc
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import inflated_hull
from plannercheck.checking.compiled_pairs import body_placements
from plannercheck.checking.pair_table import fixed_links
from plannercheck.checking.unreachable_pairs import stays_apart, unreachable_pairs
from plannercheck.motions.joint_axes import JointTree
from plannercheck.motions.joint_chains import ChainBuilder, chain_arrays
from plannercheck.motions.joint_drives import defect, drives, spread
from plannercheck.motions.robot_chains import chains_of_robot
from plannercheck.robots.kinematic_error import KinematicRounding


def plain_proofs(checker: pc.Checker) -> tuple[np.ndarray, np.ndarray]:
    """(k,) unreachable and (k,) static for the rows of `checker.pairs`."""
    robot, bodies = checker.robot, checker.bodies
    order = sorted(range(len(bodies)), key=lambda k: bodies[k].link is None)
    place = np.argsort(order).astype(np.int32)
    hulls = [padded_hull(checker, k) for k in order]
    found = unreachable_pairs(robot, [bodies[k] for k in order], place[checker.pairs], hulls)
    apart = found.apart.copy()
    links = robot.link_poses(robot.reference)
    for k in np.flatnonzero(found.static & ~apart) if found.is_proved else ():
        sides = checker.pairs[k].tolist()
        polytopes = [Polytope(*padded_hull(checker, side)) for side in sides]
        world = [np.eye(4) if bodies[s].link is None else links[robot.link_index(bodies[s].link)] for s in sides]
        apart[k] = stays_apart(*polytopes, *(w @ bodies[s].pose for w, s in zip(world, sides, strict=True)))
    return apart, found.static


def padded_hull(checker: pc.Checker, body: int):
    """Points, faces and inflation radius of a body, with its part of the padding."""
    points, faces, radius = inflated_hull(checker.bodies[body].shape, checker.excess)
    return points, faces, radius + float(checker.paddings[body])


def plain_pairs(robot: pc.Robot, scene: pc.Scene) -> list[tuple[int, int]]:
    """The table of a checker with the robot's own matrix, pair by pair."""
    fixed = fixed_links(robot)
    own = [tuple(pair) for pair in robot.self_pairs.tolist()]
    others = [
        (a, len(robot.bodies) + k)
        for a, body in enumerate(robot.bodies)
        for k, name in enumerate(scene.body_objects)
        if not scene.is_allowed(body.label, name) and body.link not in fixed
    ]
    return own + others


def plain_error(robot: pc.Robot, low: np.ndarray, high: np.ndarray) -> float:
    """The bound of the kinematics' rounding, read anew."""
    moving = [body for body in robot.bodies if body.link is not None]
    rounding = KinematicRounding(robot.joint_table, moving, [robot.link_index(body.link) for body in moving])
    return rounding.bound(low, high)


def chains_both_ways(checker: pc.Checker):
    """The arrays of the chains of all pairs in which something moves: (as the certifier takes them, made anew)."""
    robot, bodies = checker.robot, checker.bodies
    links = body_placements(robot, bodies, robot.kinematics)[0]
    pairs = checker.pairs.astype(np.int64)
    pairs = np.where((links[pairs[:, :1]] < 0) & (links[pairs[:, 1:]] >= 0), pairs[:, ::-1], pairs)
    pairs = pairs[links[pairs[:, 0]] >= 0]
    known = chains_of_robot(robot, bodies, links, checker.excess)
    found = known.of(pairs)
    table = robot.joint_table
    tree = JointTree(robot.model, robot.configuration_map, table, robot.frames)
    builder = ChainBuilder(tree, bodies, links.tolist(), checker.excess)
    parts = [builder.parts(a, b) for a, b in pairs.tolist()]
    rows = [(part.frame, builder.index(part.first), builder.index(part.second)) for part in parts]
    made = np.hstack([pairs, np.reshape(rows, (-1, 3))]).astype(np.int32), *drives(table)[:2]
    reach, leverage = spread(table), float(max(1.0, np.abs(table.multipliers).sum()))
    numbers = known.defect, known.leverage, known.depth, known.spread.extent, known.spread.joints
    truth = defect(table), leverage, robot.configuration_map.lengths.depth, reach.extent, reach.joints
    kept = (found.pairs, *known.drives[:2], *found[1:], known.drives[2], known.spread.travel, np.array(numbers))
    return kept, (*made, *chain_arrays(builder.chains), drives(table)[2], reach.travel, np.array(truth))


def assert_as_computed_anew(checker: pc.Checker) -> None:
    """All of the above, for one checker."""
    robot = checker.robot
    apart, static = plain_proofs(checker)
    np.testing.assert_array_equal(checker.unreachable, apart)
    np.testing.assert_array_equal(checker.static, static)
    low, high = robot.configuration_map.sampled_range()
    assert robot.kinematic_error_within(low, high) == plain_error(robot, low, high)
    for found, truth in zip(*chains_both_ways(checker), strict=True):
        assert found.dtype == truth.dtype
        np.testing.assert_array_equal(found, truth)
