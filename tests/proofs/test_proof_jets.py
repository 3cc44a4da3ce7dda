"""The verifier's poses and bounds: against Pinocchio, differences and many digits."""

import mpmath
import numpy as np
import pinocchio as pin
import proof_oracle
import pytest
from flint import arb, arb_mat
from proof_cases import CUBE, STILL, at, claim, middle, plane, point, random_tree, scattered, turn

import plannercheck as pc
from plannercheck.motions.proof_builder import Builder
from plannercheck.proofs import Joint, Motion, entries, joint_motions
from plannercheck.proofs.chains import Chains
from plannercheck.proofs.data import JOINTS


def chains_of(checker, q0, q1):
    builder = Builder(checker)
    motion = Motion(*(tuple(map(float, q)) for q in (q0, q1, q1)))
    return Chains(builder._model, motion), builder._model


def joint_poses(robot, q):
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, robot.expand(q))
    return [pose.homogeneous for pose in data.oMi][1:]


@pytest.mark.parametrize("seed", range(8))
def test_the_verifiers_poses_are_pinocchios(seed, tmp_path):
    generator = np.random.default_rng(100 + seed)
    robot = pc.Robot.from_urdf(random_tree(generator, tmp_path, links=7), floating=bool(seed % 2))
    q0, q1 = robot.random_configurations(2, generator)
    if seed % 4 < 2:  # turns of nearly nothing, where closed forms cancel
        q1 = pin.integrate(robot.model, q0, generator.normal(size=robot.model.nv) * 10.0 ** -generator.uniform(0, 9))
    chains, model = chains_of(pc.Checker(robot, scattered(generator)), q0, q1)
    for t in (0.0, 0.3, 1.0):
        exact = joint_poses(robot, pin.interpolate(robot.model, q0, q1, t))
        for k in range(len(model.joints)):
            assert np.abs(middle(chains.at(t, -1, k)) - exact[k]).max() < 1e-11


@pytest.mark.parametrize("seed", range(6))
def test_jets_hold_poses_and_derivatives_all_over_an_interval(seed, tmp_path):
    generator = np.random.default_rng(200 + seed)
    robot = pc.Robot.from_urdf(random_tree(generator, tmp_path), floating=bool(seed % 2))
    q0, q1 = robot.random_configurations(2, generator)
    chains, model = chains_of(pc.Checker(robot, scattered(generator)), q0, q1)
    step = 2.0**-13
    for span in ((0.25, 0.375), (0.5, 0.53125)):
        for k in range(len(model.joints)):
            jet = chains.jet(span, -1, k)
            for t in np.linspace(span[0] + step, span[1] - step, 4):
                near = [middle(chains.at(float(t + d), -1, k)) for d in (-step, 0.0, step)]
                assert encloses(jet.value, near[1], 1e-12)
                assert encloses(jet.first, (near[2] - near[0]) / (2 * step), 1e-5)
                assert encloses(jet.second, (near[2] - 2 * near[1] + near[0]) / step**2, 1e-4)


def encloses(matrix, numbers, slack):
    """Whether balls hold numbers, but for a part of their size that differences are off by."""
    if matrix is None:
        return np.abs(numbers).max() < slack
    room = slack * (1 + np.abs(numbers).max())
    low = np.array([float(x.lower()) for x in matrix.entries()]).reshape(4, 4)
    high = np.array([float(x.upper()) for x in matrix.entries()]).reshape(4, 4)
    return bool(((numbers >= low - room) & (numbers <= high + room)).all())


def test_what_is_no_number_is_not_straight():
    assert np.isnan(entries._positive(float("nan")))
    assert entries._positive(-1.0) == 0.0
    assert entries._positive(2.0) == 2.0


def test_the_width_of_an_enclosure_counts():
    points = np.array([[1.0, 2.0, 3.0], [-1.0, 0.5, -3.0]])
    seen = entries.Seen(points, np.abs(points).max(axis=0), 0, None)
    middles, widths = [0.3, -0.2, 0.1, 5.0], [0.01, 0.02, 0.03, 0.04]
    for k in range(4):
        row = arb_mat(1, 4, [arb(x, w if j == k else 0) for j, (x, w) in enumerate(zip(middles, widths, strict=True))])
        true = [p @ middles[:3] + middles[3] - widths[k] * abs([*p, 1.0][k]) for p in points]
        assert entries.lowest(seen, row) <= min(true) + 1e-15
        for p, least in zip(points, true, strict=True):
            assert entries.lowest(entries.Seen(p[None], np.abs(p), 0, None), row) <= least + 1e-15


@pytest.mark.parametrize("seed", range(4))
def test_bending_seen_from_another_branch_is_the_second_derivative(seed):
    generator = np.random.default_rng(seed)
    joints = [
        turn(k, at(*generator.uniform(-1, 1, 3)), axis=tuple(np.eye(3)[k % 3].tolist()), column=j)
        for j, k in enumerate((-1, 0, 1, 0, 3))
    ]
    bodies = [point("a", 2, at(0.3, 0.2), CUBE), point("b", 4, at(0.1, -0.3), CUBE)]
    ends = generator.uniform(-1, 1, (2, 5)).tolist()
    checker = entries.EntryChecker(claim(joints, bodies, *ends, [plane((1, 2, 3), 2)]))
    step, t = 2.0**-12, 0.5
    for frame in (2, 1, 4):
        direction = checker._direction(frame, (1.0, 2.0, 3.0))
        for seen in checker._seen:
            rows = [row_of(checker._row(seen, direction, t + d)) for d in (-step, 0.0, step)]
            second = (rows[2] - 2 * rows[1] + rows[0]) / step**2
            bending = checker._bending(seen, direction, (t - step, t + step))
            assert np.abs(row_of(bending) - second).max() < 1e-4 * (1 + np.abs(second).max())


def row_of(matrix):
    return np.array([float(x) for x in matrix.entries()])


@pytest.mark.parametrize("kind", sorted(JOINTS))
def test_held_joints_stand_where_they_are_held(kind):
    values = {
        "turn": (0.7,),
        "slide": (0.4,),
        "circle": (0.6, 0.8),
        "planar": (0.3, -0.2, 0.6, -0.8),
        "ball": (0.5, -0.5, 0.5, 0.5),
        "free": (0.1, 0.2, 0.3, 0.1, 0.7, 0.1, 0.7),
    }[kind]
    axis = (0.6, 0.0, 0.8) if JOINTS[kind].has_axis else (0.0, 0.0, 0.0)
    joint = Joint("h", kind, 0, at(0.1, 0.2, 0.3), axis, (-1,) * len(values), (0.0,) * len(values), values)
    proof = claim([turn(), joint], [point("a", -1), point("b", 1)], (0.2,), (0.4,), [])
    pose = middle(Chains(proof.model, proof.motion).at(0.5, -1, 1))
    assert np.abs(pose - proof_oracle.link_poses(proof.model, (0.3,))[1]).max() < 1e-15


@pytest.mark.parametrize("kind", ["circle", "planar", "ball", "free"])
def test_numbers_off_unit_length_are_normalised(kind):
    count = JOINTS[kind].numbers
    joint = Joint("j", kind, -1, STILL, (0.0, 0.0, 1.0), tuple(range(count)), (1.0,) * count, (0.0,) * count)
    unit = np.array([0.6, 0.8] if kind in ("circle", "planar") else [0.1, 0.7, 0.1, 0.7])
    start = (*(0.5,) * (count - len(unit)), *(unit * (1 + 5e-7)).tolist())
    end = (*(0.5,) * (count - len(unit)), *(unit[::-1] * (1 - 5e-7)).tolist())
    proof = claim([joint], [point("a", -1), point("b", 0)], start, end, [])
    for t in (0.0, 0.4, 1.0):
        turned = middle(Chains(proof.model, proof.motion).at(t, -1, 0))[:3, :3]
        assert np.abs(turned.T @ turned - np.eye(3)).max() < 1e-15


def exact(x):
    """A ball without a radius as mpmath's number."""
    mantissa, exponent = x.man_exp()
    return mpmath.ldexp(int(mantissa), int(exponent))


def test_series_of_small_turns():
    for x in (0.0, 1e-200, 1e-9, 1e-3, 0.1, 0.249999):
        with mpmath.workdps(60):
            square = mpmath.mpf(x) ** 2
            half = mpmath.mpf(x) / 2
            cotangent = (1 - half * mpmath.cot(half)) / square if x > 1e-30 else mpmath.mpf(1) / 12
            arctangent = mpmath.atan(x) / x if x > 1e-30 else mpmath.mpf(1)
            for found, true in (
                (joint_motions._cotangent(arb(x) ** 2), cotangent),
                (joint_motions._arctangent(arb(x)), arctangent),
            ):
                low, high = (exact(x) for x in (found.lower().mid(), found.upper().mid()))
                assert low - mpmath.mpf(10) ** -25 <= true <= high + mpmath.mpf(10) ** -25
                assert high - low < 1e-14
