"""Robots of the tests: files of installed ones, and a small one with every kind of joint and an SRDF, partly wrong."""

from plannercheck.common.package_data import example_robot_data

SHARE = example_robot_data()
ROBOTS = SHARE / "example-robot-data" / "robots"
PANDA = ROBOTS / "panda_description" / "urdf" / "panda.urdf"
PANDA_SRDF = ROBOTS / "panda_description" / "srdf" / "panda.srdf"
PR2 = ROBOTS / "pr2_description" / "urdf" / "pr2.urdf"
PR2_SRDF = ROBOTS / "pr2_description" / "srdf" / "pr2.srdf"

URDF = """<robot name="arm">
<link name="base"><collision><geometry><box size="1 2 3"/></geometry></collision></link>
<link name="upper">
  <collision><origin xyz="0.1 0.2 0.3" rpy="1 0 0"/>
    <geometry><cylinder radius="0.1" length="0.5"/></geometry></collision>
  <collision><geometry><sphere radius="0.2"/></geometry></collision></link>
<link name="lower"><collision><geometry><sphere radius="0.4"/></geometry></collision></link>
<link name="tip">
  <collision><origin xyz="0 0 1"/><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
<link name="finger"/><link name="thumb"/>
<joint name="lift" type="prismatic"><parent link="base"/><child link="upper"/><origin xyz="0 0 2"/>
  <axis xyz="0 0 1"/><limit lower="0.5" upper="1.5" effort="1" velocity="1"/></joint>
<joint name="turn" type="continuous"><parent link="upper"/><child link="lower"/><axis xyz="0 1 0"/></joint>
<joint name="weld" type="fixed"><parent link="lower"/><child link="tip"/></joint>
<joint name="grip" type="revolute"><parent link="tip"/><child link="finger"/>
  <axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="pinch" type="revolute"><parent link="tip"/><child link="thumb"/><axis xyz="1 0 0"/>
  <mimic joint="grip" multiplier="-2" offset="0.1"/>
  <limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
</robot>"""

SRDF = """<robot name="arm">
<virtual_joint name="root" type="fixed" parent_frame="world" child_link="base"/>
<group name="arm"><chain base_link="base" tip_link="tip"/></group>
<group name="hand"><joint name="pinch"/><link name="finger"/></group>
<group name="backwards">
  <joint name="root"/><group name="hand"/><joint name="turn"/><joint name="lift"/></group>
<group name="across"><chain base_link="finger" tip_link="thumb"/></group>
<group name="endless"><group name="endless"/></group>
<group name="still"><joint name="weld"/></group>
<group name="wrong"><joint name="trun"/></group>
<group_state name="folded" group="arm">
  <joint name="lift" value="0.75"/><joint name="turn" value="2"/></group_state>
<disable_collisions link1="base" link2="lower" reason="User"/>
</robot>"""


def write_yaml(arm, text):
    path = arm[0].with_suffix(".yaml")
    path.write_text(f"urdf: arm.urdf\n{text}")
    return path


def names_of(robot):
    return {tuple(robot.bodies[i].name for i in pair) for pair in robot.self_pairs.tolist()}
