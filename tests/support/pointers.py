"""Arms of one or two joints, of which it is known which links collide, and by how much they miss."""

import plannercheck as pc

LIMIT = '<limit lower="-3" upper="3" effort="1" velocity="1"/>'


def arm(tmp_path, height: float, joint: str = "revolute"):
    """A pointer that turns over a post at -2 rad, whose tip passes at a height over the post's top."""
    path = tmp_path / "arm.urdf"
    path.write_text(
        '<robot name="arm"><link name="post"><collision><origin xyz="-0.4161 -0.9093 0"/><geometry>'
        '<box size="0.002 0.002 0.2"/>'
        '</geometry></collision></link><link name="hub"/><link name="pointer"><collision>'
        f'<origin xyz="0.5 0 {0.15 + height}"/><geometry><box size="1.002 0.002 0.1"/></geometry></collision></link>'
        '<joint name="lift" type="fixed"><parent link="post"/><child link="hub"/></joint>'
        f'<joint name="turn" type="{joint}"><parent link="hub"/><child link="pointer"/>'
        f'<axis xyz="0 0 1"/>{LIMIT}</joint>'
        '<link name="flag"><collision><origin xyz="9 0 0"/><geometry><sphere radius="0.1"/></geometry></collision>'
        "</link>"
        '<joint name="wave" type="revolute"><parent link="post"/><child link="flag"/><axis xyz="0 0 1"/>'
        f"{LIMIT}</joint></robot>"
    )
    return pc.Robot.from_urdf(path)


def disc(tmp_path, reach: float, slide: bool = False, height: float = 0.2):
    """A box at a distance from an axis in a post of 20 cm or so; or it slides along the post, by up to 3 m."""
    path = tmp_path / "disc.urdf"
    kind = "prismatic" if slide else "revolute"
    path.write_text(
        '<robot name="disc"><link name="post"><collision><geometry><box size="0.2 0.2 '
        f'{height}"/></geometry></collision></link>'
        f'<joint name="move" type="{kind}"><parent link="post"/><child link="arm"/><axis xyz="0 0 1"/>{LIMIT}</joint>'
        '<link name="arm"/><joint name="turn" type="revolute"><parent link="arm"/><child link="tip"/>'
        '<axis xyz="0 1 0"/>'
        f'{LIMIT}</joint><link name="tip"><collision><origin xyz="{reach} 0 0"/><geometry><box size="0.1 0.02 0.02"/>'
        "</geometry></collision></link></robot>"
    )
    return pc.Robot.from_urdf(path)
