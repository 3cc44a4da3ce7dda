"""A robot whose configurations are places: a small box that slides along x and y."""

from pathlib import Path

import numpy as np

import plannercheck as pc

# The box reaches so far from its place, m.
HALF = 0.01


def gantry_robot(folder: Path, half: float, velocities: tuple[float, float]) -> pc.Robot:
    """The robot, of half edges in m and velocities in m/s."""
    size, (x, y) = 2 * half, velocities
    urdf = folder / "gantry.urdf"
    urdf.write_text(f"""<robot name="gantry"><link name="base"/><link name="bridge"/>
<link name="tip"><collision><geometry><box size="{size} {size} {size}"/></geometry></collision></link>
<joint name="x" type="prismatic"><parent link="base"/><child link="bridge"/><axis xyz="1 0 0"/>
  <limit lower="-9" upper="9" effort="1" velocity="{x}"/></joint>
<joint name="y" type="prismatic"><parent link="bridge"/><child link="tip"/><axis xyz="0 1 0"/>
  <limit lower="-9" upper="9" effort="1" velocity="{y}"/></joint>
</robot>""")
    return pc.Robot.from_urdf(urdf)


def gantry(folder: Path, *boxes: tuple[float, float, float, float]) -> pc.Checker:
    """A checker of the gantry among boxes, each of least x, y and largest x, y, m."""
    scene = pc.Scene("boxes")
    for k, (left, low, right, high) in enumerate(boxes):
        place = np.eye(4)
        place[:2, 3] = (left + right) / 2, (low + high) / 2
        scene.add_box(f"box{k}", (right - left, high - low, 1.0), place)
    return pc.Checker(gantry_robot(folder, HALF, (1.5, 0.5)), scene)
