"""False claims by construction: overlaps as small as a bound that lacks a term would let pass."""

from dataclasses import replace

import numpy as np
import proof_oracle
import pytest
from proof_cases import CUBE, STILL, at, claim, plane, point, turn

from plannercheck.proofs import Entry, Joint, Link
from plannercheck.proofs.chains import Chains


def pendulum(wall, swing=0.3, arm=1.0, frame=-1, direction=(0.0, 1.0, 0.0), flipped=False, **options):
    """A point at the end of an arm along y swings past a wall at y = `wall`, nearest in the middle."""
    bodies = [point("wall", -1, at(y=wall)), point("tip", 0, at(y=arm))]
    if flipped:
        bodies, direction = bodies[::-1], tuple(-x for x in direction)
    return claim([turn()], bodies, (-swing,), (swing,), [plane(direction, frame)], **options)


@pytest.mark.parametrize("flipped", [False, True])
@pytest.mark.parametrize("swing", [0.01, 0.3, 1.2])
def test_a_swing_through_a_wall_is_refused_and_past_it_confirmed(swing, flipped):
    assert pendulum(1 + 1e-4, swing, flipped=flipped).verify()
    assert not pendulum(1 - 1e-6, swing, flipped=flipped).verify()


def test_the_second_derivative_counts_in_full():
    # On a short swing the tip leaves its chord by what the bound says, up to a hundred-thousandth of it.
    swing, deepest = 0.01, 7
    rise = 0.5 * swing**2 / 4.0**deepest  # of the shortest part that the verifier looks at
    assert not pendulum(1 - 0.4 * rise, swing).verify()


def test_a_direction_of_any_length_is_measured():
    for length in (1e-6, 1.0, 1e6):
        assert pendulum(1.001, direction=(0, length, 0), margin=0.0009).verify()
        assert not pendulum(1.001, direction=(0, length, 0), margin=0.0011).verify()
    assert not pendulum(1.001, direction=(0, 0, 0)).verify()
    assert not pendulum(1.001, direction=(0, -1, 0)).verify()


@pytest.mark.parametrize("which", [0, 1])
def test_radii_count(which):
    def with_radius(radius):
        bodies = [point("wall", -1, at(y=1.1)), point("tip", 0, at(y=1.0))]
        bodies[which] = replace(bodies[which], radius=radius)
        return claim([turn()], bodies, (-0.3,), (0.3,), [plane()])

    assert with_radius(0.0999).verify()
    assert not with_radius(0.1001).verify()


@pytest.mark.parametrize("which", [0, 1])
def test_every_vertex_counts(which):
    vertices = np.random.default_rng(which).uniform(-0.01, 0.01, (9, 3))
    for k in range(9):
        far = vertices.copy()
        far[k] = (0, 0.1001 if which else -0.1001, 0)
        bodies = [point("wall", -1, at(y=1.1)), point("tip", 0, at(y=1.0))]
        bodies[which] = replace(bodies[which], vertices=far)
        assert not claim([turn()], bodies, (-1e-4,), (1e-4,), [plane()]).verify()
        bodies[which] = replace(bodies[which], vertices=far * 0.95)
        assert claim([turn()], bodies, (-1e-4,), (1e-4,), [plane()]).verify()


def test_a_frame_turns_its_direction():
    # The direction is fixed on the arm: the wall, a point, is passed at the side, by both ends of the arm's way.
    for wall, holds in ((1.2, True), (0.9, False)):
        assert bool(pendulum(wall, frame=0).verify()) == holds
    bodies = [point("post", -1, at(x=0.0, y=0.5)), point("tip", 0, at(x=0.1, y=0.5))]
    passing = claim([turn()], bodies, (-0.3,), (0.3,), [plane((-1, 0, 0), 0)])
    assert not passing.verify()  # the tip turns into the post


@pytest.mark.parametrize("frame", [-1, 0, 1, 2, 3])
def test_planes_in_every_frame_of_two_branches(frame):
    # Two arms on a turning base move towards each other; in the frame of each link the plane turns along with it.
    joints = [turn(), turn(0, at(x=-1.0), column=1), turn(0, at(x=1.0), column=2), turn(2, at(y=0.5), column=3)]
    bodies = [point("right", 3, at(y=0.5), CUBE * 0.2), point("left", 1, at(y=1.0), CUBE * 0.2)]
    start = (0.0, 0.1, -0.1, 0.0)
    small, large = (0.05, 0.1, -0.05, 0.05), (0.05, -1.5, 1.5, 0.0)
    facing = plane((1, 0, 0), frame)
    assert claim(joints, bodies, start, small, [facing]).verify()
    assert not proof_oracle.is_false(claim(joints, bodies, start, small, [facing]))
    hitting = claim(joints, bodies, start, large, [facing])
    assert proof_oracle.is_false(hitting, 50)
    assert not hitting.verify()


def test_balls_that_overlap_in_the_middle_are_refused():
    def passing(distance):
        slide = turn(axis=(1.0, 0.0, 0.0), kind="slide")
        bodies = [
            point("post", -1, at(y=distance), ((0.1, 0, 0), (-0.1, 0, 0)), reach=0.1000001),
            point("ball", 0, STILL, ((0.0, 0.2, 0), (0.0, -0.2, 0)), 0.1, 0.2000001),
        ]
        return claim([slide], bodies, (-3.0,), (3.0,), [Entry(0, 0.0, 1.0, "balls")])

    assert passing(0.42).verify()
    assert not passing(0.399).verify()


def test_a_ball_has_to_hold_its_vertices():
    bodies = [point("cube", -1, at(x=2.0), CUBE, reach=0.8), point("ball", 0, STILL, radius=0.5)]
    proof = claim([turn()], bodies, (0.0,), (0.1,), [Entry(0, 0.0, 1.0, "balls")])
    assert not proof.verify()  # the cube's corners are 0.866 from its centre
    larger = claim([turn()], [replace(bodies[0], reach=0.8661), bodies[1]], (0.0,), (0.1,), proof.entries)
    assert larger.verify()
    off = replace(
        bodies[0], vertices=np.vstack([CUBE * 0.1, [[0.0, 0.0, 0.9]]]), reach=0.8661
    )  # one corner alone is out
    assert not claim([turn()], [off, bodies[1]], (0.0,), (0.1,), proof.entries).verify()


def test_slides_multipliers_and_offsets_move_bodies():
    def sliding(multiplier, offset, wall):
        slide = turn(axis=(0.0, 1.0, 0.0), kind="slide", multiplier=multiplier, offset=offset)
        return claim([slide], [point("wall", -1, at(y=wall)), point("tip", 0)], (0.0,), (1.0,), [plane()])

    assert sliding(2.0, 0.5, 2.501).verify()
    assert not sliding(2.0, 0.5, 2.499).verify()
    assert not sliding(-2.0, 0.5, 0.499).verify()


def test_quaternions_go_by_slerp_about_their_axis():
    free = Joint("base", "free", -1, STILL, (0.0, 0.0, 0.0), tuple(range(7)), (1.0,) * 7, (0.0,) * 7)
    half = 0.3
    start = (0.0, 0.0, 0.0, 0.0, 0.0, -np.sin(half / 2), np.cos(half / 2))
    end = (0.0, 0.0, 0.0, 0.0, 0.0, np.sin(half / 2), np.cos(half / 2))
    for wall, holds in ((1 + 1e-4, True), (1 - 1e-6, False)):
        bodies = [point("wall", -1, at(y=wall)), point("tip", 0, at(y=1.0))]
        assert bool(claim([free], bodies, start, end, [plane()]).verify()) == holds
        negative = tuple(-x if k > 2 else x for k, x in enumerate(end))  # the same turn, the short way all the same
        assert bool(claim([free], bodies, start, negative, [plane()]).verify()) == holds


def test_planar_joints_go_along_a_circle():
    planar = Joint("base", "planar", -1, STILL, (0.0, 0.0, 0.0), tuple(range(4)), (1.0,) * 4, (0.0,) * 4)
    a, radius = 0.5, 2.0  # along an arc about the origin, whose top is at y = radius
    start = (radius * np.sin(-a), radius * np.cos(a), np.cos(a), np.sin(a))
    end = (radius * np.sin(a), radius * np.cos(a), np.cos(a), -np.sin(a))
    for wall, holds in ((radius + 1e-3, True), (radius - 1e-6, False)):
        bodies = [point("wall", -1, at(y=wall)), point("tip", 0)]
        assert bool(claim([planar], bodies, start, end, [plane()]).verify()) == holds


def test_half_turns_have_no_short_way():
    circle = Joint("c", "circle", -1, STILL, (0.0, 0.0, 1.0), (0, 1), (1.0, 1.0), (0.0, 0.0))
    bodies = [point("wall", -1, at(y=3.0)), point("tip", 0, at(y=1.0))]
    found = claim([circle], bodies, (1.0, 0.0), (-1.0, 0.0), [plane()]).verify()
    assert not found
    assert "half a turn" in found.fault
    ball = Joint("b", "ball", -1, STILL, (0.0, 0.0, 0.0), (0, 1, 2, 3), (1.0,) * 4, (0.0,) * 4)
    found = claim([ball], bodies, (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 0.0), [plane()]).verify()
    assert not found
    assert "half a turn" in found.fault


@pytest.mark.parametrize("off", [1e-300, 1e-17, 1e-13, -1e-300, -1e-17, -1e-13])
def test_nearly_half_turns_have_no_short_way_either(off):
    # Doubles may round to the other side; the tip is beyond the wall on one way only.
    circle = Joint("c", "circle", -1, STILL, (0.0, 0.0, 1.0), (0, 1), (1.0, 1.0), (0.0, 0.0))
    ball = Joint("b", "ball", -1, STILL, (0.0, 0.0, 0.0), (0, 1, 2, 3), (1.0,) * 4, (0.0,) * 4)
    planar = Joint("p", "planar", -1, STILL, (0.0, 0.0, 0.0), (0, 1, 2, 3), (1.0,) * 4, (0.0,) * 4)
    for joint, start, end in (
        (circle, lambda s: (1.0, 0.0), lambda s: (-1.0, s)),
        (planar, lambda s: (0.0, 0.0, 1.0, 0.0), lambda s: (0.0, 0.0, -1.0, s)),
        (ball, lambda s: (0.0, 0.0, 0.0, 1.0), lambda s: (0.0, 0.0, 1.0, s)),
    ):
        for s, holds in ((off, False), (off / abs(off) * 1e-9, True)):
            side = -s / abs(s)  # of the wall: for a turn by a little less than pi, or by -pi, from the tip at y = 1
            bodies = [point("wall", -1, at(x=-side * 1e-6)), point("tip", 0, at(y=1.0))]
            found = claim([joint], bodies, start(s), end(s), [plane((-side, 0, 0))]).verify()
            assert bool(found) == holds, found.fault
            assert holds or "half a turn" in found.fault


def test_placements_off_rigid_cost_what_they_may_be_off():
    # The direction stands on the arm, and the wall is seen from it through placements that are off by 5e-7.
    off = tuple(x * (1 + 2e-7) if k % 4 < 3 else x for k, x in enumerate(STILL))
    for stretch, holds in ((STILL, True), (off, False)):
        joint = replace(turn(), placement=stretch)
        bodies = [point("wall", -1, at(y=100.0)), point("tip", 0, at(y=100.0 - 3e-5))]
        assert bool(claim([joint], bodies, (0.0,), (1e-9,), [plane((0, 1, 0), 0)]).verify()) == holds


def test_lengths_in_frames_off_rigid_are_stretched():
    # Both bodies hang on a joint whose placement shrinks them by 2e-7: in the joint's frame they are 0.1 mm further
    # apart than their radii, in the world 0.1 mm nearer.
    small = tuple(x * (1 - 2e-7) if k % 4 < 3 else x for k, x in enumerate(STILL))
    for placement, holds in ((STILL, True), (small, False)):
        bodies = [point("a", 0, at(y=1000.0001), radius=500.0), point("b", 0, radius=500.0)]
        joint = replace(turn(), placement=placement)
        assert bool(claim([joint], bodies, (0.0,), (1e-3,), [plane((0, 1, 0), 0)]).verify()) == holds


def test_axes_off_unit_length_cost_what_they_may_be_off():
    # Half a turn about an axis that is too long by 5e-7 stretches along it by 2e-6: at 1 km the tip is in the wall.
    for length, holds in ((1.0, True), (1 + 5e-7, False)):
        bodies = [point("wall", -1, at(z=1000.0)), point("tip", 0, at(z=999.999))]
        joint = turn(axis=(0.0, 0.0, length))
        assert bool(claim([joint], bodies, (3.0,), (3.1,), [plane((0, 0, 1), 0)]).verify()) == holds


def test_the_defect_of_a_tree_holds_for_every_chain():
    off = tuple(x * (1 + 2e-7) if k % 4 < 3 else x for k, x in enumerate(STILL))
    joints, links = [turn(), replace(turn(0, column=1), placement=off)], (Link("l", 1, off), Link("w", -1, off))
    proof = claim(joints, [point("a", -1), point("b", 0)], (0.0, 0.0), (0.1, 0.1), [], links=links)
    chains = Chains(proof.model, proof.motion)
    turned = proof_oracle.link_poses(proof.model, (0.3, 0.4))[0][:3, :3]
    assert chains.defect >= np.linalg.norm(turned.T @ turned - np.eye(3), 2)


def test_both_halves_of_an_interval_are_looked_at():
    # The swing is nearest to the wall at a quarter, or at three quarters, of its way, where it goes through.
    for start, end in ((-0.9, 0.3), (-0.3, 0.9)):
        bodies = [point("wall", -1, at(y=1 - 1e-6)), point("tip", 0, at(y=1.0))]
        assert not claim([turn()], bodies, (start,), (end,), [plane()]).verify()
        slide = turn(axis=(1.0, 0.0, 0.0), kind="slide")
        bodies = [point("post", -1, at(y=0.1), radius=0.06), point("ball", 0, radius=0.05)]
        balls = [Entry(0, 0.0, 1.0, "balls")]
        assert not claim([slide], bodies, (10 * start,), (10 * end,), balls).verify()


@pytest.mark.parametrize("size", [1e-155, 1e-158, 1e-162, 1e-200, 1e-280])
def test_a_ball_has_to_hold_vertices_the_squares_of_which_vanish(size):
    # The post is a point within the bar, at a quarter of its length; both balls are far smaller than the bar.
    ends = ((-size, 0.0, 0.0), (size, 0.0, 0.0))
    for reach, place, holds in ((size / 1e6 + 4e-290, size / 2, False), (size * (1 + 1e-9), size * 3, True)):
        bodies = [point("post", -1, at(x=place), reach=4e-290), point("bar", 0, STILL, ends, reach=reach)]
        proof = claim([turn(axis=(1.0, 0.0, 0.0))], bodies, (0.0,), (1e-9,), [Entry(0, 0.0, 1.0, "balls")])
        assert bool(proof.verify()) == holds


def test_a_deviation_counts_on_an_interval_the_square_of_which_vanishes():
    # A tip at s (cos w, sin w) on a slide that turns: s and w are 0 together in the middle of the first entry, so the
    # tip goes through the origin, where the post is, but is above the post at both of the entry's ends.
    short, speed, spin = 1e-162, 1e30, 1e7
    turning = turn(multiplier=10.0, offset=-spin * short / 2)
    sliding = Joint("s", "slide", 0, STILL, (1.0, 0.0, 0.0), (1,), (1e15,), (-speed * short / 2,))
    bodies = [point("tip", 1), point("post", -1, STILL, ((0.0, 0.0, 0.0), (0.0, 1e-290, 0.0), (0.0, -1e-290, 0.0)))]
    entries = [plane((0, 1, 0), -1, 0.0, short), plane((1, 0, 0), 0, short, 1.0)]
    assert not claim([turning, sliding], bodies, (0.0, 0.0), (spin / 10, 1e15), entries).verify()
