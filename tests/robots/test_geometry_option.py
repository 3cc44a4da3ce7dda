"""What the meshes of links are taken as: hulls, pieces or solids, for all links or by name, however it is said."""

import json
import pickle
import warnings

import numpy as np
import pytest
import trimesh
import yaml

import plannercheck as pc
from plannercheck.bodies import convex_decomposition as decomposition
from plannercheck.bodies import protrusion
from plannercheck.cli.main import main
from plannercheck.robots.description import read_description
from plannercheck.robots.description_files import description_text

# A finger that slides in the notch of its base, whose hull fills the notch; a lid whose mesh is not closed.
URDF = """<robot name="gripper">
  <link name="base"><collision><geometry><mesh filename="angle.obj"/></geometry></collision></link>
  <link name="finger"><collision><geometry><box size="0.4 0.4 0.4"/></geometry></collision></link>
  <link name="lid"><collision><geometry><mesh filename="open.obj"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="base"/><child link="finger"/><axis xyz="0 1 0"/>
    <origin xyz="2 1.3 0.5" rpy="0 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="upward" type="prismatic"><parent link="base"/><child link="lid"/><axis xyz="0 0 1"/>
    <origin xyz="0 0 9" rpy="0 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""
SRDF = """<robot name="gripper"><group name="finger"><joint name="slide"/></group>
  <disable_collisions link1="finger" link2="lid" reason="Never"/></robot>"""

HALVES = ((0, 0, 0), (1, 2, 1)), ((1, 0, 0), (3, 1, 1))
HEIGHTS = np.linspace(-1, 1, 41)[:, None]
FREE = HEIGHTS[:, 0] > -0.1  # the finger's lower side is above the base's arm


def corners(low, high):
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]) * 1.0


def split(mesh, options, name, remesh):
    """In place of CoACD: the halves of the base; the lid as one."""
    return [corners(*ends) for ends in HALVES] if mesh.points.max() > 1 else [mesh.points]


def angle():
    flat = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 2), (0, 2)]
    points = np.array([[x, y, z] for z in (0.0, 1.0) for x, y in flat])
    top = [(6, 7, 9), (7, 8, 9), (6, 9, 10), (6, 10, 11)]
    sides = [t for k in range(6) for j in [(k + 1) % 6] for t in ((k, j, j + 6), (k, j + 6, k + 6))]
    return points, np.array([*top, *((c - 6, b - 6, a - 6) for a, b, c in top), *sides])


@pytest.fixture
def gripper(tmp_path, monkeypatch):
    monkeypatch.setenv("PLANNERCHECK_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(decomposition, "_coacd", split)
    monkeypatch.setattr(protrusion, "_FINE", 0.05)  # how far pieces stick out is bounded coarsely, which is faster
    trimesh.Trimesh(*angle(), process=False).export(tmp_path / "angle.obj")
    cube = trimesh.creation.box((1, 1, 1))
    trimesh.Trimesh(cube.vertices, cube.faces[1:], process=False).export(tmp_path / "open.obj")
    (tmp_path / "gripper.urdf").write_text(URDF)
    (tmp_path / "gripper.srdf").write_text(SRDF)
    return tmp_path


def robot_of(folder, **options):
    return pc.Robot.from_urdf(folder / "gripper.urdf", folder / "gripper.srdf", folder, "finger", **options)


def kinds(robot):
    return [type(body.shape).__name__ for body in robot.bodies]


def test_hulls_by_default(gripper):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for robot in (robot_of(gripper), robot_of(gripper, geometry="hull"), robot_of(gripper, geometry={})):
            assert kinds(robot) == ["Hull", "Box", "Hull"]
    assert (~pc.Checker(robot).check_states(HEIGHTS) & FREE).sum() > 10


def test_solids_and_what_is_not_closed(gripper):
    words = r"caps close open meshes: lid_0 \(1 loop of 3 edges, largest cap 1 m\).*'lid': 'triangles'.*lid=triangles"
    with pytest.warns(RuntimeWarning, match=words) as caught:
        robot = robot_of(gripper, geometry="solid")
    assert len(caught) == 1
    assert kinds(robot) == ["Solid", "Box", "Solid"]
    assert robot.bodies[2].shape.equals_hull
    near = np.abs(HEIGHTS[:, 0] + 0.1) < 1e-9
    np.testing.assert_array_equal(pc.Checker(robot).check_states(HEIGHTS)[~near], FREE[~near])
    assert robot.open_links == ("lid",)
    again = pickle.loads(pickle.dumps(robot))
    assert again.open_links == ("lid",)
    np.testing.assert_array_equal(pc.Checker(again).check_states(HEIGHTS)[~near], FREE[~near])


def test_links_by_name(gripper):
    for kind, words, is_closed in (("solid", "caps close", True), ("triangles", "their triangles alone", False)):
        with pytest.warns(RuntimeWarning, match=rf"{words}.*: lid_0 \(1 loop of 3 edges") as caught:
            robot = robot_of(gripper, geometry={"lid": kind})
        assert len(caught) == 1
        assert kinds(robot) == ["Hull", "Box", "Solid"]
        assert robot.bodies[2].shape.is_closed == is_closed
        assert robot.open_links == ("lid",)
    with pytest.warns(RuntimeWarning, match="their triangles alone"):
        assert kinds(robot_of(gripper, geometry="triangles")) == ["Solid", "Box", "Solid"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        robot = robot_of(gripper, geometry={"base": "solid", "finger": "solid", "lid": "hull"})
    assert kinds(robot) == ["Solid", "Box", "Hull"]


def test_pieces(gripper):
    options = pc.Decomposition(("base",), slack=0.01)
    names = ["base_0/piece 0", "base_0/piece 1", "finger_0", "lid_0"]
    for robot in (
        robot_of(gripper, geometry={"base": "pieces"}),
        robot_of(gripper, decomposition=options),
        robot_of(gripper, decomposition=options, geometry="pieces"),
        robot_of(gripper, decomposition=options, geometry={"lid": "hull"}),
    ):
        assert [body.name for body in robot.bodies] == names
        assert robot.self_pairs[:2].tolist() == [[0, 2], [1, 2]]
    # The geometry of a link goes before the options of pieces.
    assert kinds(robot_of(gripper, decomposition=options, geometry={"base": "solid"})) == ["Solid", "Box", "Hull"]
    assert kinds(robot_of(gripper, decomposition=options, geometry="hull")) == ["Hull", "Box", "Hull"]
    assert "base_0" in robot_of(gripper, geometry="pieces", decomposition=options).pieces
    every = robot_of(gripper, geometry="pieces").pieces
    assert "base_0" in every  # all concave and open ones


def test_pieces_by_options_leave_named_links_alone(gripper):
    """Options that choose links by themselves would take the base, which is concave."""
    assert "base_0" in robot_of(gripper, decomposition=pc.Decomposition()).pieces
    assert not robot_of(gripper, decomposition=pc.Decomposition(), geometry={"base": "hull"}).pieces


def test_yaml(gripper):
    text = "urdf: gripper.urdf\nsrdf: gripper.srdf\ngroup: finger\npackage_dirs: [.]\n"
    (gripper / "hull.yaml").write_text(text)
    (gripper / "solid.yaml").write_text(text + "geometry: {base: solid}\n")
    (gripper / "all.yaml").write_text(text + "geometry: solid\n")
    assert kinds(pc.Robot.load(gripper / "hull.yaml")) == ["Hull", "Box", "Hull"]
    assert kinds(pc.Robot.load(gripper / "solid.yaml")) == ["Solid", "Box", "Hull"]
    assert kinds(pc.Robot.load(gripper / "solid.yaml", geometry="hull")) == ["Hull", "Box", "Hull"]
    assert kinds(pc.Robot.load(gripper / "hull.yaml", geometry={"base": "solid"})) == ["Solid", "Box", "Hull"]
    with pytest.warns(RuntimeWarning, match="caps close open meshes: lid"):
        assert kinds(pc.Robot.load(gripper / "all.yaml")) == ["Solid", "Box", "Solid"]
    for name in ("solid", "all"):
        description = read_description(gripper / f"{name}.yaml")
        written = description_text(description, ["slide"], "", gripper / "out.yaml")
        assert yaml.safe_load(written)["geometry"] == description.geometry


@pytest.mark.parametrize(
    ("geometry", "says"),
    [
        ("solids", "unknown geometry 'solids': did you mean 'solid'?"),
        ({"base": "sold"}, "unknown geometry of link 'base' 'sold'"),
        ({"bass": "solid"}, "unknown link with a geometry 'bass': did you mean 'base'?"),
        (7, "geometry must be one of hull, pieces, solid, triangles, or a mapping"),
        ({"base": None}, "geometry of link 'base' must be one of"),
        (["solid"], "geometry must be one of"),
    ],
)
def test_mistakes_are_named(gripper, geometry, says):
    with pytest.raises(pc.PlannercheckError) as error:
        robot_of(gripper, geometry=geometry)
    assert says in str(error.value)
    (gripper / "bad.yaml").write_text(yaml.safe_dump({"urdf": "gripper.urdf", "geometry": geometry}))
    with pytest.raises(pc.PlannercheckError, match=r"robot file .*bad\.yaml"):
        pc.Robot.load(gripper / "bad.yaml")


def test_equal_meshes_of_a_robot_are_one_solid():
    robot = pc.Robot.load("ur5", geometry="solid")
    solids = [body.shape for body in robot.bodies if isinstance(body.shape, pc.Solid)]
    assert len(solids) == 7
    assert len({shape.digest for shape in solids}) == len({id(shape) for shape in solids})


def test_the_command_line(gripper, capsys):
    robot = ("--robot", str(gripper / "gripper.urdf"), "--srdf", str(gripper / "gripper.srdf"), "--group", "finger")
    assert main(["inspect", *robot, "--geometry", "base=solid,lid=hull", "--states", "50", "--fidelity"]) == 0
    out = capsys.readouterr().out
    words = {line.split()[0]: line.split()[2] for line in out.splitlines() if line.startswith(("base_0 ", "finger_0 "))}
    assert words["base_0"] in ("solid", out)
    assert "of 50 random configurations:\nlinks are" in out
    assert main(["inspect", *robot, "--geometry", "solid", "--states", "50"]) == 0
    caught = capsys.readouterr()
    says_open = "caps close open meshes: lid_0 (1 loop of 3 edges, largest cap 1 m)"
    assert says_open in caught.err
    assert says_open in caught.out
    np.save(gripper / "q.npy", HEIGHTS)
    assert main(["validate", *robot, "--geometry", "base=solid,lid=hull", str(gripper / "q.npy")]) == 1
    caught = capsys.readouterr()
    assert "solids: 1 bodies\n" in caught.out
    assert says_open not in caught.out
    whole = ["validate", *robot, "--geometry", "solid", str(gripper / "q.npy")]
    assert main(whole) == 1
    assert says_open in capsys.readouterr().out
    assert main([*whole, "--format", "json"]) == 1
    assert json.loads(capsys.readouterr().out)["solids"] == {"base_0": "closed", "lid_0": "capped"}
    command = ["validate", *robot, "--geometry", "base=solid,lid=triangles", str(gripper / "q.npy")]
    assert main(command) == 1
    assert "solids: 2 bodies; open meshes are their triangles alone" in capsys.readouterr().out
    assert main([*command, "--format", "json"]) == 1
    assert json.loads(capsys.readouterr().out)["solids"] == {"base_0": "closed", "lid_0": "open"}
    for wrong, says in (
        ("mesh", "unknown geometry 'mesh'"),
        ("base=mesh", "unknown geometry of link 'base' 'mesh'"),
        ("bass=solid", "unknown link with a geometry 'bass'"),
    ):
        assert main(["inspect", *robot, "--geometry", wrong]) == 2
        assert says in capsys.readouterr().err
    assert main(["inspect", "--robot", "forklift", "--geometry", "solid"]) == 2
    assert "--geometry: planar robots have no URDF" in capsys.readouterr().err
