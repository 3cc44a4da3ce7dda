"""What a URDF says about links and joints is read as it is written, or refused with file and element."""

import itertools
import re
import warnings

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.proofs.urdf_joints import read_tree

BOX = '<collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision>'
LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
KINDS = ("revolute", "continuous", "prismatic", "planar", "floating", "fixed")
NO_NUMBERS = ("nan", "inf", "-inf", "1e400", "1_0", "0x10", "1.5.", "", "true", "٣")


def urdf(joint="", kind="revolute", axis='<axis xyz="0 0 1"/>', limit=LIMIT, link="", robot="", origin=""):
    """A robot of links a, b and c: a joint of a kind carries b, and a fixed one c."""
    return (
        f'<robot name="r"{robot}><link name="a">{BOX}</link><link name="b">{BOX}{link}</link><link name="c"/>'
        f'<joint name="j" type="{kind}"><parent link="a"/><child link="b"/>{origin}{axis}{limit}{joint}</joint>'
        '<joint name="k" type="fixed"><parent link="b"/><child link="c"/></joint></robot>'
    )


def load(folder, text, warned=False):
    path = folder / "r.urdf"
    path.write_text(text)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore" if warned else "error")
        return pc.Robot.load(path)


def refused(folder, text, *words):
    with pytest.raises(pc.PlannercheckError) as caught:
        load(folder, text, warned=True)
    said = str(caught.value)
    assert "r.urdf" in said
    assert all(word in said for word in words), said


# ---- axes


@pytest.mark.parametrize("kind", ["revolute", "continuous", "prismatic", "planar"])
@pytest.mark.parametrize(
    "xyz",
    ["0 0 0", "0 0 1e-320", "1e-160 0 1e-170", "0 0 1e200", "1e308 1e308 0", "-0 0 -0", "1 2", "1 2 3 4", "1,0,0"]
    + [f"0 {text} 1" for text in NO_NUMBERS if text],
)
def test_axes_without_a_direction_are_refused(tmp_path, kind, xyz):
    """zero_axis.py: motions passed through states that are refused, since a bound was no number."""
    refused(tmp_path, urdf(kind=kind, axis=f'<axis xyz="{xyz}"/>'), "<axis>" if kind != "planar" else "", "'j'")


@pytest.mark.parametrize("kind", ["revolute", "continuous", "prismatic", "planar"])
def test_an_axis_element_without_numbers_is_refused(tmp_path, kind):
    refused(tmp_path, urdf(kind=kind, axis="<axis/>"), "xyz in the <axis> of joint 'j'", "missing")


@pytest.mark.parametrize("kind", ["fixed", "floating"])
def test_axes_of_joints_that_have_none_do_not_matter(tmp_path, kind):
    assert len(load(tmp_path, urdf(kind=kind, axis='<axis xyz="0 0 0"/>')).bodies) == 2


@pytest.mark.parametrize("scale", [1e-90, 1e-3, 1.0, 5.0, 1e90])
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_axes_of_any_length_are_directions(tmp_path, kind, scale):
    robot = load(tmp_path, urdf(kind=kind, axis=f'<axis xyz="0 {0.6 * scale!r} {0.8 * scale!r}"/>'))
    pose = robot.link_poses([0.5])[1]
    if kind == "prismatic":
        assert np.allclose(pose[:3, 3], [0, 0.3, 0.4], rtol=0, atol=1e-15)
    else:
        assert np.allclose(pose[:3, :3] @ [0, 0.6, 0.8], [0, 0.6, 0.8], rtol=0, atol=1e-15)
        assert np.isclose(np.trace(pose[:3, :3]), 1 + 2 * np.cos(0.5), rtol=0, atol=1e-15)


# ---- planes


@pytest.mark.parametrize("xyz", ["1 0 0", "0 1 0", "0 1e-9 1", "0.6 0 0.8", "1e-300 0 1"])
def test_planes_that_are_not_xy_are_refused(tmp_path, xyz):
    """planar_axis.py: Pinocchio moves every planar joint in xy, and the verifier confirmed it."""
    refused(tmp_path, urdf(kind="planar", axis=f'<axis xyz="{xyz}"/>'), f'normal xyz="{xyz}"', "turn its <origin>")
    with pytest.raises(pc.PlannercheckError, match="its plane is normal to"):
        read_tree(tmp_path / "r.urdf")


@pytest.mark.parametrize("xyz", ["0 0 1", "0 0 -1", "0 0 2.5", None])
def test_planes_normal_to_z_are_xy(tmp_path, xyz):
    axis = "" if xyz is None else f'<axis xyz="{xyz}"/>'
    if xyz is None:
        with pytest.warns(RuntimeWarning, match="'j', which is planar without <axis>, moves in its xy"):
            pc.Robot.from_urdf(_written(tmp_path, urdf(kind="planar", axis=axis)))
    robot = load(tmp_path, urdf(kind="planar", axis=axis), warned=xyz is None)
    assert np.allclose(robot.link_poses([3.0, 4.0, 0.6, 0.8])[1][:3, 3], [3, 4, 0], rtol=0, atol=0)
    checker, ends = pc.Checker(robot, pc.Scene()), [[3.0, 4.0, 1.0, 0.0], [4.0, 4.0, 1.0, 0.0]]
    proof = checker.certify_motions([ends[0]], [ends[1]])[0]
    assert proof.verify(str(tmp_path / "r.urdf"))


def _written(folder, text):
    (folder / "r.urdf").write_text(text)
    return folder / "r.urdf"


# ---- other numbers


@pytest.mark.parametrize("text", NO_NUMBERS)
@pytest.mark.parametrize("place", ["xyz", "rpy", "collision xyz", "lower", "upper", "velocity", "multiplier", "offset"])
def test_what_is_no_number_is_refused_wherever_it_stands(tmp_path, place, text):
    if place in ("xyz", "rpy"):
        refused(tmp_path, urdf(origin=f'<origin {place}="0 {text} 0"/>'), f"{place} in the <origin> of joint 'j'")
    elif place == "collision xyz":
        link = f'<collision><origin xyz="{text} 0 0"/><geometry><sphere radius="1"/></geometry></collision>'
        refused(tmp_path, urdf(link=link), "xyz in the <origin> of a <collision> of link 'b'")
    elif place in ("lower", "upper", "velocity"):
        limit = re.sub(rf'{place}="[-1]*"', f'{place}="{text}"', LIMIT)
        refused(tmp_path, urdf(limit=limit), f"{place} in the <limit> of joint 'j'")
    else:
        refused(tmp_path, _with_mimic(f'joint="j" {place}="{text}"'), f"{place} in the <mimic> of joint 'm'")


@pytest.mark.parametrize("text", ["1 2", "1 2 3 4", "1,2,3", "1;2;3", "", " "])
@pytest.mark.parametrize("key", ["xyz", "rpy"])
def test_three_numbers_are_three_numbers(tmp_path, key, text):
    refused(tmp_path, urdf(origin=f'<origin {key}="{text}"/>'), f"{key} in the <origin> of joint 'j'", "3 finite")


def test_numbers_that_no_robot_has_are_refused(tmp_path):
    refused(tmp_path, urdf(origin='<origin xyz="0 0 1e61"/>'), "beyond 1e+60")
    refused(tmp_path, _with_mimic('joint="j" multiplier="1e13"'), "beyond 1e+12")


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_missing_limits_are_refused(tmp_path, kind):
    refused(tmp_path, urdf(kind=kind, limit=""), f"joint 'j' is {kind} and has no <limit")
    refused(tmp_path, urdf(kind=kind, limit='<limit lower="0" upper="1" effort="1"/>'), "'j' has no velocity=")


def test_quaternions_are_read_or_refused(tmp_path):
    quaternion = '<origin xyz="0 0 1" quat_xyzw="0 0 0.6 0.8"/>'
    refused(tmp_path, urdf(origin=quaternion), "turned by quat_xyzw, which is read from")
    newer = ' version="1.1"'
    robot = load(tmp_path, urdf(origin=quaternion, robot=newer))
    assert np.allclose(robot.link_poses([0.0])[1][:2, :2], [[0.28, -0.96], [0.96, 0.28]], rtol=0, atol=1e-15)
    proof = pc.Checker(robot, pc.Scene()).certify_motions([[0.0]], [[0.5]])[0]
    assert proof.verify(str(tmp_path / "r.urdf"))
    refused(tmp_path, urdf(origin=quaternion.replace("0.8", "0.9"), robot=newer), "must have length 1")
    refused(tmp_path, urdf(origin=quaternion.replace("/>", ' rpy="0 0 0"/>'), robot=newer), "both rpy and quat_xyzw")
    ball = f'<collision>{quaternion}<geometry><sphere radius="1"/></geometry></collision>'
    refused(tmp_path, urdf(link=ball), "collision> of link 'b' is turned by quat_xyzw, which is read from")
    pose = load(tmp_path, urdf(link=ball, robot=newer)).bodies[2].pose
    assert np.allclose(pose[:3], [[0.28, -0.96, 0, 0], [0.96, 0.28, 0, 0], [0, 0, 1, 1]], rtol=0, atol=1e-15)


# ---- mimics


def _with_mimic(attributes, kind="revolute"):
    joint = (
        f'<link name="d">{BOX}</link><joint name="m" type="{kind}"><parent link="c"/><child link="d"/>'
        f'<axis xyz="0 0 1"/>{LIMIT}<mimic {attributes}/></joint></robot>'
    )
    return urdf().replace("</robot>", joint)


@pytest.mark.parametrize(
    ("attributes", "words"),
    [
        ('joint="nope"', ["unknown joint that joint 'm' mimics 'nope'", "valid are j"]),
        ('joint="jj"', ["did you mean 'j'"]),
        ("", ["the <mimic> of joint 'm' has no joint=\"\""]),
        ('joint="k"', ["joint 'm' mimics joint 'k', and 'k' is fixed"]),
        ('joint="m"', ["joint 'm' mimics itself: m > m"]),
    ],
)
def test_mimics_of_what_is_not_there_are_refused(tmp_path, attributes, words):
    refused(tmp_path, _with_mimic(attributes), *words)


def test_mimics_in_a_circle_are_refused(tmp_path):
    text = _with_mimic('joint="j"').replace(LIMIT, LIMIT + '<mimic joint="m"/>', 1)
    refused(tmp_path, text, "joint 'j' mimics itself: j > m > j")


@pytest.mark.parametrize("kind", ["floating", "planar"])
def test_mimics_take_one_value(tmp_path, kind):
    refused(tmp_path, _with_mimic('joint="j"', kind), f"'m' is {kind}: both must be")


def test_an_absurdly_long_type_is_cut_in_the_error(tmp_path):
    """A mutated URDF: the error had 5,126 characters."""
    (tmp_path / "r.urdf").write_text(_with_mimic('joint="j"').replace('"revolute"', f'"{5000 * "9"}"', 1))
    with pytest.raises(pc.PlannercheckError, match=r"'j' is 9{20}") as caught:
        pc.Robot.from_urdf(tmp_path / "r.urdf")
    assert len(str(caught.value)) < 500


# ---- links and joints


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('<link name="c"/>', '<link name="c"/><link name="c"/>', "two links have the name 'c'"),
        ('name="k"', 'name="j"', "two joints have the name 'j'"),
        ('<link name="c"/>', '<link name="c"/><link/>', "a link has no name"),
        ('<link name="c"/>', '<link name="c"/><link name="d"/>', "2 links are no joint's child"),
        ('<child link="c"/>', '<child link="b"/>', "link 'b' is the child of joints 'j' and 'k'"),
        ('<child link="c"/>', '<child link="x"/>', "unknown child link of joint 'k' 'x'"),
        ('<parent link="a"/>', '<parent link="c"/>', "link 'b' hangs on itself"),
        ('<parent link="a"/>', "", "joint 'j' has no <parent"),
        ('<parent link="a"/>', '<parent link="a"/><parent link="c"/>', "joint 'j' has 2 <parent> elements"),
        (LIMIT, LIMIT + LIMIT.replace("-1", "-2"), "joint 'j' has 2 <limit> elements"),
        (BOX, BOX.replace("</collision>", f"{BOX}</collision>"), "<collision> stands within link 'a'"),
        (BOX, f"<link name='z'>{BOX}</link>", "<link> stands within link 'a'"),
        ("</robot>", f"{BOX}</robot>", "<collision> stands in no <link>"),
        ("<collision>", '<collision><origin xyz="0 0 1"/><origin xyz="0 0 2"/>', "has 2 <origin> elements"),
        ("<geometry>", "<geometry><sphere radius='1'/></geometry><geometry>", "has 2 <geometry> elements"),
        (BOX, "<collision/>", "a <collision> of link 'a' has no <geometry>"),
        ('<axis xyz="0 0 1"/>', '<origin><axis xyz="0 0 1"/></origin>', "the <origin> of joint 'j' holds <axis>"),
        (LIMIT, LIMIT.replace("/>", '><mimic joint="i"/></limit>'), "the <limit> of joint 'j' holds <mimic>"),
        ('<parent link="a"/>', '<parent link="a"><origin/></parent>', "the <parent> of joint 'j' holds <origin>"),
        ('<axis xyz="0 0 1"/>', "<axis><xyz>0 0 1</xyz></axis>", "the <axis> of joint 'j' holds <xyz>"),
        ("<axis", "<origin>0 0 1</origin><axis", "the <origin> of joint 'j' holds the text '0 0 1'"),
        ("<collision>", "<collision><origin>0 0 1</origin>", "a <collision> of link 'a' holds the text '0 0 1'"),
        (
            'size="0.2 0.2 0.2"/>',
            'size="1 1 1"><origin/></box>',
            "the <box> of a <collision> of link 'a' holds <origin>",
        ),
        ('<box size="0.2 0.2 0.2"/>', '<mesh filename="b"><scale>1 1 1</scale></mesh>', "link 'a' holds <scale>"),
        ('<box size="0.2 0.2 0.2"/>', "<mesh><uri>b.stl</uri></mesh>", "<mesh> has the attributes filename=, scale="),
    ],
)
def test_links_and_joints_are_a_tree_of_whole_elements(tmp_path, old, new, words):
    assert old in urdf()
    refused(tmp_path, urdf().replace(old, new, 1), words)


def test_elements_that_say_the_same_twice_say_nothing_else(tmp_path):
    """spirit40newer.urdf of pybullet_data repeats an <axis>."""
    assert load(tmp_path, urdf(joint='<axis xyz="0 0 1"/>')).nq == 1


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("<collision>", "<colision>", "<colision> of link 'a' are not read"),
        ("<axis ", "<Axis ", "<Axis> of joint 'j' are not read"),
        ('<axis xyz="0 0 1"', '<axis xyz="0 0 1" xzy="1 0 0"', "xzy= in <axis> of joint 'j' are not read"),
        ("<collision>", "<collision><pose>0 0 1 0 0 0</pose>", "<pose> of link 'a' are not read"),
        ("<axis ", "<pose>0 0 1 0 0 0</pose><axis ", "<pose> of joint 'j' are not read"),
        ('<link name="a">', '<link name="a"><origin xyz="0 0 1"/>', "<origin> of link 'a' are not read"),
        ("<collision>", '<collision xyz="0 0 1">', "xyz= in <collision> of link 'a' are not read"),
        ("<geometry>", '<geometry size="1 1 1">', "size= in <geometry> of link 'a' are not read"),
        ("<box ", '<box scale="2 2 2" ', "scale= in <box> of link 'a' are not read"),
        (
            '<box size="0.2 0.2 0.2"',
            '<sphere diameter="3" radius="1"',
            "diameter= in <sphere> of link 'a' are not read",
        ),
        (
            LIMIT,
            LIMIT + '<safety_controller k_velocity="1" soft_lower_limit="-0.5" soft_upper_limit="2"/>',
            "soft limits -0.5 to 2 of joint 'j' are not read",
        ),
    ],
)
def test_what_is_misspelt_is_warned_of(tmp_path, old, new, words):
    text = urdf().replace(old, new, 1).replace("</collision>", old.replace("<", "</"), 0)
    text = text.replace("</collision>", "</colision>", 1) if "colision" in new else text
    with pytest.warns(RuntimeWarning, match=re.escape(words)):
        pc.Robot.from_urdf(_written(tmp_path, text))


def test_what_other_programs_add_is_passed_over(tmp_path):
    """Names of geometries, masks of Bullet, materials of collisions, soft limits beyond the limits."""
    text = urdf().replace("<collision>", '<collision name="c" group="1" mask="2"><material name="m"/>')
    text = text.replace("<geometry>", '<geometry name="g">').replace('0.2"/>', '0.2"><verbose value="yes"/></box>')
    soft = '<safety_controller k_velocity="1" soft_lower_limit="-1" soft_upper_limit="2"/>'
    assert load(tmp_path, text.replace(LIMIT, LIMIT + soft)).nq == 1


# ---- what decides no verdict stands in nobody's way

PARTS = {
    "visual": [
        "<visual/>",
        "<visual><geometry/></visual>",
        '<visual><geometry><capsule radius="x"/></geometry></visual>',
        '<visual><origin xyz="a b"/><geometry><box size="1"/></geometry></visual>',
        '<visual><geometry><mesh/></geometry><material><color rgba="red"/></material></visual>',
    ],
    "inertial": [
        "<inertial/>",
        '<inertial><mass value="nan"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>',
        '<inertial><origin xyz="1 2"/><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
        "</inertial>",
        '<inertial><mass value="-1"/><inertia ixx="-1" ixy="9" ixz="9" iyy="0" iyz="0" izz="0"/></inertial>',
    ],
    "joint": [
        "<dynamics/>",
        '<safety_controller k_velocity="x"/>',
        '<calibration rising="x"/>',
        "<sensor><joint/></sensor>",
    ],
    "robot": [
        "<material/>",
        '<material name="m"/><material name="m"/>',
        '<transmission name="t"><joint name="nowhere"/></transmission>',
        '<gazebo reference="x"><collision/></gazebo>',
        '<ros2_control name="c" type="system"><joint name="j"><command_interface name="p"/></joint></ros2_control>',
        '<sensor name="s"><parent link="nowhere"/></sensor>',
    ],
}


@pytest.mark.parametrize(("where", "part"), [(where, part) for where, parts in PARTS.items() for part in parts])
def test_parts_that_decide_no_verdict_may_be_faulty(tmp_path, where, part):
    text = urdf(link=part) if where in ("visual", "inertial") else urdf(joint=part if where == "joint" else "")
    text = text.replace("</robot>", f"{part}</robot>") if where == "robot" else text
    robot = load(tmp_path, text)
    assert [body.link for body in robot.bodies] == ["a", "b"]
    assert robot.upper.tolist() == [1.0]


def test_all_kinds_of_joints_load_with_every_origin(tmp_path):
    for kind, xyz, rpy in itertools.product(KINDS, ("0 0 1", "-1e-3 2.5e1 .5"), ("0 0 0", "0.1 -0.2 3")):
        robot = load(tmp_path, urdf(kind=kind, origin=f'<origin xyz="{xyz}" rpy="{rpy}"/>'))
        neutral = {"planar": [0, 0, 1, 0], "floating": [0, 0, 0, 0, 0, 0, 1], "continuous": [1, 0], "fixed": []}
        pose = robot.link_poses(np.array(neutral.get(kind, [0.0]), dtype=float))[1]
        assert pose[:3, 3].tolist() == [float(word) for word in xyz.split()]
