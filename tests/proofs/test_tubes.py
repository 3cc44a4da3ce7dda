"""How far a tube displaces bodies: never less than at sampled corners, never more than the certifier's own bound."""

from dataclasses import replace

import curve_oracle
import numpy as np
import pytest
from curve_oracle import curve
from proof_cases import CUBE, STILL, at, plane, point, random_tree, scattered, turn

import plannercheck as pc
from plannercheck.motions.joint_axes import JointTree
from plannercheck.motions.joint_chains import ChainBuilder
from plannercheck.motions.joint_drives import drives
from plannercheck.motions.proof_builder import Builder
from plannercheck.proofs import Joint, Motion, Proof
from plannercheck.proofs.entries import EntryChecker
from plannercheck.proofs.well_formed import check_well_formed

LONG = 1.0 + 0.7 + 0.4


def arm(wall, tube=(1e-3, 2e-3, 3e-3), slide=0.4, inner=((0.0, 0.0, 0.4),)):
    """A stretched arm along x of two turns and a slide, its tip `LONG` away, below a wall at y = `wall`."""
    joints = [turn(), turn(0, at(x=1.0), column=1), turn(1, at(x=0.7), (1.0, 0.0, 0.0), 2, kind="slide")]
    bodies = [point("wall", -1, at(x=LONG, y=wall)), point("tip", 2)]
    rows = [(0.0, 0.0, slide), *inner, (0.0, 0.0, slide)]
    return curve(joints, bodies, rows, [plane()], tube)


def bound_of_arm(tube, slide=0.4):
    return tube[0] * (LONG + tube[2]) + tube[1] * (0.7 + slide + tube[2]) + tube[2]


@pytest.mark.parametrize(
    "tube", [(1e-3, 2e-3, 3e-3), (1e-2, 0.0, 0.0), (0.0, 1e-2, 0.0), (0.0, 0.0, 1e-2), (1e-9, 0, 1e-9)]
)
def test_a_tube_is_measured_by_its_arms(tube):
    needed = bound_of_arm(tube)
    assert arm(needed * (1 + 1e-6) + 1e-12, tube).verify()
    assert not arm(needed * (1 - 1e-6) - 1e-12, tube).verify()
    assert arm(1e-9, ()).verify()


def test_the_bound_is_nearly_reached_by_a_stretched_arm():
    tube = (1e-4, 1e-4, 0.0)
    proof = arm(1.0, tube)
    moved = curve_oracle.points(proof, 1, curve_oracle.link_maps(proof, curve_oracle.state(proof, 0.5, tube)))[0]
    assert 0.999 * bound_of_arm(tube) < float(moved[1]) <= bound_of_arm(tube)


def test_a_slide_counts_by_the_furthest_control_point_and_its_tube():
    # The inner control point takes the slide to 3 m, so arms are counted with it, wherever it stands.
    far = arm(1.0, (1e-3, 0.0, 0.0), inner=((0.0, 0.0, 3.0),))
    found = EntryChecker(far)._tube.widening(-1, 0, 1)
    assert found == pytest.approx(1e-3 * (1.7 + 3.0), rel=1e-9)
    wide = EntryChecker(arm(1.0, (1e-3, 0.0, 0.5)))._tube.widening(-1, 0, 1)
    assert wide == pytest.approx(1e-3 * (1.7 + 0.9) + 0.5, rel=1e-9)


def test_factors_and_followers_count():
    joints = [turn(multiplier=-2.0), turn(0, at(x=1.0), multiplier=3.0)]  # both follow column 0
    proof = curve(
        joints, [point("wall", -1, at(y=5.0)), point("tip", 1, at(x=0.5))], [(0.0,), (0.0,)], [plane()], (1e-3,)
    )
    assert EntryChecker(proof)._tube.widening(-1, 0, 1) == pytest.approx(1e-3 * (2 * 1.5 + 3 * 0.5), rel=1e-9)


def test_a_motion_without_a_tube_is_not_widened():
    for tube in ((), (0.0, 0.0, 0.0)):
        assert EntryChecker(arm(1.0, tube))._tube.widening(-1, 0, 1) == 0.0


def test_every_kind_of_entry_is_widened():
    joints, tube = [turn()], (0.1,)
    tip = point("tip", 0, at(x=1.0), CUBE * 0.01, reach=0.02)
    rows = [(0.0,), (0.01,), (0.0,)]

    def refused_by_the_tube(bodies, entry):
        wide, narrow = (curve(joints, bodies, rows, [entry], each).verify() for each in (tube, ()))
        assert narrow, narrow.fault
        return not wide

    wall = point("wall", -1, at(x=1.0, y=0.09), CUBE * 0.01, reach=0.02)
    assert refused_by_the_tube([wall, tip], plane())
    assert refused_by_the_tube([wall, tip], replace(plane(), by="balls", direction=()))
    ground = replace(point("ground", -1), vertices=np.zeros(0), half_space=(0.0, 1.0, 0.0, -0.09))
    assert refused_by_the_tube([ground, tip], replace(plane(), by="half-space", direction=()))
    for parts, vertices, own in (
        ("balls", [(0.0, 0.0, 0.0)], {"radii": np.array([0.01])}),
        ("boxes", [(-0.01, 0.0, -0.01), (0.01, 0.01, 0.01)], {}),
    ):
        cloud = replace(wall, vertices=np.array(vertices), parts=parts, **own)
        assert refused_by_the_tube([cloud, tip], plane())
    seen = plane((0.0, 1.0, 0.0), 0)  # a direction on the arm
    assert refused_by_the_tube([wall, tip], seen)


def test_a_set_that_moves_is_widened_by_its_furthest_part():
    for parts, listed, own, furthest in (
        ("balls", [(0.0, 0.0, 0.0), (0.3, 0.4, 0.0)], {"radii": np.array([0.1])}, 0.5),
        ("boxes", [(0.3, 0.0, 9.0), (0.0, 0.4, 0.0)], {}, 0.5),
        ("prisms", [(0.3, 0.0, 0.0), (0.0, 0.1, 0.0), (0.3, 0.4, 0.0)], {"base": -7.0}, 0.5),
    ):
        vertices, above = np.array(listed), np.array([0.0, 0.0, 5.0])
        body = replace(point("cloud", 0), vertices=vertices, parts=parts, **own)
        proof = curve([turn()], [point("wall", -1, at(y=9.0)), body], [(0.0,), (0.0,)], [plane()], (1e-3,))
        check_well_formed(proof)
        assert EntryChecker(proof)._tube.widening(-1, 0, 1) == pytest.approx(1e-3 * furthest, rel=1e-9)
        swung = replace(point("cloud", 0), vertices=vertices + above, parts=parts, **own)
        about_x = turn(axis=(1.0, 0.0, 0.0))
        proof = curve([about_x], [point("wall", -1, at(y=9.0)), swung], [(0.0,), (0.0,)], [plane()], (1e-3,))
        points = vertices + above
        if parts == "prisms":
            points = np.concatenate([points, [[*p[:2], -7.0] for p in points]])
        if parts == "boxes":
            points = np.array([[x, y, z] for x in (0, 0.3) for y in (0, 0.4) for z in (5.0, 14.0)])
        expected = 1e-3 * np.hypot(points[:, 1], points[:, 2]).max()
        assert EntryChecker(proof)._tube.widening(-1, 0, 1) == pytest.approx(expected, rel=1e-9)


def widened(checker, generator):
    """A proof without entries of a random curve of a checker's robot, with a tube."""
    builder, robot = Builder(checker), checker.robot
    points = robot.random_configurations(4, generator)
    tube = generator.uniform(0, 0.1, robot.nq)
    for first, past in robot.configuration_map.units:
        tube[first:past] = 0.0
    start, end = (tuple(q.tolist()) for q in points[[0, -1]])
    motion = Motion(start, end, end, "slerp", tuple(points[1:-1].ravel().tolist()), tuple(tube.tolist()))
    return Proof("space", "r", "s", builder._hashes, builder._model, motion, 0.0, ())


def certifiers_bounds(checker, proof):
    """The certifier's own sum by pair, and its frame: written from the head of cpp/motions/motion_bounds.hpp."""
    robot, table = checker.robot, checker.robot.joint_table
    tree = JointTree(robot.model, robot.configuration_map, table, robot.frames, "slerp")
    links = [-1 if b.link is None else robot.link_index(b.link) for b in checker.bodies]
    chains = ChainBuilder(tree, checker.bodies, links, checker.excess)
    kinds, factors, _ = drives(table, "slerp")
    rows, tube = np.array(proof.motion.control), np.array(proof.motion.tube)

    def speed(entry):
        kind, column = kinds[entry.joint]
        width = 0.0 if kind == 2 else abs(factors[entry.joint, 0]) * tube[column]
        return width if kind == 1 else width * (entry.arm + sum(extent(slide) for slide in entry.slides))

    def extent(joint):
        (_, column), (factor, offset) = kinds[joint], factors[joint]
        return np.abs(factor * rows[:, column] + offset).max() + abs(factor) * tube[column]

    for k, (first, second) in enumerate(checker.pairs.tolist()):
        if links[first] < 0:
            first, second = second, first
        if links[first] >= 0:
            parts = chains.parts(first, second)
            yield k, parts.frame, sum(map(speed, parts.first + parts.second))


@pytest.mark.parametrize("case", ["panda", "tiago", "baxter", *range(8)])
def test_the_bound_is_never_above_the_certifiers(case, tmp_path):
    generator = np.random.default_rng(case if isinstance(case, int) else 99)
    if isinstance(case, int):
        robot = pc.Robot.from_urdf(random_tree(generator, tmp_path, 7), floating=bool(case % 2))
        checker = pc.Checker(robot, scattered(generator))
    else:
        checker = pc.Checker(pc.Robot.load(case), scattered(generator))
    proof = widened(checker, generator)
    verifier = EntryChecker(proof)
    counted = 0
    for k, frame, bound in certifiers_bounds(checker, proof):
        a, b = proof.model.pairs[k]
        joint = -1 if frame < 0 else proof.model.links[frame].joint
        found = verifier._tube.widening(joint, a, b)
        assert found <= bound * (1 + 1e-6) + 1e-12, (k, frame)
        counted += found > 0
    assert counted > 10


@pytest.mark.parametrize("seed", range(6))
def test_no_sampled_corner_moves_a_body_further_than_the_bound(seed, tmp_path):
    generator = np.random.default_rng(seed)
    kinds = ("revolute", "prismatic")
    robot = pc.Robot.from_urdf(random_tree(generator, tmp_path, 5, kinds), floating=bool(seed % 2))
    checker = pc.Checker(robot, scattered(generator, 2))
    proof = widened(checker, generator)
    verifier, frames = EntryChecker(proof), range(-1, len(proof.model.links))
    for _ in range(3):
        t, tube = float(generator.random()), np.array(proof.motion.tube)
        maps = [curve_oracle.seen(proof, t, e) for e in (None, generator.choice([-1.0, 1.0], robot.nq) * tube)]
        for a, b in proof.model.pairs[:: max(1, len(proof.model.pairs) // 8)]:
            for frame in frames:
                joint = -1 if frame < 0 else proof.model.links[frame].joint
                moved = sum(np.linalg.norm(maps[0][frame][k] - maps[1][frame][k], axis=1).max() for k in (a, b))
                assert moved <= verifier._tube.widening(joint, a, b) * (1 + 1e-9) + 1e-12


def test_a_tube_of_a_free_base_shifts_by_its_diagonal():
    base = Joint("base", "free", -1, STILL, (0.0, 0.0, 0.0), tuple(range(7)), (1.0,) * 7, (0.0,) * 7)
    rows = [(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)] * 3
    tube = (0.3, 0.4, 1.2, 0.0, 0.0, 0.0, 0.0)
    for wall, holds in ((1.301, True), (1.299, False)):
        bodies = [point("wall", -1, at(y=wall)), point("base", 0)]
        assert bool(curve([base], bodies, rows, [plane()], tube, "slerp").verify()) == holds


def test_a_base_that_slides_lengthens_the_arms_of_what_is_seen_from_it():
    # The base goes 2 m along x, so a post in the world is up to 3 m from the axis of the arm on it.
    base = Joint("base", "free", -1, STILL, (0.0, 0.0, 0.0), tuple(range(7)), (1.0,) * 7, (0.0,) * 7)
    rows = [(x, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0) for x in (0.0, -2.0, 0.0)]
    bodies = [point("post", -1, at(x=1.0)), point("tip", 1)]
    proof = curve([base, turn(0, column=7)], bodies, rows, [plane()], (0.0,) * 7 + (1e-3,), "slerp")
    assert EntryChecker(proof)._tube.widening(1, 0, 1) == pytest.approx(3e-3, rel=1e-9)
