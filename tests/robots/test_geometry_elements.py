"""What a URDF's <geometry> says: shapes as the file gives them, and errors for what urdfdom drops or defaults."""

import numpy as np
import pytest

import plannercheck as pc

URDF = """<robot name="r"><link name="base"/>
<link name="arm"><collision{name}>{geometry}</collision>{more}</link>
<joint name="j" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""


def load(folder, shapes, name="", more="", holder="<geometry>{}</geometry>"):
    path = folder / "r.urdf"
    path.write_text(URDF.format(geometry=holder.format(shapes), name=name, more=more))
    return pc.Robot.from_urdf(path)


@pytest.mark.parametrize(
    ("text", "shape"),
    [
        ('<box size="1 2  3"/>', pc.Box((1.0, 2.0, 3.0))),
        ('<sphere radius=".5"/>', pc.Sphere(0.5)),
        ('<cylinder radius="5e-1" length="+2."/>', pc.Cylinder(0.5, 2.0)),
        ('<capsule radius="0.1" length="0.4"/>', pc.Capsule(0.1, 0.4)),
        ('<!-- a comment --><box size="1 1 1"/>', pc.Box((1.0, 1.0, 1.0))),
    ],
)
def test_shapes_are_as_the_file_says(tmp_path, text, shape):
    assert load(tmp_path, text).bodies[0].shape == shape


@pytest.mark.parametrize("version", ["", ' version="1.0"', ' version="1.1"', ' version="1.2"'])
def test_capsules_are_read_whatever_the_version_says(tmp_path, version):
    path = tmp_path / "r.urdf"
    content = URDF.format(geometry='<geometry><capsule radius="0.1" length="0.4"/></geometry>', name="", more="")
    path.write_text(content.replace('name="r"', f'name="r"{version}'))
    assert pc.Robot.from_urdf(path).bodies[0].shape == pc.Capsule(0.1, 0.4)


def test_cylinders_that_collision_checking_names_are_capsules_as_in_pinocchio(tmp_path):
    tag = '<collision_checking><capsule name="tube"/></collision_checking>'
    robot = load(tmp_path, '<cylinder radius="0.1" length="0.4"/>', ' name="tube"', tag)
    assert robot.bodies[0].shape == pc.Capsule(0.1, 0.4)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('<box size="1 1 1"/><sphere radius="3"/>', "one shape, not 1 with <box>, <sphere>: give each shape a <collis"),
        ("", "needs one <geometry> with one shape, not 1 with none"),
        ('<torus radius="1"/>', "<torus>: is no shape that URDFs have: these are box, cylinder, sphere, capsule, mesh"),
        ("<box/>", "<box>: size is missing, it must be 3 numbers"),
        ('<box size="1 1"/>', "size is '1 1', it must be 3 numbers"),
        ('<box size="1,1,1"/>', "size is '1,1,1', it must be 3 numbers"),
        ('<box size="1 1 nan"/>', "size is '1 1 nan'"),
        ('<box size="1 1 1e400"/>', "size is '1 1 1e400'"),
        ('<box size="1 1 1_0"/>', "size is '1 1 1_0'"),
        ('<sphere radius="inf"/>', "radius is 'inf', it must be a number"),
        ('<sphere radius="0x10"/>', "radius is '0x10'"),
        ('<sphere radius="1 m"/>', "radius is '1 m'"),
        ('<sphere radius=""/>', "radius is ''"),
        ('<cylinder radius="1"/>', "length is missing"),
        ('<cylinder radius="1" length="-1"/>', "must be finite and not negative"),
        ('<mesh filename=" "/>', '<mesh>: has no filename="..."'),
        ('<mesh filename="m.obj" scale="1 0 1"/>', "scale='1 0 1' has a factor 0, which makes the mesh flat"),
        ('<mesh filename="m.obj" scale="0.001"/>', "scale is '0.001', it must be 3 numbers"),
        ('<mesh filename="nowhere.obj"/>', "mesh nowhere.obj could not be found"),
    ],
)
def test_faulty_elements_are_named_with_file_and_link(tmp_path, text, message):
    with pytest.raises(pc.PlannercheckError, match=r"URDF .*r\.urdf: .*link 'arm'") as error:
        load(tmp_path, text)
    assert message in str(error.value)


def test_no_geometry_and_two_are_errors(tmp_path):
    box = '<geometry><box size="1 1 1"/></geometry>'
    for holder in ("", box + box):
        with pytest.raises(pc.PlannercheckError, match="geometry"):
            load(tmp_path, "", holder=holder)


@pytest.mark.parametrize(
    "origin", ['xyz="0 0"', 'xyz="a b c"', 'rpy="0 0 nan nan"', 'xyz="0 0 1e999"', 'rpy="nan 0 0"']
)
def test_an_origin_that_can_not_be_read_is_an_error(tmp_path, origin):
    with pytest.raises(pc.PlannercheckError, match="arm"):
        load(tmp_path, f'<origin {origin}/><geometry><box size="1 1 1"/></geometry>', holder="{}")


@pytest.mark.parametrize(
    "visual",
    [
        '<visual><geometry><capsule radius=".1" length=".4"/></geometry></visual>',
        "<visual/>",
        '<visual><geometry><box size="1"/></geometry><material/></visual>',
        '<visual><geometry><mesh filename="nowhere.dae"/></geometry></visual>',
        '<visual><origin xyz="a"/><geometry><box size="1 1 1"/></geometry></visual>',
    ],
)
def test_visuals_do_not_stand_in_the_way(tmp_path, visual):
    robot = load(tmp_path, '<box size="1 1 1"/>', more=visual)
    assert [body.shape for body in robot.bodies] == [pc.Box((1.0, 1.0, 1.0))]


def test_bodies_are_posed_as_pinocchio_poses_them(tmp_path):
    text = '<origin xyz="0.1 0.2 0.3" rpy="0.1 0.2 0.3"/><geometry><capsule radius="0.1" length="0.4"/></geometry>'
    pose = load(tmp_path, text, holder="{}").bodies[0].pose
    x, y, z = (np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]]) for a in (0.1, 0.2, 0.3))
    turns = [np.eye(3) for _ in range(3)]
    turns[0][np.ix_([1, 2], [1, 2])], turns[1][np.ix_([2, 0], [2, 0])], turns[2][np.ix_([0, 1], [0, 1])] = x, y, z
    np.testing.assert_allclose(pose[:3, :3], turns[2] @ turns[1] @ turns[0], atol=1e-15)
    assert pose[:3, 3].tolist() == [0.1, 0.2, 0.3]
