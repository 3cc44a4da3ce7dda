"""Robots that are xacro files: expanded in a process of their own, packages found as everywhere."""

import os
import sys
import warnings

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies.shapes import Box
from plannercheck.cli.main import main
from plannercheck.robots.description import read_description

ARM = """<?xml version="1.0"?>
<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="size" default="0.1"/>
<xacro:include filename="$(find parts)/urdf/block.xacro"/>
<xacro:block name="a" size="$(arg size)"/>
<xacro:block name="b" size="${2 * 0.05}"/>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 ${pi}"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""

BLOCK = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="block" params="name size">
<link name="${name}"><collision><geometry><box size="${size} ${size} ${size}"/></geometry></collision></link>
</xacro:macro></robot>"""


@pytest.fixture
def arm(tmp_path, monkeypatch):
    for name in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(name, raising=False)
    package = tmp_path / "ws" / "src" / "parts-main"
    (package / "urdf").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>parts</name></package>")
    (package / "urdf" / "block.xacro").write_text(BLOCK)
    (tmp_path / "robot").mkdir()
    path = tmp_path / "robot" / "arm.urdf.xacro"
    path.write_text(ARM)
    return path


def size_of(robot):
    return robot.bodies[0].shape.size[0]


def test_a_xacro_is_expanded_with_its_arguments(arm, tmp_path):
    robot = pc.Robot.from_urdf(arm, package_dirs=tmp_path / "ws")
    assert robot.bodies[0].shape == Box((0.1, 0.1, 0.1))
    assert np.isclose(robot.link_poses([0.0])[1, 2, 3], np.pi)
    assert size_of(pc.Robot.from_urdf(arm, package_dirs=tmp_path / "ws", xacro_args={"size": "0.3"})) == 0.3


def test_packages_are_those_of_the_environment(arm, tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_PACKAGE_PATH", os.pathsep.join(["/nowhere", str(tmp_path / "ws")]))
    assert size_of(pc.Robot.load(arm)) == 0.1


def test_a_yaml_gives_arguments(arm, tmp_path):
    path = tmp_path / "robot" / "arm.yaml"
    path.write_text("urdf: arm.urdf.xacro\npackage_dirs: [../ws]\nxacro_args: {size: 0.25}\n")
    assert size_of(pc.Robot.load(path)) == 0.25


def test_arguments_in_a_yaml_are_those_that_are_written(tmp_path):
    path = tmp_path / "arm.yaml"
    for written in ("1.10", "on", "true", "007", "0x10", "1e3", "1_000", "2024-01-02", "'~'", "''", "a b"):
        for args in (f"{{a: {written}}}", f"{{<<: {{a: {written}}}}}"):
            path.write_text(f"urdf: arm.urdf.xacro\nxacro_args: {args}\n")
            assert read_description(path).xacro_args == {"a": written.strip("'")}
    path.write_text("robots: {left: {load: panda, xacro_args: {a: 1.10}}}\n")
    assert read_description(path).robots["left"].description.xacro_args == {"a": "1.10"}
    for written in ("", "~", "null", "[1]", "{b: 1}"):
        path.write_text(f"urdf: arm.urdf.xacro\nxacro_args: {{a: {written}}}\n")
        with pytest.raises(pc.PlannercheckError, match=r"xacro_args: 'a' must be a text \(of nothing: ''\), not "):
            read_description(path)


def test_the_command_line_gives_arguments(arm, tmp_path, capsys):
    robot = ("--robot", str(arm), "--package-dirs", str(tmp_path / "ws"))
    np.save(tmp_path / "q.npy", [[0.5]])
    assert main(["validate", *robot, "--xacro-arg", "size:=0.2", str(tmp_path / "q.npy")]) == 0
    assert main(["validate", *robot, "--xacro-arg", "size:=9", str(tmp_path / "q.npy")]) == 0  # adjacent links
    out = tmp_path / "arm.yaml"
    assert main(["acm", *robot, "--xacro-arg", "size:=0.2", "--states", "10", "--output", str(out)]) == 0
    assert size_of(pc.Robot.load(out)) == 0.2
    assert main(["inspect", "--robot", str(out), "--states", "10"]) == 0
    capsys.readouterr()
    assert main(["inspect", *robot, "--xacro-arg", "size=3"]) == 2
    assert "--xacro-arg must be NAME:=VALUE, not 'size=3'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("${pi}", "${height}", "can't be expanded: name 'height' is not defined"),
        ("$(find parts)", "$(find prats)", "package 'prats' is not found. Searched were the folders above the file"),
        ("</robot>", "", r"can't be expanded: .*no element found"),
        ('<xacro:block name="a"', '<xacro:brick name="a"', "can't be expanded: unknown macro name: xacro:brick"),
    ],
)
def test_what_xacro_says_is_said(arm, tmp_path, old, new, message):
    arm.write_text(ARM.replace(old, new))
    with pytest.raises(pc.PlannercheckError, match=rf"arm\.urdf\.xacro .*{message}"):
        pc.Robot.from_urdf(arm, package_dirs=tmp_path / "ws")


@pytest.mark.parametrize("conditional", [False, True])
def test_arguments_that_the_file_does_not_ask_for_are_errors(arm, tmp_path, conditional):
    """xacro passes over them; declared arguments count wherever they are: here, in an included file, or as $(arg)."""
    block = tmp_path / "ws" / "src" / "parts-main" / "urdf" / "block.xacro"
    inner = '<xacro:arg name="colour" default="red"/>'
    inner = f'<xacro:if value="${{1 == 2}}">{inner}</xacro:if>' if conditional else inner
    block.write_text(BLOCK.replace("<xacro:macro", f"{inner}<xacro:macro"))
    folders = {"package_dirs": tmp_path / "ws"}
    with pytest.raises(pc.PlannercheckError, match="unknown xacro argument 'siez': did you mean 'size'") as caught:
        pc.Robot.from_urdf(arm, xacro_args={"size": "0.3", "siez": "1"}, **folders)
    assert ("colour" in str(caught.value)) is not conditional
    path = tmp_path / "robot" / "arm.yaml"
    path.write_text("urdf: arm.urdf.xacro\npackage_dirs: [../ws]\nxacro_args: {sise: 0.25}\n")
    with pytest.raises(pc.PlannercheckError, match="unknown xacro argument 'sise'"):
        pc.Robot.load(path)
    if not conditional:
        assert size_of(pc.Robot.from_urdf(arm, xacro_args={"size": "0.3", "colour": "blue"}, **folders)) == 0.3


def test_missing_files_and_libraries_are_named(arm, tmp_path, monkeypatch):
    with pytest.raises(pc.PlannercheckError, match=r"nowhere\.xacro does not exist"):
        pc.Robot.from_urdf(tmp_path / "nowhere.xacro")
    urdf = tmp_path / "r.urdf"
    urdf.write_text('<robot name="r"><link name="a"/></robot>')
    with pytest.raises(pc.PlannercheckError, match=r"r\.urdf is no \.xacro, so that it takes no arguments: size"):
        pc.Robot.from_urdf(urdf, xacro_args={"size": "1"})
    monkeypatch.setitem(sys.modules, "xacro", None)
    with pytest.raises(pc.PlannercheckError, match=r"xacro files need xacro, .*pip install 'plannercheck\[xacro\]'"):
        pc.Robot.from_urdf(arm)


def test_a_proof_is_confirmed_for_a_xacro_with_its_arguments(arm, tmp_path, capsys):
    """`verify --robot` reads a robot as `validate` does."""
    package = ("--package-dirs", str(tmp_path / "ws" / "src"))
    path, proof = tmp_path / "path.npy", tmp_path / "path.proof.json"
    np.save(path, [[-0.5], [0.5]])
    robot = ("--robot", str(arm), *package, "--xacro-arg", "size:=0.2")
    assert main(["validate", *robot, "--path", str(path), "--certify", "--proof", str(proof)]) == 0
    capsys.readouterr()
    assert main(["verify", str(proof), *robot]) == 0
    assert "model: confirmed" in capsys.readouterr().out
    arm.write_text(ARM.replace('axis xyz="0 0 1"', 'axis xyz="0 1 0"'))
    assert main(["verify", str(proof), *robot]) == 1
    assert "joint 'j' has the axis [0.0, 0.0, 1.0]" in capsys.readouterr().out


def test_a_file_of_macros_says_which_file_is_meant(arm, tmp_path):
    path = tmp_path / "ws" / "src" / "parts-main" / "urdf" / "block.xacro"
    with pytest.raises(pc.PlannercheckError, match=r"expands to no link: it defines macros \(block\), so give the"):
        pc.Robot.from_urdf(path)
    path.write_text(BLOCK.replace("</robot>", '<xacro:block name="a" size="1"/></robot>'))
    with pytest.raises(pc.PlannercheckError, match=r'its <robot> has no name: write <robot name="..."'):
        pc.Robot.from_urdf(path)


def test_messages_are_without_pythons_classes(arm):
    with pytest.raises(pc.PlannercheckError, match=r"can't be expanded: package 'parts' is not found") as found:
        pc.Robot.from_urdf(arm)
    assert "<class" not in str(found.value)


@pytest.mark.parametrize(
    ("added", "said"),
    [
        ('<xacro:include filename="no*.xacro"/>', 'no*.xacro" matched no files'),
        ('<xacro:property name="pi" value="3"/>', "warning: redefining global symbol: pi"),
        ('<include filename="block.xacro"/>', "<include> is passed over: write <xacro:include>"),
        ('<block name="c" size="1"/>', "<block> is passed over: write <xacro:block>"),
        ('<link name="a"><block/></link>', "<block> is passed over"),
        ('<gazebo><include filename="x"/></gazebo><xacro:macro name="joint" params=""/>', None),
    ],
)
def test_what_xacro_passes_over_is_one_warning(arm, tmp_path, added, said):
    text = ARM.replace("<joint", f"{added}<joint", 1)
    text = text.replace('<xacro:block name="a" size="$(arg size)"/>', "") if "<link" in added else text
    arm.write_text(text)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        pc.Robot.from_urdf(arm, package_dirs=tmp_path / "ws")
    found = [str(each.message) for each in caught if "xacro " in str(each.message)]
    assert len(found) == (said is not None), found
    assert said is None or (said in found[0] and "arm.urdf.xacro" in found[0]), found
