"""Bounds of rounding over whole computations hold the sum of their steps, in exact arithmetic, and with how much room.

The single steps are those of the scripts of the same names in tests/error_bounds, in units of u = 2^-53; square roots
are rounded up. What is not of first order is followed along whole chains of joints.
"""

import math
import re
from fractions import Fraction

import numpy as np
import pinocchio as pin
import pytest
from gappa_proofs import PROOFS, ROOT, value

import plannercheck as pc
from plannercheck.bodies.shapes import Box, GeometryObject
from plannercheck.motions.joint_drives import spread
from plannercheck.robots import kinematic_error as kinematic_rounding
from plannercheck.robots.description import shipped_robots
from plannercheck.robots.kinematic_error import KinematicRounding, PoseError
from plannercheck.robots.kinematics import JointTable
from plannercheck.robots.unit_lengths import UNIT_TOLERANCE

F = Fraction
U = F(1, 2**53)

# Of the link in whose frame a direction is, in u, and of quaternions on one chain: what kRunRounding.g allows for.
MOST_TURN, MOST_PARTS = 800, 2


def root(n):
    """A square root, rounded up."""
    return F(math.isqrt(n << 200) + 1, 1 << 100)


def run_steps():
    """By what settles an interval: roundings, in u of `size`, besides frames and quaternions."""
    r3, w, size = root(3), 2, 4
    turned, vertex, centre = 3 * r3, 4 * r3 + 1, 4 * r3 + 1 + 3 * r3 + 2
    threshold = F(17, 2) * size
    return {
        "gap": turned * w + 2 * (2 * turned + 6 + vertex) + w + 3 * w + threshold,
        "boxes": turned * w + 2 * (6 + 9 * r3 + 1 + r3) + threshold,
        "spheres": 2 * centre + w + turned * w + 18 + threshold,
        "box": centre + w + turned * w + 3 * w + threshold,
        "path": centre + 16 + 5 * r3 + 2 + threshold,
    }


@pytest.mark.parametrize("step", run_steps())
def test_the_rounding_of_a_run_holds_each_of_its_sums(step):
    budget = value("motion_rounding", "kRunRounding") / U
    alone = run_steps()[step]
    assert alone < budget / 19
    assert F(97, 100) * budget > 2 * MOST_TURN + 4 * 71 * MOST_PARTS / 2 + alone
    assert value("motion_rounding", "kPartRounding") / U > 2 * 71  # of a part more, at most


def test_the_rounding_of_a_run_is_not_half_too_large_for_what_it_allows_for():
    budget = value("motion_rounding", "kRunRounding") / U
    assert 2 * MOST_TURN + max(run_steps().values()) > budget / 2


@pytest.mark.parametrize("name", shipped_robots())
def test_frames_of_shipped_robots_turn_by_an_eighth_of_what_a_run_allows_for(name):
    robot = pc.Robot.load(name)
    turns = [error.turn for error in robot._rounding._link_errors(*robot._map.sampled_range())]
    assert max(turns) < float(MOST_TURN * U) / 8
    assert robot._map.lengths.depth <= MOST_PARTS


@pytest.mark.parametrize("joints", [28, 32, 100, 1000])
def test_frames_on_chains_of_many_joints_turn_by_no_more_than_a_run_allows_for(joints):
    # Of general axes and placements, which is the worst: kRunRounding alone is proved for 28 of them in a row.
    turn = KinematicRounding(chain(joints), (), ())._link_errors(np.zeros(joints), np.ones(joints))[0].turn
    assert (turn < float(MOST_TURN * U)) == (joints <= 28)
    assert 2 * turn < float(value("motion_rounding", "kTurnRounding")) * joints


def sampled_sizes(robot, q):
    """The largest distance of a joint's or link's origin from the world's at configurations."""
    model, data = robot.model, robot.model.createData()
    found = [np.abs(robot.link_poses(q)[:, :, :3, 3]).max()]
    for row in robot.configuration_map.expand(q):
        pin.forwardKinematics(model, data, row)
        found.append(max(np.linalg.norm(placement.translation) for placement in data.oMi))
    return max(found)


@pytest.mark.parametrize("name", shipped_robots())
def test_no_joint_or_link_is_beyond_its_spread(name):
    robot = pc.Robot.load(name)
    found = spread(robot.joint_table)
    q = robot.random_configurations(50, 1)
    assert sampled_sizes(robot, q) <= (found.extent + found.travel @ np.abs(q).max(axis=0)) * (1 + 1e-6)


def planar_part(links, turns):
    """The largest sum of roundings in the plane, in u of (links + 1) `size` `turns`."""
    r2 = root(2)
    turn = (2 * links + 9) * turns + F(11, 10) * r2
    pose = turn + 2 * r2 + (links + 1) * r2 + 5 * r2
    gap = 2 * turn + 4 * r2 + 2 * (4 * r2 + 4) + 2 * r2 + 4 + 3 * r2
    circle = 36 * r2 + 3 * r2
    return (4 * pose + max(gap, circle) + 13) / ((links + 1) * turns)


def test_the_rounding_of_planar_motions_holds_its_sum_on_any_chain():
    budget = value("motion_certifier_2d", "kPlanarRounding") / U
    parts = [planar_part(links, turns) for links in (1, 2, 3, 7, 30, 1000) for turns in (1, 2, 10, 10**6)]
    assert budget / 16 < max(parts) < budget / 11
    assert planar_part(1, 1) == max(parts)


# ----- kinematics


def chain(n, kind=3):
    """Joints in a row with axes and placements of no special direction, and a link on the last."""
    rng = np.random.default_rng(n)
    axes = rng.normal(size=(n, 3))
    turns = [np.linalg.qr(rng.normal(size=(3, 3)))[0] for _ in range(n)]
    columns = np.full((n, 7), -1, dtype=np.int32)
    columns[:, 0] = np.arange(n)
    return JointTable(
        n,
        np.arange(-1, n - 1, dtype=np.int32),
        np.full(n, kind, dtype=np.int32),
        axes / np.linalg.norm(axes, axis=1)[:, None],
        np.array([np.column_stack([turn * np.linalg.det(turn), rng.uniform(-1, 1, 3)]) for turn in turns]),
        columns,
        np.ones((n, 7)),
        np.zeros((n, 7)),
        np.array([n - 1], dtype=np.int32),
        np.eye(4)[None, :3],
    )


class Dyadic:
    """n / 2^e exactly, not reduced: along chains of joints, Fractions spend their time on common divisors."""

    def __init__(self, n, e=0):
        self.n, self.e = n, e

    @classmethod
    def of(cls, x):
        if isinstance(x, cls):
            return x
        n, d = x.as_integer_ratio()
        assert d & (d - 1) == 0
        return cls(n, d.bit_length() - 1)

    def __add__(self, other):
        other = Dyadic.of(other)
        e = max(self.e, other.e)
        return Dyadic((self.n << e - self.e) + (other.n << e - other.e), e)

    def __mul__(self, other):
        other = Dyadic.of(other)
        return Dyadic(self.n * other.n, self.e + other.e)

    def __sub__(self, other):
        return self + Dyadic.of(other) * -1

    def __gt__(self, other):
        return (self - other).n > 0

    __radd__, __rmul__ = __add__, __mul__

    def fraction(self):
        return F(self.n, 1 << self.e)


class ExactBound:
    """The bound with all that is not of first order, added up exactly from what single steps are said to cost."""

    chain_factor = Dyadic.of(1 + F(1, 2**46))  # more than the 1 + 1e-14 of chains.g

    def __init__(self, rounding):
        self.rounding, self.table = rounding, rounding._table

    def placed(self, placement, joint, done):
        norm, length, turn_cost, shift_cost = (Dyadic.of(x) for x in placement)
        if joint < 0:
            return Dyadic(0), Dyadic(0), norm, length
        turn, shift, most, reach = done[joint]
        computed, u = most + turn, U * self.chain_factor
        last = reach + shift + computed * length if length > 0 else 0
        return (
            turn * norm + u * computed * turn_cost,
            shift + turn * length + u * (computed * shift_cost + last),
            most * norm,
            reach + most * length,
        )

    def moved(self, pose, kind, axis, values):
        turn, shift, most, reach = pose
        step = kinematic_rounding._moved(PoseError(), kind, axis, values)  # what it costs the identity
        own, slid, stretch, length = (Dyadic.of(x) for x in (step.turn, step.shift, step.norm, step.reach))
        computed = most + turn
        last = U * self.chain_factor * (reach + shift + computed * length) if length > 0 else 0
        return (
            turn * stretch + computed * own * self.chain_factor,
            shift + turn * length + computed * (slid - U * length) * self.chain_factor + last,
            most * stretch,
            reach + most * length,
        )

    def bound(self, lower, upper):
        r, table, joints = self.rounding, self.table, []
        for i, parent in enumerate(table.parents.tolist()):
            placed = self.placed(r._joint_placements[i], parent, joints)
            values = kinematic_rounding._values(table, i, lower, upper)
            joints.append(self.moved(placed, int(table.kinds[i]), table.axes[i], values))
        ends = zip(r._link_placements, table.link_joints.tolist(), strict=True)
        links = [self.placed(placement, joint, joints) for placement, joint in ends]
        bodies = [(self.placed(placement, link, links), radius) for link, placement, radius in r._bodies]
        return max((turn * Dyadic.of(radius) + shift).fraction() for (turn, shift, _, _), radius in bodies)


@pytest.mark.parametrize(("kind", "count"), [(3, 7), (3, 300), (8, 30)])
def test_the_bound_of_kinematics_holds_all_terms_of_second_order(kind, count):
    rounding = KinematicRounding(
        chain(count, kind), [GeometryObject("b", "link", np.eye(4), Box((0.2, 0.1, 0.3)))], [0]
    )
    lower, upper = np.full(count, -3.0), np.full(count, 3.0)
    bound, exact = F(rounding.bound(lower, upper)), ExactBound(rounding).bound(lower, upper)
    room = F(kinematic_rounding._REST) - 1
    assert bound / (1 + room) * (1 + room / 2) > exact  # of _REST less than half is used
    assert exact > bound / (1 + room)  # and some of it is


@pytest.mark.parametrize("name", ["panda", "tiago"])
def test_the_bound_of_a_robot_holds_all_terms_of_second_order(name):
    robot = pc.Robot.load(name)
    lower, upper = robot._map.sampled_range()
    bound, exact = F(robot._rounding.bound(lower, upper)), ExactBound(robot._rounding).bound(lower, upper)
    assert bound * (1 - F(1, 2 * 10**9)) > exact > bound * (1 - F(2, 10**9))


def test_the_script_of_cosines_and_sines_has_the_polynomials_of_the_source():
    source = (ROOT / "plannercheck" / "cpp" / "math" / "sincos.hpp").read_text()
    script = (PROOFS / "kinematic_error" / "_SINCOS.g").read_text()
    for name in ("kSin", "kCos"):
        listed = re.search(rf"{name}\[6\] = {{([^}}]*)}}", source)[1].split(",")
        for text in listed:
            number = F(float.fromhex(text.strip()))
            written = f"{number.numerator}b-{number.denominator.bit_length() - 1}"
            assert script.count(written) == 2, f"{name}: {text}"


def test_lengths_off_1_are_those_of_the_script():
    assert UNIT_TOLERANCE == 2e-7
