"""Filters of sets look at poses in floats: these stay within their bounds, and no verdict depends on them.

The bounds are held against poses in 200 bits and, for more configurations, against those in doubles, whose error is 1e8
times smaller.
"""

import numpy as np
import pytest
from multiprecision import link_poses, table_of
from poses import at
from random_chains import random_chain, random_placement, random_rows
from random_trees import random_tree
from scipy.spatial.transform import Rotation

import plannercheck as pc
from plannercheck.common.core import core
from plannercheck.robots.kinematics import JointTable

TURNS, SLIDE = (0, 1, 2, 3), 8
POSSIBLE = (*TURNS, SLIDE)

# The largest multiple of a block's states, on any level.
BLOCK = 16


def parts_of_bounds(kinematics, q, right=None):
    """The largest (of directions, of origins) part of its bound that a pose in floats errs by; q (n, width)."""
    needed = np.ones(kinematics.link_count, dtype=np.uint8)
    poses, errors = kinematics.float_link_poses(q, needed)
    right = kinematics.link_poses(q, needed)[:, :, :3] if right is None else right
    off = poses.astype(np.float64) - right
    turned = np.linalg.norm(off[..., :3], ord=2, axis=(-2, -1)) / errors[..., 0]
    shifted = np.linalg.norm(off[..., 3], axis=-1) / errors[..., 1]
    assert not np.isnan(turned).any()
    return turned.max(), shifted.max()


def turning_joint(kind, axis):
    """A table of one joint about the world's origin, with a link on it."""
    eye = np.eye(4)[None, :3]
    columns = np.array([[0, *[-1] * 6]], dtype=np.int32)
    one, none = np.ones((1, 7)), np.zeros((1, 7))
    first = np.zeros(1, dtype=np.int32)
    return core.Kinematics(
        *JointTable(1, first - 1, first + kind, np.array([axis], dtype=np.float64), eye, columns, one, none, first, eye)
    )


@pytest.mark.parametrize("scale", [1.0, 100.0, 1e6 / 4])
def test_sines_and_cosines_stay_within_what_is_said_of_them(scale):
    """2^-23, for angles all around, beside multiples of a right angle and of half of one, and up to the largest."""
    rng = np.random.default_rng(0)
    right = np.pi / 4 * rng.integers(-int(4 * scale / np.pi), int(4 * scale / np.pi) + 1, 20_000)
    beside = right + rng.choice([-1, 1], 20_000) * 10.0 ** rng.uniform(-17, 0, 20_000)
    angles = np.concatenate([rng.uniform(-4 * scale, 4 * scale, 200_000), right, beside])
    angles = angles[np.abs(angles) <= 1e6, None]
    needed = np.ones(1, dtype=np.uint8)
    for kind, (cos, sin) in zip((0, 1, 2), (((1, 1), (2, 1)), ((2, 2), (0, 2)), ((0, 0), (1, 0))), strict=True):
        poses = turning_joint(kind, np.zeros(3)).float_link_poses(angles, needed)[0][:, 0].astype(np.float64)
        assert np.abs(poses[(slice(None), *cos)] - np.cos(angles[:, 0])).max() <= 2**-23
        assert np.abs(poses[(slice(None), *sin)] - np.sin(angles[:, 0])).max() <= 2**-23


def test_sines_and_cosines_of_all_kinds_of_floats():
    """Every 613th float of an eighth of a turn, given as a double: only the polynomials' own rounding is left."""
    bits = np.arange(0, np.float32(np.pi / 4).view(np.int32) + 1, 613, dtype=np.int32)
    angles = np.concatenate([[1, -1]]) * bits.view(np.float32).astype(np.float64)[:, None]
    needed = np.ones(1, dtype=np.uint8)
    kinematics = turning_joint(2, np.zeros(3))
    for part in np.array_split(angles.reshape(-1, 1), 10):
        poses = kinematics.float_link_poses(part, needed)[0][:, 0].astype(np.float64)
        assert np.abs(poses[:, 0, 0] - np.cos(part[:, 0])).max() <= 2**-23
        assert np.abs(poses[:, 1, 0] - np.sin(part[:, 0])).max() <= 2**-23


@pytest.mark.parametrize("name", ["panda", "ur10", "baxter", "talos", "pr2", "tiago", "g1", "go2", "kinova"])
def test_poses_of_robots_stay_within_the_bounds(name):
    robot = pc.Robot.load(name)
    for scale in (1, 1000):
        turned, shifted = parts_of_bounds(robot.kinematics, scale * robot.random_configurations(3000, 1))
        assert turned <= 1
        assert shifted <= 1


def test_poses_stay_within_the_bounds_of_those_in_200_bits():
    for name in ("panda", "tiago"):
        robot = pc.Robot.load(name)
        q, table = robot.random_configurations(2, 5), table_of(robot)
        right = np.array([[pose.astype(np.float64) for pose in link_poses(table, row)] for row in q])
        turned, shifted = parts_of_bounds(robot.kinematics, q, right)
        assert turned <= 1
        assert shifted <= 1


@pytest.mark.parametrize("seed", range(40))
def test_random_chains_stay_within_the_bounds(seed):
    """Turns about any axis and slides, some held, with multipliers and offsets, in units from 1e-6 to 1e6 m."""
    rng = np.random.default_rng(seed)
    kinds = rng.choice(POSSIBLE, rng.integers(1, 16)).tolist()
    table = random_chain(rng, kinds)
    unit = 10.0 ** rng.integers(-6, 7)
    placements, on_joints = table.placements.copy(), table.link_placements.copy()
    placements[:, :, 3] *= unit
    on_joints[:, :, 3] *= unit
    table = table._replace(placements=placements, link_placements=on_joints)
    kinematics = core.Kinematics(*table)
    q = random_rows(rng, kinds, 8 * BLOCK) * np.repeat(10.0 ** rng.integers(-3, 5, 8), BLOCK)[:, None]
    turned, shifted = parts_of_bounds(kinematics, q)
    assert turned <= 1
    assert shifted <= 1


def test_directions_that_err_move_what_is_far_along_them():
    """Many turns by one angle about one axis, each rounded the same way, and a link that is a metre away."""
    joints = 44
    every = np.ones((joints, 7))
    eye = np.repeat(np.eye(4)[None, :3], joints, axis=0)
    columns = np.full((joints, 7), -1, dtype=np.int32)
    columns[:, 0] = 0
    link = np.eye(4)[None, :3].copy()
    link[0, 0, 3] = 1.0
    parents, kinds = np.arange(-1, joints - 1, dtype=np.int32), np.full(joints, 2, dtype=np.int32)
    last = np.array([joints - 1], dtype=np.int32)
    table = JointTable(1, parents, kinds, np.zeros((joints, 3)), eye, columns, every, 0 * every, last, link)
    turned, shifted = parts_of_bounds(core.Kinematics(*table), np.linspace(-3, 3, 50_000)[:, None])
    assert 0.03 < turned <= 1
    assert 0.03 < shifted <= 1


def test_one_slide_that_goes_far_is_bounded_by_its_distance():
    """Its errors grow with how far it goes, of which the joints' placements say nothing."""
    rng = np.random.default_rng(2)
    kinds = [2, SLIDE, 3, SLIDE, 0]
    table = random_chain(rng, kinds, held=0.0, mimics=0.0)
    kinematics, needed = core.Kinematics(*table), np.ones(5, dtype=np.uint8)
    last = 0.0
    for distance in (1.0, 1e3, 1e6, 1e12):
        q = random_rows(rng, kinds, 200)
        q[:, 7] = q[:, 21] = distance
        assert max(parts_of_bounds(kinematics, q)) <= 1
        shift = kinematics.float_link_poses(q, needed)[1][0, 4, 1]
        assert last < shift < 1e-4 * max(distance, 10)
        last = shift


def test_what_floats_can_not_pose_is_left_to_doubles():
    needed = np.ones(1, dtype=np.uint8)
    turning = turning_joint(3, [0.6, 0.8, 0.0])
    for bad in (1.1e6, -1e9, np.inf, -np.inf, np.nan):
        q = np.zeros((3 * BLOCK, 1))
        q[BLOCK + 3] = bad
        posed = ~np.isnan(turning.float_link_poses(q, needed)[0]).any(axis=(1, 2, 3))
        assert posed[:BLOCK].all()
        assert not posed[BLOCK + 3]
        assert posed[2 * BLOCK :].all()
    sliding = turning_joint(SLIDE, [0, 0, 1])
    for bad in (1e31, np.inf, np.nan):
        assert np.isnan(sliding.float_link_poses(np.full((1, 1), bad), needed)[0]).all()
    assert np.isnan(turning_joint(3, [0.6, 0.9, 0.0]).float_link_poses(np.zeros((1, 1)), needed)[0]).all()
    for kind in set(range(12)) - set(POSSIBLE):
        rng = np.random.default_rng(kind)
        kinds = [0, kind, 2]
        kinematics = core.Kinematics(*random_chain(rng, kinds, held=0.0))
        assert np.isnan(kinematics.float_link_poses(random_rows(rng, kinds, 3), np.ones(3, dtype=np.uint8))[0]).all()


def test_chains_whose_directions_would_err_too_much_are_left_to_doubles():
    """The bound of a direction's error stays below 2^-14, on which balls inside bodies depend."""
    rng = np.random.default_rng(1)
    for joints in (10, 30, 50, 80):
        kinds = [0] * joints
        kinematics = core.Kinematics(*random_chain(rng, kinds, held=0.0))
        errors = kinematics.float_link_poses(random_rows(rng, kinds, 1), np.ones(joints, dtype=np.uint8))[1]
        assert np.isnan(errors).all() == (joints > 46)
        assert np.isnan(errors).all() or errors[0, -1, 0] <= 2**-14


# ----- verdicts

ROBOTS = [("panda", "bookshelf"), ("panda", "cage"), ("ur5", "kitchen"), ("baxter", "kitchen"), ("tiago", "kitchen")]


@pytest.fixture(scope="module", params=[*ROBOTS, ("talos", None), ("g1", None)])
def checkers(request):
    name, scene = request.param
    robot, scene = pc.Robot.load(name), None if scene is None else pc.Scene.load(scene)
    return tuple(pc.Checker(robot, scene, tuning=pc.Tuning(float_poses=each)) for each in (True, False))


@pytest.mark.parametrize("size", [2, 3, 7, 8, 9, 15, 16, 17, 33, 511, 3000])
def test_verdicts_do_not_depend_on_floats(checkers, size):
    in_floats, plain = checkers
    q = plain.robot.random_configurations(size, seed=size)
    expected = plain.check_states(q)
    assert (in_floats.check_states(q) == expected).all()
    assert (in_floats.check_states(q, threads=2) == expected).all()
    order = np.random.default_rng(size).permutation(size)
    assert (in_floats.check_states(q[order]) == expected[order]).all()
    assert [in_floats.is_valid(row) for row in q[:50]] == expected[:50].tolist()


def test_each_pair_is_counted_once(checkers):
    """And bounds settle nearly as many as for poses in doubles."""
    counted = []
    for floats in (True, False):
        # Blocks in floats learn which pair to try first, and then bound no other one.
        checker = pc.Checker(checkers[0].robot, checkers[0].scene, tuning=pc.Tuning(float_poses=floats, learning=False))
        checker.check_states(checker.robot.random_configurations(2000, seed=1))
        counted.append(checker.statistics())
    decided = ("bounds", "overlaps", "boxes", "skipped", "trees", "unreachable")
    for each in counted:
        assert each["states"] == 2000
        tested = sum(each[name] for name in ("cached_plane", "box_face", "centre_axis", "solver", "nearest_points"))
        assert sum(each[name] for name in decided) + tested == each["pairs"]
    assert counted[0]["bounds"] == pytest.approx(counted[1]["bounds"], rel=1e-3)


JOINTS, LENGTH, HALF = 44, 0.5, 1e-3


def long_chain(folder, shape, base=(0.0, 0.0), slides=False):
    """Links of 0.5 m in a plane, of which the last has a body; the whole may slide, by its last number."""
    links = "".join(f'<link name="link{k}"/>' for k in range(JOINTS))
    body = f'<link name="hand"><collision><geometry>{shape}</geometry></collision></link>'
    names = [*(f"link{k}" for k in range(JOINTS)), "hand"]
    origins = [f"{base[0]!r} {base[1]!r} 0", *[f"{LENGTH} 0 0"] * (JOINTS - 1)]
    joints = "".join(
        f'<joint name="joint{k}" type="revolute"><parent link="{names[k]}"/><child link="{names[k + 1]}"/>'
        f'<origin xyz="{origins[k]}"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        for k in range(JOINTS)
    )
    if slides:
        links += '<link name="rail"/>'
        joints += (
            '<joint name="slide" type="prismatic"><parent link="rail"/><child link="link0"/><axis xyz="1 0 0"/>'
            '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        )
    path = folder / "chain.urdf"
    path.write_text(f'<robot name="chain">{links}{body}{joints}</robot>')
    return pc.Robot.from_urdf(path)


def missed_by_floats(folder, shape, slides=False):
    """Such a chain with its hand at the world's origin, where poses round the least; a configuration, the hand's pose.

    All joints turn by the angle whose rounding adds up to most, so that the hand is off by a hundredth of its size.
    """
    robot = long_chain(folder, shape, slides=slides)
    turns = [name != "slide" for name in robot.joint_names]
    q = np.random.default_rng(0).uniform(-0.2, 0.2, (4000, 1)) * turns
    needed = np.ones(robot.kinematics.link_count, dtype=np.uint8)
    hand = robot.link_names.index("hand")
    hands = robot.kinematics.link_poses(q, needed)[:, hand, :2, 3]
    off = robot.kinematics.float_link_poses(q, needed)[0][:, hand, :2, 3] - hands
    worst = np.linalg.norm(off, axis=1).argmax()
    assert np.linalg.norm(off[worst]) > HALF / 100
    robot = long_chain(folder, shape, tuple((-hands[worst]).tolist()), slides)
    return robot, q[worst], robot.link_poses(q[worst][None])[0, hand]


@pytest.mark.parametrize("slides", [False, True])
@pytest.mark.parametrize("shape", [f'<sphere radius="{HALF}"/>', f'<box size="{2 * HALF} {2 * HALF} {2 * HALF}"/>'])
def test_contacts_that_floats_miss_by_far(tmp_path, shape, slides):
    """Obstacles on all sides meet the hand, or miss it, by 1e-9 m. Where a joint slides, radii are by state."""
    robot, row, pose = missed_by_floats(tmp_path, shape, slides)
    for axis in np.vstack([np.eye(3), -np.eye(3)]):
        for gap in (-1e-9, 1e-9):
            place = pose.copy()
            place[:3, :3] = np.eye(3) if "sphere" in shape else pose[:3, :3]
            place[:3, 3] += place[:3, :3] @ axis * (2 * HALF + gap)
            scene = pc.Scene("touched")
            scene.add_box("box", [2 * HALF] * 3, place)
            for overlaps in (True, False):
                checker = pc.Checker(robot, scene, tuning=pc.Tuning(reach=False, overlaps=overlaps))
                assert checker.is_valid(row) == (gap > 0)
                assert (checker.check_states(np.repeat(row[None], 17, axis=0)) == (gap > 0)).all()


def test_crossed_edges_that_floats_miss_by_far(tmp_path):
    """Bars that cross the hand on all sides, an edge facing an edge of the hand, meet it or miss it by 1e-9 m.

    No face separates them. The hand stands upright on the plane in which floats miss it.
    """
    shape = f'<box size="{2 * HALF} {2 * HALF} {6 * HALF}"/>'
    robot, row, pose = missed_by_floats(tmp_path, shape)
    for quarter in range(4):
        side = Rotation.from_euler("z", (quarter + 0.5) * np.pi / 2)  # its x-axis points along a diagonal of the hand
        for gap in (-1e-9, 1e-9):
            place = pose.copy()
            place[:3, 3] += pose[:3, :3] @ side.apply([2 * np.sqrt(2) * HALF + gap, 0, 0])
            place[:3, :3] = pose[:3, :3] @ (side * Rotation.from_euler("y", np.pi / 4)).as_matrix()
            scene = pc.Scene("crossed")
            scene.add_box("bar", [2 * HALF, 6 * HALF, 2 * HALF], place)
            checker = pc.Checker(robot, scene, tuning=pc.Tuning(reach=False))
            assert checker.is_valid(row) == (gap > 0)
            assert (checker.check_states(np.repeat(row[None], 17, axis=0)) == (gap > 0)).all()


# Half of what floats at 8,192 m are apart by, nearly: such numbers are rounded by as much as any.
NEARLY_HALF = 0.98 * 2.0**-11


@pytest.mark.parametrize(
    ("joint", "far"),
    [
        (f'type="revolute"><origin xyz="{8192 + NEARLY_HALF!r} 0 0"/><limit lower="-1" upper="1"', 0.0),
        ('type="prismatic"><limit lower="0" upper="9000"', 8192 + NEARLY_HALF),
    ],
)
def test_contacts_of_what_is_far_away(tmp_path, joint, far):
    """The link's origin and the centre of its ball are rounded away from an obstacle, each by half a step of floats.

    States near the origin are judged before.
    """
    centre, face = 0.25 + NEARLY_HALF, 8192.75 + 1e-6  # which is rounded outwards by no more
    radius = face - (8192 + NEARLY_HALF + centre) + 1e-5
    path = tmp_path / "far.urdf"
    path.write_text(
        f'<robot name="far"><link name="base"/><joint name="joint" {joint} effort="1" velocity="1"/><axis xyz="1 0 0"/>'
        f'<parent link="base"/><child link="hand"/></joint><link name="hand"><collision><origin xyz="{centre!r} 0 0"/>'
        f'<geometry><sphere radius="{radius!r}"/></geometry></collision></link></robot>'
    )
    scene = pc.Scene("touched")
    scene.add_box("box", [1.0, 1.0, 1.0], at(face + 0.5))
    checker = pc.Checker(pc.Robot.from_urdf(path), scene, tuning=pc.Tuning(reach=False, overlaps=False))
    checker.check_states(np.zeros((17, 1)))
    assert not checker.check_states(np.full((17, 1), far)).any()


def beside_by_the_bound(folder, **switches):
    """A checker at whose zero filters see a gap in poses in doubles, and not in floats, whose bound is wider."""
    robot = long_chain(folder, f'<sphere radius="{HALF}"/>')
    hand = robot.link_poses(np.zeros((1, JOINTS)))[0, -1]
    robot = long_chain(folder, f'<sphere radius="{HALF}"/>', tuple((-hand[:2, 3]).tolist()))
    needed = np.ones(robot.kinematics.link_count, dtype=np.uint8)
    bound = robot.kinematics.float_link_poses(np.zeros((1, JOINTS)), needed)[1][0, -1, 1]
    place, scene = np.eye(4), pc.Scene("beside")
    place[0, 3] = 2 * HALF + bound / 2
    scene.add_box("box", [2 * HALF] * 3, place)
    return pc.Checker(robot, scene, tuning=pc.Tuning(reach=False, boxes=False, **switches))


def test_sets_are_posed_in_floats_first(tmp_path):
    """So that all pairs are left."""
    tested = {}
    for in_floats in (True, False):
        checker = beside_by_the_bound(tmp_path, float_poses=in_floats)
        assert checker.check_states(np.zeros((17, JOINTS))).all()
        tested[in_floats] = 17 - checker.statistics()["bounds"]
    assert tested[False] == 0
    assert tested[True] == 17  # all of them: so few do not tell that doubles would be faster


def test_sets_that_floats_leave_open_are_posed_in_doubles(tmp_path):
    """All states are near by the wider bound of floats: after some hundreds, nearly all blocks are posed in doubles."""
    checker = beside_by_the_bound(tmp_path)
    q = np.zeros((8192, JOINTS))
    assert checker.check_states(q).all()
    tested = len(q) - checker.statistics()["bounds"]
    assert 256 < tested < 2048


def test_two_states_at_a_time(checkers):
    """In doubles, these have no lanes over states."""
    plain = checkers[1]
    q = plain.robot.random_configurations(400, seed=5)
    expected = plain.check_states(q)
    for checker in checkers:
        assert (np.concatenate([checker.check_states(q[k : k + 2]) for k in range(0, len(q), 2)]) == expected).all()


@pytest.mark.parametrize("seed", range(12))
def test_random_robots_have_the_same_verdicts(tmp_path, seed):
    """Slides, turns about any axis, mimics; sets in which some angles are too large for floats, or most states open."""
    rng = np.random.default_rng(seed)
    tree = random_tree(rng, int(rng.integers(2, 12)), sizes=(0.3, 0.2, 0.4), reach=0.6, placed=True)
    robot, scene = tree.robot(tmp_path), pc.Scene("boxes")
    for k in range(10):
        pose = np.vstack([random_placement(rng), [0, 0, 0, 1]])
        scene.add_box(f"box{k}", rng.uniform(0.05, 0.6, 3).tolist(), pose)
    in_floats, plain = (pc.Checker(robot, scene, tuning=pc.Tuning(float_poses=each)) for each in (True, False))
    q = robot.random_configurations(1500, seed)
    endless = ~np.isfinite(robot.upper)
    q[::97, endless] *= 1e6
    for part in (q, q[:5], np.repeat(q[plain.check_states(q)][:1], 100, axis=0)):
        expected = plain.check_states(part)
        assert (in_floats.check_states(part) == expected).all()
        assert (in_floats.check_states(part[::-1]) == expected[::-1]).all()
