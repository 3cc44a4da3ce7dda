"""Robots of a thousand links load and are checked in memory and time that grow with the links, not with their square.

What is screened out in arrays is held against the proofs themselves, with the screen taken away; tables of pairs
against Pinocchio's; poses of large models, joint by joint, against Pinocchio's own.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from pinocchio_geometry import pinocchio_geometry

import plannercheck as pc
from plannercheck.checking.reach_bounds import Chains
from plannercheck.checking.reach_screens import Screen
from plannercheck.robots import kinematics
from plannercheck.robots.self_pairs import self_pairs
from plannercheck.robots.srdf import Srdf, read_srdf
from plannercheck.robots.urdf import link_tree, read_model

LOADING = Path(__file__).parents[1] / "benchmarks" / "loading.py"

# Of all that such a process may reserve, bytes; Pinocchio's Data of 250 joints alone has more.
MEMORY = 1 << 30

LIMITED = f"""
import resource, runpy, sys
resource.setrlimit(resource.RLIMIT_AS, ({MEMORY}, {MEMORY}))
sys.argv = [{str(LOADING)!r}, "--links", "250"]
runpy.run_path(sys.argv[0], run_name="__main__")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits memory")
def test_hundreds_of_links_take_little_memory_and_time():
    done = subprocess.run([sys.executable, "-c", LIMITED], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr[-2000:]
    own, with_obstacles = 250 * 249 // 2 - 249, 249 * 10
    assert f"250 links: {own + with_obstacles:8} pairs" in done.stdout


@pytest.mark.parametrize("name", ["panda", "talos", "ur10"])
def test_large_models_are_posed_by_the_same_products(name, monkeypatch):
    robot = pc.Robot.load(name)
    rows = robot.random_configurations(5, 0)
    arguments = robot.model, robot.configuration_map, robot.frames, rows
    right = kinematics.pinocchio_poses(*arguments)
    data = robot.model.createData()
    full = robot.configuration_map.expand(rows)[0]
    pin.forwardKinematics(robot.model, data, full)
    joints = kinematics.joint_placements(robot.model, full)
    assert all(np.array_equal(a.homogeneous, b.homogeneous) for a, b in zip(joints, data.oMi, strict=True))
    monkeypatch.setattr(kinematics, "_MOST_FOR_DATA", 0)
    assert np.array_equal(kinematics.pinocchio_poses(*arguments), right)


def branched(depth: int, seed: int) -> str:
    """A tree with sliding, fixed, continuous and mimicking joints, and several bodies on some links."""
    rng = np.random.default_rng(seed)
    body = '<collision><origin xyz="{} 0 0.02"/><geometry><box size="{} 0.03 0.05"/></geometry></collision>'
    links = [
        f'<link name="l{k}">{"".join(body.format(0.05 * i, 0.04) for i in range(rng.integers(0, 3)))}</link>'
        for k in range(depth)
    ]
    joints = []
    kinds: dict[int, str] = {}
    for k in range(1, depth):
        kind = kinds[k] = str(rng.choice(["revolute", "prismatic", "fixed", "continuous", "revolute"]))
        parent = max(0, k - int(rng.integers(1, 4)))
        limit = '<limit lower="-0.6" upper="0.9" effort="1" velocity="1"/>'
        leader = next((j for j in range(1, k) if kinds[j] == kind == "revolute"), None)
        mimic = f'<mimic joint="j{leader}" multiplier="0.5"/>' if leader and rng.random() < 0.4 else ""
        axis = rng.choice(["1 0 0", "0 1 0", "0 0 1"])
        joints.append(
            f'<joint name="j{k}" type="{kind}"><parent link="l{parent}"/><child link="l{k}"/>'
            f'<origin xyz="{rng.uniform(0.05, 0.3):.3f} 0 0.1"/><axis xyz="{axis}"/>{limit}{mimic}</joint>'
        )
    return f'<robot name="tree{seed}">{"".join(links + joints)}</robot>'


def joints_that_move(urdf: str) -> list[str]:
    model = pin.buildModelFromXML(urdf)
    followers = {
        part.split('"')[0] for part in urdf.split('<joint name="')[1:] if "<mimic" in part.split("</joint>")[0]
    }
    return [name for name in list(model.names)[1:] if name not in followers]


@pytest.mark.parametrize("seed", range(12))
def test_what_is_screened_out_could_not_have_been_proved(seed, tmp_path, monkeypatch):
    urdf = tmp_path / "tree.urdf"
    urdf.write_text(branched(14, seed))
    # Two of the same: a robot remembers what is proved of it.
    robot, again = (pc.Robot.from_urdf(urdf, group=joints_that_move(urdf.read_text())) for _ in range(2))
    asked = []
    may = Screen.may_be_proved

    def told(self: Screen, pairs: np.ndarray, columns: int) -> np.ndarray:
        asked.append(may(self, pairs, columns))
        return asked[-1]

    monkeypatch.setattr(Screen, "may_be_proved", told)
    screened = pc.Checker(robot)
    monkeypatch.setattr(Screen, "may_be_proved", lambda self, pairs, columns: np.ones(len(pairs), dtype=bool))
    whole = pc.Checker(again)
    assert np.array_equal(screened.unreachable, whole.unreachable)
    assert np.array_equal(screened.static, whole.static)
    labels = {(a.link, b.link) for a, b in (map(robot.bodies.__getitem__, row) for row in whole.pairs[whole.static])}
    assert all(at_rest(robot, a, b) for a, b in labels)
    assert len(asked) == 1

    chains = chains_of(whole)
    forks = chains.screen.forks(whole.pairs.astype(np.int64))
    for (a, b), fork in zip(whole.pairs.tolist(), chains.screen._depth[forks].tolist(), strict=True):
        shared = [x for x, y in zip(chains.chain(a), chains.chain(b), strict=False) if x == y]
        assert fork == len(shared)


def chains_of(checker: pc.Checker) -> Chains:
    reach = checker._proofs._reach
    assert reach is not None
    return reach._chains


def at_rest(robot: pc.Robot, a: str, b: str) -> bool:
    """Whether two links keep their places against each other, seen at random configurations."""
    poses = robot.link_poses(robot.random_configurations(6, 1))
    first, second = (poses[:, robot.link_index(link)] for link in (a, b))
    relative = np.linalg.inv(first) @ second
    return bool(np.abs(relative - relative[0]).max() < 1e-9)


@pytest.mark.parametrize("name", ["panda", "talos", "baxter"])
def test_frames_are_posed_against_each_other_as_in_the_world(name):
    robot = pc.Robot.load(name)
    chains = chains_of(pc.Checker(robot))
    rng = np.random.default_rng(0)
    rows = robot.random_configurations(3, 0)
    count = chains._frames.link_joints.size
    for size in (1, 2, 2, 2, 3, 5, count):
        frames = rng.choice(count, size, replace=False).tolist()
        around = chains.neighbourhood(frames)
        near = around.poses(rows)[:, [around.place[frame] for frame in frames]]
        far = chains.poses(rows, frames)[:, frames]
        relative = [np.linalg.inv(poses[:, :1]) @ poses for poses in (near, far)]
        np.testing.assert_allclose(*relative, atol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_self_pairs_of_any_srdf_are_pinocchios(seed, tmp_path):
    rng = np.random.default_rng(seed)
    urdf, srdf = tmp_path / "tree.urdf", tmp_path / "tree.srdf"
    urdf.write_text(branched(12, seed))
    names = [f"l{rng.integers(0, 14)}" for _ in range(40)]  # some twice, some of no link, some with itself
    rows = "".join(
        f'<disable_collisions link1="{a}" link2="{b}"/>' for a, b in zip(names[::2], names[1::2], strict=True)
    )
    srdf.write_text(f'<robot name="tree{seed}">{rows}</robot>')
    model = read_model(urdf)
    geometry = pinocchio_geometry(model, urdf)
    robot = pc.Robot.from_urdf(urdf)
    joints = np.array([each.parentJoint for each in geometry.geometryObjects])
    found = self_pairs(joints, robot.bodies, Srdf(srdf, read_srdf(srdf)), link_tree(model), ())
    geometry.addAllCollisionPairs()
    pin.removeCollisionPairs(model, geometry, str(srdf), False)
    assert found.tolist() == [[pair.first, pair.second] for pair in geometry.collisionPairs]
