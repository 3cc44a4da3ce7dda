"""MJCF files as users have them: names, limits, obstacles, motions, proofs, commands, and what is refused."""

import importlib.util
import itertools
import sys
import warnings
from pathlib import Path

import mujoco
import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies import mjcf_files, mjcf_worker
from plannercheck.bodies.shapes import Box, Capsule, Cylinder, Hull, Sphere
from plannercheck.checking.pair_table import pair_table
from plannercheck.cli.main import main

MJCF = """<mujoco model="arm">
<default><default class="drawn"><geom contype="0" conaffinity="0"/></default>
  <default class="finger"><joint range="0 0.04"/><geom contype="2" conaffinity="4"/></default></default>
<asset><mesh name="tetra" vertex="0 0 0 .1 0 0 0 .1 0 0 0 .1"/></asset>
<worldbody>
  <body name="base" pos="0 0 1"><geom type="box" size="0.1 0.2 0.3"/><geom class="drawn" type="sphere" size="9"/>
    <body name="upper" pos="0 0 1"><joint name="lift" type="slide" axis="0 0 1" range="0 1.5"/>
      <geom type="capsule" fromto="0 0 0 0 0 0.5" size="0.05"/>
      <geom type="cylinder" size="0.1 0.2" pos="0.1 0 0"/>
      <body name="lower" pos="0 0 0.8"><joint name="turn" type="hinge" axis="0 1 0" range="-90 45"/>
        <geom type="sphere" size="0.1" pos="0 0 0.3"/>
        <body name="tip" pos="0 0 0.5"><geom type="mesh" mesh="tetra"/></body>
        <body name="left" pos="0.2 0 0.5"><joint name="grip" type="slide" axis="1 0 0" class="finger"/>
          <geom class="finger" type="box" size=".01 .01 .01"/></body>
      </body>
    </body>
  </body>
</worldbody>
<contact><exclude body1="upper" body2="tip"/></contact>
</mujoco>"""

TABLE = '<body name="table" pos="1 0 0"><geom type="box" size="1 1 1"/></body>'
FLOOR = f'<geom name="floor" type="plane" size="5 5 1"/>{TABLE}'


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text(MJCF)
    return path


def file_of(tmp_path, world, before="", after=""):
    path = tmp_path / "file.xml"
    path.write_text(f"<mujoco>{before}<worldbody>{world}</worldbody>{after}</mujoco>")
    return path


def test_bodies_joints_and_limits_are_mujocos(path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        robot = pc.Robot.load(path)
    assert robot.name == "arm"
    assert robot.joint_names == ("lift", "turn", "grip")
    assert robot.link_names == ("world", "base", "upper", "lower", "tip", "left")
    assert np.allclose(robot.lower, [0, -np.pi / 2, 0])
    assert np.allclose(robot.upper, [1.5, np.pi / 4, 0.04])
    shapes = {(body.link, type(body.shape)): body.shape for body in robot.bodies}
    assert shapes["base", Box] == Box((0.2, 0.4, 0.6))
    assert shapes["upper", Capsule] == Capsule(0.05, 0.5)
    assert shapes["upper", Cylinder] == Cylinder(0.1, 0.4)
    assert shapes["lower", Sphere] == Sphere(0.1)
    assert len(shapes["tip", Hull].vertices) == 4
    assert [body.name for body in robot.bodies][:3] == ["base/geom0", "upper/geom0", "upper/geom1"]
    poses = robot.link_poses([0.25, np.pi / 2, 0.0])
    assert np.allclose(poses[robot.link_index("tip"), :3, 3], [0.5, 0, 3.05])


def links_of(robot):
    return {frozenset(robot.bodies[k].link for k in pair) for pair in robot.self_pairs}


def test_an_srdf_and_a_yaml_leave_out_more_pairs(path, tmp_path):
    base = {frozenset(("base", link)) for link in ("upper", "lower", "tip")}
    assert links_of(pc.Robot.load(path)) == base
    srdf = tmp_path / "arm.srdf"
    srdf.write_text(
        '<robot name="arm"><group name="all"><chain base_link="world" tip_link="left"/></group>'
        '<disable_collisions link1="base" link2="upper" reason="Adjacent"/></robot>'
    )
    robot = pc.Robot.from_urdf(path, srdf, group="all")
    assert robot.joint_names == ("lift", "turn", "grip")
    assert links_of(robot) == base - {frozenset(("base", "upper"))}
    described = tmp_path / "arm.yaml"
    described.write_text("urdf: arm.xml\ndisabled_pairs: [{reason: far, pairs: [[base, tip]]}]\n")
    assert links_of(pc.Robot.load(described)) == base - {frozenset(("base", "tip"))}


def test_several_joints_on_a_body_each_have_a_link_and_a_place_in_groups(tmp_path):
    world = '<body name="a"><joint name="x" type="slide"/><joint name="y"/><geom size=".1"/></body>'
    path, srdf = file_of(tmp_path, world), tmp_path / "r.srdf"
    srdf.write_text('<robot name="r"><group name="all"><chain base_link="world" tip_link="a"/></group></robot>')
    robot = pc.Robot.from_urdf(path, srdf, group="all")
    assert robot.link_names == ("world", "a/x", "a")
    assert robot.joint_names == ("x", "y")


def test_joints_outside_a_group_are_where_the_file_begins(tmp_path):
    world = (
        '<body name="box" pos="1 2 3" quat="0 0 1 0"><freejoint name="free"/><geom size=".1"/></body>'
        '<body name="a"><joint name="j" ref="30" range="40 50"/><joint name="k" ref="0.5"/><geom size=".1"/></body>'
    )
    robot = pc.Robot.from_urdf(file_of(tmp_path, world), group=["k"])
    pose = robot.link_poses(robot.reference)[robot.link_index("box")]
    assert np.allclose(pose[:3, 3], [1, 2, 3])
    assert np.allclose(pose[:3, :3], np.diag([-1, 1, -1]))
    assert np.allclose(robot.reference, np.deg2rad(0.5))
    assert np.allclose(robot.expand(robot.reference)[7:], np.deg2rad([40, 0.5]))


def test_linear_equalities_are_mimic_joints(tmp_path):
    world = (
        '<body name="a"><joint name="j" ref="1"/><geom size=".1"/>'
        '<body name="b"><joint name="k" ref="2"/><geom size=".1"/></body></body>'
    )
    after = '<equality><joint joint1="k" joint2="j" polycoef=".1 -2"/></equality>'
    path = file_of(tmp_path, world, '<compiler angle="radian"/>', after)
    robot = pc.Robot.load(path)
    assert robot.mimics["k"].leader == "j"
    grouped = pc.Robot.from_urdf(path, group=["j"])
    j = 1.7
    assert np.allclose(grouped.expand([j]), [j, 2 + 0.1 - 2 * (j - 1)])


@pytest.mark.parametrize(
    ("equality", "message"),
    [
        ('<joint name="e" joint1="k" joint2="j" polycoef="0 1 .5"/>', "equality 'e' has polycoef"),
        ('<joint joint1="k" joint2="j"/><joint name="e" joint1="k" joint2="l"/>', "'e' is a second one for joint 'k'"),
        ('<joint joint1="k" joint2="j"/><joint joint1="j" joint2="k"/>', "mimics itself"),
    ],
)
def test_other_equalities_of_joints_are_refused(tmp_path, equality, message):
    world = "".join(f'<body name="{name}"><joint name="{name}"/><geom size=".1"/></body>' for name in "jkl")
    with pytest.raises(pc.PlannercheckError, match=rf"file\.xml: .*{message}"):
        pc.Robot.load(file_of(tmp_path, world, "", f"<equality>{equality}</equality>"))


@pytest.mark.parametrize(
    ("before", "world", "after", "message"),
    [
        ("", FLOOR, "", r"floor, table/geom0: obstacles, no part .*Scene\.from_mjcf"),
        ("", "", '<equality><weld name="w" body1="a"/></equality>', "w: equalities that bind no two joints"),
        ("", "", '<equality><joint name="e" joint1="j"/></equality>', "e: equalities that bind no two joints"),
        ("", '<body name="m"><joint name="b" type="ball" range="0 9"/><geom size=".1"/></body>', "", "b: ball joints"),
        ("", '<body name="m" mocap="true"><body><joint/><geom size="1"/></body></body>', "", "m: mocap bodies"),
        ('<option><flag contact="disable"/></option>', "", "", "disables contacts"),
        ('<default><geom contype="0" conaffinity="0"/></default>', "", "", "no geoms that collide"),
    ],
)
def test_what_the_robot_does_not_do_is_warned_of_once(tmp_path, before, world, after, message):
    path = file_of(tmp_path, f'{world}<body name="a"><joint name="j"/><geom name="g" size=".1"/></body>', before, after)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        pc.Robot.load(path)
    assert len(caught) == 1
    with pytest.warns(RuntimeWarning, match=message):
        pc.Robot.load(path)


JOINT = '<joint name="j"/><geom name="g" {}/>'


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # MuJoCo's of a NaN
@pytest.mark.parametrize(
    ("world", "message"),
    [
        (JOINT.format(""), "MuJoCo does not compile it: .*size"),
        (JOINT.format('type="box" size="1 1"'), "MuJoCo does not compile it"),
        ('<joint name="j" axis="0 0 0"/><geom size="1"/>', "axis too small"),
        ('<joint name="j" range="90 -90"/><geom size="1"/>', "joint 'j' has the range .* lower must be first"),
        ('<joint type="screw"/><geom size="1"/>', "MuJoCo does not compile it: .*screw"),
        (JOINT.format('type="mesh" mesh="nope"'), "MuJoCo does not compile it: .*nope"),
        (JOINT.format('size="1" pos="nan 0 0"'), "geom 'g' has geom_pos"),
        ('<geom size="1"/>', "has no joints, so that it is no robot but obstacles"),
    ],
)
def test_what_can_not_be_taken_is_named(tmp_path, world, message):
    path = file_of(tmp_path, f"<body>{world}</body>")
    with pytest.raises(pc.PlannercheckError, match=rf"MJCF .*file\.xml:? .*{message}"):
        pc.Robot.load(path)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # MuJoCo 4's of a flex without forces
def test_a_flex_is_refused_as_robot_and_as_obstacle(tmp_path):
    flex = '<flexcomp name="cloth" type="grid" count="2 2 2" spacing=".1 .1 .1" radius=".01" dim="3" mass="1"/>'
    path = file_of(tmp_path, flex)
    for load in (pc.Robot.load, pc.Scene.from_mjcf):
        with pytest.raises(pc.PlannercheckError, match="flex 'cloth' can't be taken"):
            load(path)


def test_counts_that_would_fill_the_memory_are_refused(tmp_path):
    path = file_of(tmp_path, '<replicate count="1000000000" offset="1 0 0"><geom size=".1"/></replicate>')
    with pytest.raises(pc.PlannercheckError, match=r"file\.xml: MuJoCo.*: does a count repeat something too often\?"):
        pc.Robot.load(path)


def test_what_mujoco_says_is_a_warning(path, monkeypatch):
    said = {"said": np.array("WARNING: odd\n\n")}
    monkeypatch.setattr(mjcf_files, "_compiled", lambda path: {**said, **mjcf_worker.compiled(path)})
    with pytest.warns(RuntimeWarning, match=r"arm\.xml: MuJoCo says: WARNING: odd$"):
        pc.Robot.load(path)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # MuJoCo 4's of a matrix of inertia
def test_mujoco_writes_nothing_to_the_terminal_and_the_folder(tmp_path, monkeypatch, capfd):
    folder = tmp_path / "here"
    folder.mkdir()
    monkeypatch.chdir(folder)
    path = file_of(tmp_path, '<body><joint/><joint/><geom size="1"/></body>')
    pc.Robot.load(path)
    assert capfd.readouterr() == ("", "")
    assert not list(folder.iterdir())


def test_files_that_a_file_names_are_found_beside_it(tmp_path, monkeypatch):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "tetra.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    )
    (tmp_path / "more.xml").write_text(
        '<mujoco><worldbody><body name="b"><joint/><geom size="1"/></body></worldbody></mujoco>'
    )
    before = '<compiler meshdir="parts"/><asset><mesh file="tetra.obj"/></asset>'
    path = file_of(tmp_path, '<body name="a"><joint/><geom type="mesh" mesh="tetra"/></body>', before)
    attached, included = tmp_path / "attached.xml", tmp_path / "included.xml"
    attached.write_text(
        '<mujoco><asset><model name="m" file="more.xml"/></asset>'
        '<worldbody><body name="a"><joint/><geom size="1"/></body>'
        '<attach model="m" body="b" prefix="new_"/></worldbody></mujoco>'
    )
    included.write_text('<mujoco><include file="file.xml"/><include file="more.xml"/></mujoco>')
    monkeypatch.chdir("/")
    for file, other in ((attached, "new_b"), (included, "b")):
        robot = pc.Robot.load(file)
        assert set(robot.link_names) == {"world", other, "a"}
        assert len(robot.self_pairs) == 1
    solid = pc.Robot.load(path, geometry={"a": "solid"})
    assert isinstance(next(body.shape for body in solid.bodies if body.link == "a"), pc.Solid)


def test_the_extra_is_named_where_mujoco_is_missing(path, monkeypatch):
    found = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *more: None if name == "mujoco" else found(name, *more)
    )
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(pc.PlannercheckError, match=r"MJCF files need mujoco, .*: pip install 'plannercheck\[mjcf\]'"):
        pc.Robot.load(path)


def test_a_floating_root_is_the_files(path):
    text = MJCF.replace('<body name="base" pos="0 0 1">', '<body name="base" pos="0 0 1"><freejoint name="root"/>')
    path.write_text(text)
    robot = pc.Robot.load(path)
    assert robot.nq == 10
    assert np.isclose(np.linalg.norm(robot.random_configurations(1, 0)[0, 3:7]), 1)
    with pytest.raises(pc.PlannercheckError, match="give the root body a <freejoint/>"):
        pc.Robot.from_urdf(path, floating=True)


def test_obstacles_are_a_scene_in_which_masks_count_geom_by_geom(path, tmp_path):
    wall = '<geom name="wall" type="box" size=".1 1 1" pos="2 0 0" contype="4" conaffinity="0"/>'
    path.write_text(MJCF.replace("<worldbody>", f"<worldbody>{FLOOR}{wall}"))
    with pytest.warns(RuntimeWarning, match="obstacles"):
        robot = pc.Robot.load(path)
    scene = pc.Scene.load(path)
    assert scene.object_names == ("floor", "wall", "table/geom0")
    saved = tmp_path / "scene.yaml"
    scene.save(saved)
    for each in (scene, pc.Scene.load(saved), scene.copy()):
        table = pair_table(robot, each, True, "robot")
        labels = [*(body.link for body in robot.bodies), *each.body_objects]
        pairs = {frozenset(labels[k] for k in pair) for pair in table.pairs[table.self_count :].tolist()}
        moving = ("upper", "lower", "tip")
        assert pairs == {frozenset(p) for p in [("wall", "left")]} | {
            frozenset((link, name)) for link in moving for name in ("floor", "table/geom0")
        }
        assert not len(table.static)  # the base stands where the floor does
    pieces = pc.Robot.load(path, geometry="solid")
    assert len(pair_table(pieces, scene, True, "robot").pairs) == len(pair_table(robot, scene, True, "robot").pairs)


def test_a_robot_is_no_scene(path):
    with pytest.warns(RuntimeWarning, match="has no obstacles that collide: the scene is empty"):
        assert pc.Scene.from_mjcf(path).object_names == ()
    with pytest.raises(pc.PlannercheckError, match=r"gone\.xml does not exist"):
        pc.Scene.from_mjcf(path.parent / "gone.xml")


JOINTS = {
    "hinge with ref": '<joint ref="40" pos=".2 0 0" axis="1 2 3"/>',
    "hinge and slide": '<joint type="slide" ref=".1"/><joint pos=".2 0 0" axis="1 1 0"/>',
    "two hinges and a slide": '<joint axis="1 0 0" pos="0 .1 0"/><joint axis="0 1 0"/><joint type="slide"/>',
    "ball": '<joint type="ball" pos=".1 .2 0"/>',
    "free": "<freejoint/>",
}


@pytest.mark.parametrize("joints", JOINTS.values(), ids=JOINTS)
def test_motions_are_judged_and_proved_on_joints_of_all_kinds(tmp_path, joints):
    path = file_of(tmp_path, f'<body pos=".1 0 0">{joints}<geom type="box" size=".3 .1 .05"/></body>')
    robot, scene = pc.Robot.load(path), pc.Scene()
    scene.add_sphere("ball", 0.1, [[1, 0, 0, 0.7], [0, 1, 0, 0.4], [0, 0, 1, 0.2], [0, 0, 0, 1]])
    checker = pc.Checker(robot, scene)
    model = mujoco.MjModel.from_xml_path(str(path))
    q = robot.random_configurations(40, 3)
    q[:, : 3 if robot.nq == 7 else 0] *= 0.3
    free = q[checker.check_states(q)]
    kept = [(a, b) for a, b in itertools.pairwise(free) if checker.check_motion(a, b)]
    assert kept
    assert model.nq == robot.nq
    proof = checker.certify_motions(*map(np.array, zip(*kept[:2], strict=True)))
    for each in proof if isinstance(proof, list | tuple) else [proof]:
        each.verify()


def test_commands_take_them(path, tmp_path):
    np.save(tmp_path / "q.npy", [[0.8, 0.1, 0.02]])
    robot = ("--robot", str(path))
    assert main(["inspect", *robot, "--states", "20"]) == 0
    assert main(["validate", *robot, str(tmp_path / "q.npy")]) == 0
    assert main(["view", *robot, "--html", str(tmp_path / "page.html")]) == 0
    assert main(["acm", *robot, "--states", "20", "--output", str(tmp_path / "arm.srdf")]) == 0
    assert main(["validate", *robot, "--srdf", str(tmp_path / "arm.srdf"), str(tmp_path / "q.npy")]) == 0


def test_commands_take_their_obstacles(path, tmp_path, capsys):
    path.write_text(MJCF.replace("<worldbody>", f"<worldbody>{FLOOR}"))
    both = ("--robot", str(path), "--scene", str(path))
    assert main(["inspect", *both, "--states", "20"]) == 0
    assert "floor" in capsys.readouterr().out
    start, goal = "0.8,0,0.01", "1.4,0.3,0.02"
    output = tmp_path / "path.npy"
    assert main(["plan", *both, "--start", start, "--goal", goal, "--output", str(output)]) == 0
    proof = tmp_path / "path.proof.json"
    assert main(["validate", *both, "--path", str(output), "--certify", "--proof", str(proof)]) == 0
    assert main(["verify", str(proof), *both]) == 0
    assert "model: confirmed" in capsys.readouterr().out


def test_sdf_files_are_refused_with_what_to_do(tmp_path, capsys):
    path = tmp_path / "r.sdf"
    path.write_text('<?xml version="1.0"?><sdf version="1.9"><model name="r"><link name="a"/></model></sdf>')
    with pytest.raises(pc.PlannercheckError, match=r"r\.sdf is an SDF file, .*: convert it into a URDF"):
        pc.Robot.load(path)
    assert main(["inspect", "--robot", str(path)]) == 2
    assert "convert it into a URDF" in capsys.readouterr().err


def test_a_proof_is_confirmed_for_an_mjcf_file(path, tmp_path, capsys):
    """`verify --robot` reads a robot as `validate` does."""
    states, proof = tmp_path / "path.npy", tmp_path / "path.proof.json"
    np.save(states, [[1.0, 0.0, 0.01], [1.2, -0.3, 0.02]])
    assert main(["validate", "--robot", str(path), "--path", str(states), "--certify", "--proof", str(proof)]) == 0
    capsys.readouterr()
    assert main(["verify", str(proof), "--robot", str(path)]) == 0
    assert "model: confirmed" in capsys.readouterr().out
    for old, new, fault in (
        ('pos="0 0 0.8"', 'pos="0 0 0.9"', "joint 'turn' is not as the MJCF has it"),
        ('axis="0 1 0"', 'axis="1 0 0"', "joint 'turn' is not as the MJCF has it"),
        ('body name="tip"', 'body name="top"', "links of the proof and of the MJCF differ"),
        ('size="0.1" pos="0 0 0.3"', 'size="0.2" pos="0 0 0.3"', "has another shape than in the files"),
    ):
        other = tmp_path / "other.xml"
        changed = MJCF.replace(old, new)
        other.write_text(changed.replace('body2="tip"', 'body2="top"') if "top" in new else changed)
        assert main(["verify", str(proof), "--robot", str(other)]) == 1, new
        assert fault in capsys.readouterr().out


def test_the_worker_is_where_the_reader_looks_for_it():
    assert Path(importlib.util.find_spec("plannercheck.bodies.mjcf_worker").origin).is_file()
