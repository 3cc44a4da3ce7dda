"""URDFs as strangers write them: what other readers take loads here, and what is odd in them is said."""

import importlib.util
import re
import subprocess
import sys
import warnings

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies.shapes import Box, Cylinder, Sphere

BOX = '<geometry><box size="1 1 1"/></geometry>'
URDF = (
    f'<robot name="r"><link name="a"><collision>{BOX}</collision></link>'
    f'<link name="b"><collision>{BOX}</collision></link>'
    '<joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 3"/><axis xyz="0 0 1"/>'
    '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
)


def loaded(folder, text, name="r.urdf"):
    """The robot of a URDF's text; warnings are errors."""
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return pc.Robot.load(path)


def assert_whole(robot):
    assert [body.shape for body in robot.bodies] == [Box((1.0, 1.0, 1.0))] * 2
    assert robot.joint_names == ("j",)
    assert robot.upper.tolist() == [1.0]
    assert pc.Checker(robot).is_valid([0.5])


# ---- what is no clean XML, and yet plain what is meant


@pytest.mark.parametrize(
    "text",
    [
        f' \n<?xml version="1.0" encoding="utf-8"?>\n{URDF}',
        f'<!-- made by hand -->\n<?xml version="1.0"?>\n{URDF}',
        f"{URDF}\n\0",
        b"\xef\xbb\xbf" + f'<?xml version="1.0"?>{URDF}'.encode(),
        URDF.replace('<link name="b">', '<link name="b"><gazebo:sensor/><camera x:name="it"/>'),
        URDF.replace('<link name="b">', '<link name="b"><!-- one -- two -->'),
        URDF.replace('<link name="b">', '<link name="b"><!-- gr\xfcn -->').encode("latin-1"),
        URDF.replace(
            '<link name="b">', f'<link name="b"><visual>{BOX}<material><color rgba="1 0 0 1"/></material></visual>'
        ),
        *(
            URDF.replace('<link name="b">', f'<link name="b"><inertial>{inside}</inertial>')
            for inside in (
                '<mass value="1"/>',
                '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>',
                '<mass value="1"/><inertia ixx="1"/>',
                '<mass/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>',
            )
        ),
    ],
    ids=[
        "declaration after a blank",
        "declaration after a comment",
        "zero byte",
        "byte order",
        "prefixes",
        "comment",
        "latin comment",
        "material",
        "mass alone",
        "no mass",
        "no moments",
        "empty mass",
    ],
)
def test_what_is_meant_is_read(tmp_path, text):
    assert_whole(loaded(tmp_path, text))


def test_many_elements_are_mended_as_few_are(tmp_path):
    more = '<gazebo reference="a"><x/></gazebo>' * 300
    assert_whole(loaded(tmp_path, f" <?xml version='1.0'?>{URDF.replace('</robot>', more + '</robot>')}"))


def test_xml_is_a_suffix_of_urdfs(tmp_path):
    assert_whole(loaded(tmp_path, URDF, "robot.xml"))


def test_xacro_that_was_not_expanded_is_refused_though_urdfdom_passes_over_it(tmp_path):
    for root in ('<robot name="r">', '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'):
        text = URDF.replace('<robot name="r">', f'{root}<xacro:arm side="left"/>')
        with pytest.raises(pc.PlannercheckError, match="holds <xacro:arm>: it is a xacro, which has to be expanded"):
            loaded(tmp_path, text)


@pytest.mark.parametrize("text", [URDF[:-4], f" <?xml?>{URDF[:-4]}", "<robot", "no XML"])
def test_what_is_no_xml_is_still_refused(tmp_path, text):
    with pytest.raises(pc.PlannercheckError, match=r"r\.urdf does not parse|r\.urdf is not well-formed"):
        loaded(tmp_path, text)


# ---- sizes


@pytest.mark.parametrize(
    ("geometry", "shape"),
    [
        ('<box size="0 1 2"/>', Box((0.0, 1.0, 2.0))),
        ('<box size="0 0 0"/>', Box((0.0, 0.0, 0.0))),
        ('<sphere radius="0"/>', Sphere(0.0)),
        ('<cylinder radius="0" length="1"/>', Cylinder(0.0, 1.0)),
        ('<cylinder radius="1" length="0"/>', Cylinder(1.0, 0.0)),
    ],
)
def test_bodies_without_volume_are_bodies(tmp_path, geometry, shape):
    robot = loaded(tmp_path, URDF.replace('<box size="1 1 1"/>', geometry, 1))
    assert robot.bodies[0].shape == shape
    scene = pc.Scene()
    scene.add_box("crate", (1, 1, 1), [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 3], [0, 0, 0, 1]])
    checker = pc.Checker(robot, scene)
    assert not checker.is_valid([0.5])
    assert checker.colliding_pairs(np.array([[0.5]])).sum() == 1


@pytest.mark.parametrize("geometry", ['<box size="1 -1 1"/>', '<sphere radius="-1"/>'])
def test_sizes_below_zero_are_named_with_file_and_link(tmp_path, geometry):
    with pytest.raises(
        pc.PlannercheckError, match=r"r\.urdf: .*link 'b'.* must be finite and not negative \(m\), not -1"
    ):
        loaded(tmp_path, geometry.join(URDF.rsplit('<box size="1 1 1"/>', 1)))


# ---- what is hardly meant


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'xyz="0 0 3"',
            'xyz="0 0 3" rpy="0 90 -180"',
            "rpy=\"0 90 -180\" of joint 'j' look like degrees: rpy is in rad",
        ),
        ('lower="-1" upper="1"', 'lower="-180" upper="180"', "limits -180 to 180 of joint 'j' look like degrees"),
        ('<box size="1 1 1"/>', '<box size="100 50 20"/>', "size=\"100 50 20\" of link 'b' look like millimetres"),
        (
            '<box size="1 1 1"/>',
            '<cylinder radius="40" length="300"/>',
            'radius="40" length="300" of link \'b\' look like millimetres',
        ),
        ('lower="-1" upper="1"', "", "limits that are not given of joint 'j' keep the joint at 0"),
    ],
)
def test_odd_numbers_get_a_hint(tmp_path, old, new, message):
    (tmp_path / "r.urdf").write_text(URDF.replace(old, new))
    with pytest.warns(RuntimeWarning, match=re.escape(message)):
        pc.Robot.load(tmp_path / "r.urdf")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('xyz="0 0 3"', 'xyz="0 0 3" rpy="0 1.5707963 6.2831853"'),
        ('lower="-1" upper="1"', 'lower="-31.4159" upper="31.4159"'),
        ('lower="-1" upper="1"', 'lower="-1e16" upper="1e16"'),
    ],
)
def test_usual_numbers_get_none(tmp_path, old, new):
    loaded(tmp_path, URDF.replace(old, new))


def test_limits_that_no_joint_reaches_are_none(tmp_path):
    robot = loaded(
        tmp_path, URDF.replace("revolute", "prismatic").replace('lower="-1" upper="1"', 'lower="-1e16" upper="1e16"')
    )
    assert robot.lower.tolist() == [-np.inf]
    assert pc.Checker(robot).check_states(robot.random_configurations(20, 1)).shape == (20,)


POINTER = "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n"


@pytest.mark.parametrize("suffix", ["stl", "dae", "obj", "ply"])
def test_pointers_of_git_lfs_are_told_from_meshes(tmp_path, suffix):
    (tmp_path / f"m.{suffix}").write_text(POINTER)
    message = rf"link 'a': mesh file '.*m\.{suffix}': is a Git LFS pointer, not the mesh itself: `git lfs pull`"
    with pytest.raises(pc.PlannercheckError, match=message):
        loaded(tmp_path, URDF.replace('<box size="1 1 1"/>', f'<mesh filename="m.{suffix}"/>', 1))
    scene = pc.Scene()
    with pytest.raises(pc.PlannercheckError, match="is a Git LFS pointer"):
        scene.add_mesh("m", tmp_path / f"m.{suffix}")


SCENE = "objects:\n- {name: table, box: {size: [%s]}}\n- {name: post, cylinder: {radius: %s, length: %s}}\n"


def test_a_scene_in_millimetres_gets_a_hint(tmp_path):
    (tmp_path / "s.yaml").write_text(SCENE % ("800, 600, 20", 40, 700))
    with pytest.warns(
        RuntimeWarning, match=r"s\.yaml': 'table' is 800 m large and nothing is thinner than 20 m: .*0\.001"
    ):
        pc.Scene.load(tmp_path / "s.yaml")
    (tmp_path / "s.yaml").write_text(SCENE % ("800, 600, 0.02", 0.04, 0.7))  # a wide floor
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pc.Scene.load(tmp_path / "s.yaml")


# ---- what collections of the registries hold


def test_limits_beyond_all_configurations_are_none(tmp_path):
    """iris.urdf of example-robot-data: rotors that turn freely, written as revolute joints with limits of 1e16."""
    for kind, most in (("revolute", np.pi), ("prismatic", 1.0)):
        robot = loaded(
            tmp_path, URDF.replace('lower="-1" upper="1"', 'lower="-1e16" upper="1e16"').replace("revolute", kind)
        )
        q = robot.random_configurations(200, 0)
        assert 0.9 * most < np.abs(q).max() <= most
        assert robot.upper.tolist() == [np.inf]
        assert pc.Checker(robot).check_states(q).shape == (200,)
        assert np.isfinite(robot.kinematic_error)


def test_a_zero_after_the_end_is_passed_over(tmp_path):
    """humanoid.urdf of pybullet_data ends in a zero byte."""
    assert_whole(loaded(tmp_path, URDF.encode() + b"\r\n\x00"))


def test_a_xacro_that_reads_the_environment_is_told_as_one(tmp_path):
    """husky.urdf of pybullet_data."""
    with pytest.raises(pc.PlannercheckError, match=r"r\.urdf does not parse: it is a xacro, which has to be expanded"):
        loaded(tmp_path, URDF.replace('xyz="0 0 3"', 'xyz="$(optenv HEIGHT 0 0 3)"'))


def test_types_without_end_are_cut_in_errors(tmp_path):
    text = URDF.replace('type="revolute"', f'type="{"9" * 5000}"', 1)
    assert text != URDF
    with pytest.raises(pc.PlannercheckError, match="URDFs have no type '9999") as error:
        loaded(tmp_path, text)
    assert len(str(error.value)) < 1000


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('<robot name="r">', "<robot>", 'r.urdf: its <robot> has no name: write <robot name="...">'),
        (
            'lower="-1"',
            'lower="-1.5."',
            "r.urdf: lower in the <limit> of joint 'j' must be a finite number, not '-1.5.'",
        ),
        (
            'type="revolute"',
            'type="spherical"',
            "URDFs have no type 'spherical' of joint 'j': their types of joints are revolute, ",
        ),
        (URDF, "hello\n", "r.urdf does not parse: it is no XML (syntax error: line 1, column 0)"),
        (URDF, "", "r.urdf does not parse: it is empty"),
        (URDF, "<robot><joint/></robot>", "r.urdf has no <link>, nor a name: does it only define macros?"),
    ],
)
def test_reasons_are_of_the_file_not_of_its_readers(tmp_path, old, new, message):
    with pytest.raises(pc.PlannercheckError, match=re.escape(message)) as caught:
        loaded(tmp_path, URDF.replace(old, new))
    assert ".cpp" not in str(caught.value)
    assert str(caught.value).count("r.urdf") == 1


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("m.obj", "o cube\nv nan nan nan\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 2 3 4\n"),
        (
            "m.stl",
            "solid m\nfacet normal 0 0 0\nouter loop\nvertex NaN 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
            "endfacet\nendsolid\n",
        ),
    ],
)
def test_meshes_whose_vertices_are_no_numbers_name_the_line(tmp_path, capfd, name, text):
    """168.obj of pybullet_data holds nothing else."""
    (tmp_path / name).write_text(text)
    with pytest.raises(pc.PlannercheckError, match=rf"link 'a': mesh file '.*{name}': (line 2|facet 1).*[Nn]a[Nn].*"):
        loaded(tmp_path, URDF.replace('<box size="1 1 1"/>', f'<mesh filename="{name}"/>', 1))
    assert capfd.readouterr() == ("", "")


def test_joints_of_other_formats_are_named(tmp_path):
    robot = tmp_path / "bullet.urdf"
    robot.write_text(
        '<robot name="r"><link name="hip"><collision><geometry><capsule radius="1" length="1"/></geometry></collision>'
        '</link><link name="knee"/><joint name="turn" type="spherical"><parent link="hip"/><child link="knee"/></joint>'
        "</robot>"
    )
    with pytest.raises(pc.PlannercheckError) as error:
        pc.Robot.from_urdf(robot)
    said = str(error.value)
    assert "URDFs have no type 'spherical' of joint 'turn': their types of joints are revolute, " in said


def test_coacd_before_pinocchio_is_named():
    """Pinocchio 3's wheels say of any URDF, then, that it is none."""
    if importlib.util.find_spec("coacd") is None:
        pytest.skip("needs coacd")
    call = (
        "import coacd, plannercheck as pc\ntry:\n pc.Robot.load('panda')\nexcept pc.PlannercheckError as e:\n print(e)"
    )
    ran = subprocess.run([sys.executable, "-W", "ignore", "-c", call], capture_output=True, text=True, check=True)
    assert ran.stdout == "" or "import pinocchio before coacd" in ran.stdout
