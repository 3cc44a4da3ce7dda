"""Cells in files: robots of every kind of file, saved and loaded; faults of files; pairs that files leave out."""

import itertools

import numpy as np
import pytest
from sample_robots import SRDF, URDF, names_of

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.common.errors import PlannercheckError
from plannercheck.robots.description import description_of
from plannercheck.robots.loading import collision_meshes
from plannercheck.view.surfaces import visual_meshes

MJCF = """<mujoco model="swing"><worldbody><body name="bar" pos="0 0 1">
<joint name="hinge" type="hinge" axis="0 1 0" range="-1 1" limited="true"/>
<geom name="g" type="capsule" size="0.1 0.3"/>
<body name="bob" pos="0 0 -1"><joint name="slide" type="slide" axis="0 0 1" range="0 1" limited="true"/>
<geom name="ball" type="sphere" size="0.2"/></body></body></worldbody></mujoco>"""
POSE = "pose: {position: [4, 0, 0.5], rpy: [0, 0, 1.5]}"

# One robot of each kind of file, as a cell's file names it, and how many joints it has of its own.
KINDS = {
    "shipped": ("load: panda", 7),
    "yaml": ("load: arm.yaml", 2),
    "urdf": ("load: arm.urdf", 3),
    "group of an SRDF": ("load: arm.urdf, srdf: arm.srdf, group: backwards", 3),
    "floating": ("load: arm.urdf, floating: true", 4),
    "xacro": ("load: arm.xacro, xacro_args: {reach: 2}", 3),
    "mjcf": ("load: swing.xml", 2),
    "cell": ("load: inner.yaml", 14),
}


@pytest.fixture
def files(tmp_path):
    (tmp_path / "arm.urdf").write_text(URDF)
    (tmp_path / "arm.srdf").write_text(SRDF)
    (tmp_path / "arm.yaml").write_text(
        "urdf: arm.urdf\nsrdf: arm.srdf\ngroup: arm\nheld: {grip: 0.25}\n"
        "disabled_pairs: [{reason: near, pairs: [[base, tip]]}]\n"
    )
    xacro = URDF.replace(
        'name="arm">', 'name="arm" xmlns:xacro="http://ros.org/wiki/xacro"><xacro:arg name="reach" default="1"/>', 1
    )
    (tmp_path / "arm.xacro").write_text(xacro.replace('xyz="0 0 2"', 'xyz="0 0 $(arg reach)"'))
    (tmp_path / "swing.xml").write_text(MJCF)
    (tmp_path / "inner.yaml").write_text("robots: {a: {load: panda}, b: {load: panda, pose: {position: [0, 2, 0]}}}\n")
    return tmp_path


def written(files, text, name="cell.yaml"):
    (files / name).write_text(text)
    return files / name


def single(files, entry):
    """The robot of an entry alone, loaded as a cell of one at the origin."""
    return pc.Robot.load(written(files, f"robots: {{one: {{{entry}}}}}", "single.yaml"))


# ---- every kind of file


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize(("left", "right"), [*zip(KINDS, KINDS, strict=True), *itertools.pairwise(KINDS)])
def test_robots_of_all_kinds_stand_side_by_side(files, left, right):
    (first, count), (second, more) = KINDS[left], KINDS[right]
    path = written(files, f"robots:\n  left: {{{first}}}\n  right: {{{second}, {POSE}}}\n")
    cell, alone = pc.Robot.load(path), (single(files, first), single(files, second))
    assert [len(part.joint_names) for part in cell.parts.values()][: 2 * (cell.group is not None)] in (
        [count, more],
        [],
    )
    pose = cell.parts["right"].pose
    q = cell.random_configurations(4, 2)
    own = [part.robot for part in cell.parts.values()]
    poses = cell.link_poses(q)
    for robot, part, base in zip(own, cell.split(q).values(), (np.eye(4), pose), strict=True):
        n = len(robot.link_names)
        assert np.allclose(poses[:, :n], base @ robot.link_poses(part), atol=1e-12)
        poses = poses[:, n:]
    between = {(a, b) for a, b in names_of(cell) if a.startswith("left/") and b.startswith("right/")}
    kept = {(a, b) for a, b in names_of(cell) if (a, b) not in between}
    expected = [
        tuple(f"{name}/{body.removeprefix('one/')}" for body in pair)
        for name, robot in zip(("left", "right"), alone, strict=True)
        for pair in names_of(robot)
    ]
    assert kept == set(expected)
    assert between


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("group", ["all", "left", "right", "of some joints"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_saved_cell_is_the_same_cell(files, kind, group):
    entry, name = KINDS[kind][0], group if group in ("all", "left", "right") else None
    (files / "far").mkdir()
    cell = pc.Robot.load(written(files, f"robots:\n  left: {{load: panda, {POSE}}}\n  right: {{{entry}}}\n"))
    if name is None:
        cell = cell.with_group([cell.joint_names[0], "left/panda_joint4"]).holding({"left/panda_joint2": 0.1})
    else:
        members = {key: (part.robot, part.pose) for key, part in cell.parts.items()}
        cell = pc.Robot.together(members, group=name)
    cell.save(files / "far" / "saved.yaml")
    back = pc.Robot.load(files / "far" / "saved.yaml")
    assert (back.joint_names, back.group) == (cell.joint_names, cell.group)
    assert np.array_equal(back.reference, cell.reference)
    assert np.array_equal(back.self_pairs, cell.self_pairs)
    q = cell.random_configurations(50, 1)
    assert np.array_equal(back.link_poses(q), cell.link_poses(q))
    assert np.array_equal(pc.Checker(back).check_states(q), pc.Checker(cell).check_states(q))


@pytest.mark.parametrize("where", ["of a robot", "of the cell", "of a cell in the cell", "of no file"])
def test_followers_of_joints_that_are_held_elsewhere_are_saved(files, where):
    """Found by random cells: panda.yaml holds both fingers, so the second one of a saved cell stood where it says."""
    held, alone = {"panda_finger_joint1": 0.01}, pc.Robot.load("panda")
    apart = np.eye(4)
    apart[0, 3] = 3.0
    if where == "of a cell in the cell":
        inner = pc.Robot.load(files / "inner.yaml").holding({f"a/{name}": value for name, value in held.items()})
        cell = pc.Robot.together({"in": inner, "right": (alone, apart)})
    else:
        first = alone.holding(held) if where != "of the cell" else alone
        cell = pc.Robot.together({"left": first, "right": (alone, apart)})
    if where == "of the cell":
        cell = cell.holding({f"left/{name}": value for name, value in held.items()})
    if where == "of no file":  # the follower's value is the cell's own
        cell = cell.holding({"left/panda_finger_joint2": 0.03})
    cell.save(files / "saved.yaml")
    q = cell.random_configurations(5, 1)
    assert np.array_equal(pc.Robot.load(files / "saved.yaml").link_poses(q), cell.link_poses(q))


FINGERS = ("panda_finger_joint1", "panda_finger_joint2")  # the second follows the first, and panda.yaml holds both


@pytest.mark.parametrize("held", [(0.01,), (0.01, 0.02), (0.01, 0.04)])
@pytest.mark.parametrize("of_cell", [False, True])
def test_followers_of_held_joints_are_saved(files, held, of_cell):
    panda, values = pc.Robot.load("panda"), dict(zip(FINGERS, held, strict=False))
    if of_cell:
        cell = pc.Robot.together({"a": panda}).holding({f"a/{name}": value for name, value in values.items()})
    else:
        cell = pc.Robot.together({"a": panda.holding(values)})
    cell.save(files / "saved.yaml")
    back = pc.Robot.load(files / "saved.yaml")
    assert np.array_equal(back.expand(back.reference), cell.expand(cell.reference))
    assert back.expand(back.reference)[-2:].tolist() == [held[0], held[-1]]


@pytest.mark.parametrize(
    "text", ["robots: {a: {load: panda, HELD}}", "robots: {a: {load: panda}}\nHELD", "robots: {a: {load: inner.yaml}}"]
)
def test_followers_that_a_cells_file_does_not_give_move_with_their_leaders(files, text):
    written(files, "robots: {b: {load: panda, held: {panda_finger_joint1: 0.01}}}", "inner.yaml")
    key = "a/panda_finger_joint1" if "\n" in text else "panda_finger_joint1"
    cell = pc.Robot.load(written(files, text.replace("HELD", f"held: {{{key}: 0.01}}")))
    assert cell.expand(cell.reference)[-2:].tolist() == [0.01, 0.01]


def test_a_file_says_what_is_held_and_what_moves(files):
    text = "robots:\n  left: {load: arm.yaml}\n  right: {load: arm.yaml, held: {grip: 0.5}, REST}\nname: two\nMORE\n"
    cell = pc.Robot.load(written(files, text.replace("REST", POSE).replace("MORE", "held: {left/grip: -0.5}")))
    assert (cell.name, cell.joint_names[0]) == ("two", "left/lift")
    full = cell.expand(cell.reference)
    assert (full[3], full[8]) == (-0.5, 0.5)
    right = pc.Robot.load(written(files, text.replace("REST", POSE).replace("MORE", "group: right")))
    assert (right.group, right.joint_names) == ("right", ("right/lift", "right/turn"))
    named = "group: {name: ends, joints: [right/turn, left/lift]}"
    some = pc.Robot.load(written(files, text.replace("REST", POSE).replace("MORE", named)))
    assert (some.group, some.joint_names) == ("ends", ("right/turn", "left/lift"))


def test_equal_robots_are_read_once(files, monkeypatch):
    from plannercheck.robots import loading

    read = []
    own = loading.read_bodies
    monkeypatch.setattr(loading, "read_bodies", lambda *given: read.append(given) or own(*given))
    entries = [f"  r{k}: {{load: panda, pose: {{position: [{2 * k}, 0, 0]}}}}\n" for k in range(4)]
    cell = pc.Robot.load(written(files, "robots:\n" + "".join(entries) + "  ur: {load: ur5}\n"))
    assert (cell.nq, len(read)) == (34, 2)
    made = {id(polytope) for polytope in pc.Checker(cell).polytopes if polytope is not None}
    assert len(made) == 9 + 4 + 8  # links of a Panda, boxes of its fingers, links of a UR5


# ---- what files get wrong


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("robots: {}", "'robots' must name at least one robot"),
        ("robots: [a]", "'robots' must be a mapping"),
        ("robots: {a: {}}", "robot 'a': key 'load' is missing"),
        ("robots: {a: panda}", "robot 'a': it must be a mapping"),
        ("robots: {a: {load: pnada}}", "robot 'a': unknown robot 'pnada'.*'panda'"),
        ("robots: {a: {load: other.urdf}}", "robot 'a': robot file .*other.urdf does not exist"),
        ("robots: {a: {load: panda, psoe: {}}}", "robot 'a': unknown key 'psoe'.*'pose'"),
        ("robots: {a: {load: panda}}\nurdf: x", "unknown key 'urdf'"),
        ("robots: {a: {load: panda}}\nfloating: true", "unknown key 'floating'"),
        ("robots: {a/b: {load: panda}}", "without slashes.*'a/b'"),
        ("robots: {all: {load: panda}}", "not 'all'"),
        ("robots: {a: {load: panda}, a: {load: ur5}}", "a mapping has the key 'a' twice, on lines 1, 1"),
        ("robots: {a: {load: panda}, b: {load: ur5}}", "'a', 'b' of a cell have no pose"),
        ("robots: {a: {load: panda}, b: {load: ur5, pose: 1}}", "robot 'b': pose must be a mapping"),
        ("robots: {a: {load: panda, pose: {x: 1}}}", "robot 'a': pose: unknown key 'x'"),
        ("robots: {a: {load: panda, pose: {position: [1, 2]}}}", "robot 'a': pose: 'position' needs 3 numbers"),
        (
            "robots: {a: {load: panda, pose: {matrix: [[2,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}}}",
            "robot 'a'.*not rigid",
        ),
        ("robots: {a: {load: cell.yaml}}", r"load: cell.yaml loads itself \(cell.yaml > cell.yaml\)"),
        ("robots: {a: {load: loop.yaml}}", r"loads itself \(cell.yaml > loop.yaml > cell.yaml\)"),
        ("robots: {a: {load: panda, held: {finger: 1}}}", "robot 'a': unknown joint 'finger'"),
        ("robots: {a: {load: panda}}\nheld: {panda_joint1: 1}", "unknown joint 'panda_joint1'.*'a/panda_joint1'"),
        (
            "robots: {a: {load: panda}}\nheld: {a/panda_joint1: 1}",
            "held joint 'a/panda_joint1' is in the planning group",
        ),
        (
            "robots: {a: {load: panda, group: {joints: [panda_finger_joint1]}, held: {panda_finger_joint1: 0}}}",
            "'a': held",
        ),
        ("robots: {a: {load: panda}}\ngroup: b", "planning group 'b': without an SRDF"),
        ("robots: {a: {load: panda}}\ngroup: {joints: [panda_joint1]}", "unknown joint 'panda_joint1'.*'a/"),
        ("robots: {a: {load: panda}}\nsrdf: no.srdf", "no.srdf does not exist"),
        ("robots: {a: {load: panda}}\ndisabled_pairs: [{reason: r, pairs: [[a/x, a/panda_hand]]}]", "'a/x'"),
        ("robots: {a: {load: forklift}}", "robot 'a'.*unknown key 'kind'"),
        ("robots: {a: {load: inner.yaml, floating: true}}", "robot 'a': floating is said of one robot"),
    ],
)
def test_bad_cells_name_the_file_the_robot_and_the_remedy(files, text, message):
    written(files, "robots: {x: {load: cell.yaml}}", "loop.yaml")
    with pytest.raises(PlannercheckError, match=f"(?s)cell.yaml.*{message}"):
        pc.Robot.load(written(files, text))


def test_what_can_not_be_saved(files):
    panda = pc.Robot.load("panda")
    cell = pc.Robot.together({"a": panda})
    with pytest.raises(PlannercheckError, match="single robot"):
        panda.save(files / "x.yaml")
    with pytest.raises(PlannercheckError, match=r"'x.urdf' must end in .yaml"):
        cell.save(files / "x.urdf")
    with pytest.raises(PlannercheckError, match=r"robot 'c' of cell .* was made in memory"):
        pc.Robot.together({"c": cell}).save(files / "x.yaml")
    scene = pc.Scene()
    scene.attach("cup", "a/panda_hand", np.eye(4), (), pc.Sphere(0.01))
    with pytest.raises(PlannercheckError, match="carries 'cup'"):
        cell.carrying(scene.attached).save(files / "x.yaml")


# ---- pairs that files leave out


def test_what_acm_writes_of_a_cell_is_taken_again(files, capsys):
    path = written(files, f"robots:\n  left: {{load: arm.yaml}}\n  right: {{load: arm.urdf, {POSE}}}\n")
    cell = pc.Robot.load(path)
    for output in ("out.srdf", "out.yaml"):
        assert main(["acm", "--robot", str(path), "--states", "100", "--output", str(files / output)]) == 0
    robot = ["--robot", str(path), "--srdf", str(files / "out.srdf")]
    assert main(["inspect", *robot, "--states", "100"]) == 0
    assert main(["acm", "--audit", *robot, "--states", "100"]) in (0, 1)
    description = description_of(path)
    by_srdf = pc.Robot.from_description(type(description)(**{**vars(description), "srdf": files / "out.srdf"}))
    by_yaml = pc.Robot.load(files / "out.yaml")
    assert names_of(by_srdf) == names_of(by_yaml) < names_of(cell)
    assert by_yaml.joint_names == cell.joint_names
    capsys.readouterr()
    assert main(["acm", "--audit", "--robot", str(path), "--states", "100"]) in (0, 1)
    assert "2 pairs of links are disabled" in capsys.readouterr().out  # one by the SRDF of left, one by its YAML


def test_meshes_and_looks_of_a_cell_have_its_names(files):
    path = written(files, f"robots:\n  left: {{load: panda}}\n  right: {{load: panda, {POSE}}}\n")
    own = collision_meshes(description_of("panda"))
    assert set(collision_meshes(description_of(path))) == {
        f"{side}/{name}" for side in ("left", "right") for name in own
    }
    looks = visual_meshes(path)
    assert {each.link.split("/")[0] for each in looks} == {"left", "right"}
    solid = pc.Robot.load(path, geometry={"left/panda_link1": "solid"})
    assert [body.name for body in solid.bodies if isinstance(body.shape, pc.Solid)] == ["left/panda_link1_0"]
    for link in ("panda_link1", "lfet/panda_link1"):
        with pytest.raises(PlannercheckError, match=f"'{link}'"):
            pc.Robot.load(path, geometry={link: "solid"})
    with pytest.raises(PlannercheckError, match="panda_lnik1"):
        pc.Robot.load(path, geometry={"left/panda_lnik1": "solid"})


def test_an_srdf_of_a_cell_leaves_links_out_by_default(files):
    (files / "cell.srdf").write_text('<robot name="c"><disable_default_collisions link="left/panda_hand"/></robot>')
    text = f"robots:\n  left: {{load: panda}}\n  right: {{load: panda, {POSE}}}\nsrdf: cell.srdf\n"
    cell = pc.Robot.load(written(files, text))
    assert cell.default_links == ("left/panda_hand",)
    assert not {pair for pair in names_of(cell) if "left/panda_hand_0" in pair}
    assert {pair for pair in names_of(cell) if "right/panda_hand_0" in pair}


@pytest.mark.parametrize(
    "command",
    [
        ["inspect", "--states", "20"],
        ["validate", "q.npy", "--explain", "--output", "out.csv"],
        ["acm", "--states", "20", "--audit"],
        ["plan", "--start", "START", "--goal", "GOAL", "--output", "plan.json"],
        ["view", "--q", "START", "--html", "page.html"],
        ["bench", "states", "--states", "20", "--methods", "boxes", "--rounds", "1", "--scene", "empty"],
    ],
)
def test_every_command_takes_a_cell(files, monkeypatch, command):
    monkeypatch.chdir(files)
    path = written(files, f"robots:\n  left: {{load: panda}}\n  right: {{load: panda, {POSE}}}\n")
    cell = pc.Robot.load(path)
    rows = cell.reference + np.linspace(0, 0.1, 3)[:, None]
    np.save("q.npy", rows)
    ends = {"START": ",".join(map(str, rows[0])), "GOAL": ",".join(map(str, rows[-1]))}
    first, *more = [ends.get(word, word) for word in command]
    first = [first, more.pop(0)] if first == "bench" else [first]
    assert main([*first, "--robot", "cell.yaml", *more]) in (0, 1)
    assert main([*first, "--robot", "cell.yaml", "--floating", *more]) == 2


# ---- scenes and messages by prefixed names


def test_scenes_name_links_of_robots_of_a_cell(files):
    cell = pc.Robot.load(written(files, f"robots:\n  left: {{load: panda}}\n  right: {{load: panda, {POSE}}}\n"))
    scene = pc.Scene("s")
    scene.add("board", pc.Box((0.2, 0.2, 0.6)), cell.parts["right"].pose)
    q = cell.reference
    assert not pc.Checker(cell, scene).is_valid(q)
    touching = pc.Checker(cell, scene).explain(q).collisions
    assert {pair.first.split("/")[0] for pair in touching} == {"right"}
    for pair in touching:
        scene.allow(pair.first, "board")
    scene.save(files / "s.yaml")
    assert pc.Checker(cell, pc.Scene.load(files / "s.yaml")).is_valid(q)
    state = "\n".join(f"    name: [{', '.join(cell.joint_names)}]\n    position: {q.tolist()}".splitlines())
    message = written(
        files,
        f"robot_state:\n  joint_state:\n{state}\nworld:\n  collision_objects:\n"
        "  - header: {frame_id: right/panda_hand}\n    id: ball\n"
        "    primitives: [{type: 2, dimensions: [0.02]}]\n"
        "    primitive_poses: [{position: {x: 0, y: 0, z: 0.3}, orientation: {x: 0, y: 0, z: 0, w: 1}}]\n",
        "message.yaml",
    )
    checker = pc.Checker(cell, pc.Scene.load(message))
    hand = cell.link_poses(q)[cell.link_index("right/panda_hand")]
    assert np.allclose(checker.scene.objects[0].pose[:3, 3], (hand @ [0, 0, 0.3, 1])[:3])


def test_trajectory_messages_name_joints_of_robots_of_a_cell(files):
    cell = pc.Robot.load(written(files, f"robots:\n  left: {{load: panda}}\n  right: {{load: panda, {POSE}}}\n"))
    names = [*reversed(cell.joint_names)]
    rows = [cell.reference[::-1], cell.reference[::-1] + 0.01]
    points = "".join(
        f"- {{positions: {row.tolist()}, time_from_start: {{sec: {k}, nanosec: 0}}}}\n" for k, row in enumerate(rows)
    )
    message = written(files, f"joint_names: [{', '.join(names)}]\npoints:\n{points}", "t.yaml")
    trajectory = pc.Trajectory.load(message, cell)
    assert np.allclose(trajectory.position([0.0, 1.0]), [cell.reference, cell.reference + 0.01])
