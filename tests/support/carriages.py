"""A ball on a carriage that slides along x and another axis, as a URDF."""

AXES = {"y": "0 1 0", "z": "0 0 1"}


def carriage(second: str, radius: float) -> str:
    """The URDF of the carriage; its joints are called as their axes are."""
    return f"""<robot name="carriage"><link name="rail"/><link name="beam"/>
<link name="ball"><collision><geometry><sphere radius="{radius}"/></geometry></collision></link>
<joint name="x" type="prismatic"><parent link="rail"/><child link="beam"/><axis xyz="1 0 0"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="{second}" type="prismatic"><parent link="beam"/><child link="ball"/><axis xyz="{AXES[second]}"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""
