"""Small MJCF files, each about one rule of MuJoCo's XML reference.

`RULES` maps the rule's name to (elements before the worldbody, the worldbody, elements after it). All of them load.
"""

_TETRA = 'vertex="0 0 0 .5 0 0 0 .1 0 0 0 .1 .2 .2 .3"'
_ARM = (
    '<body name="a"><geom name="ga" size=".1"/>'
    '<body name="b" pos="0 0 .3"><joint name="j" axis="0 1 0" range="-2 2"/>'
    '<geom name="gb" type="box" size=".1 .1 .1"/>'
    '<body name="c" pos="0 0 .3"><joint name="k" axis="0 1 0" range="-2 2"/><geom name="gc" size=".1"/>{}</body>'
    "</body></body>"
)
_ALL = _ARM.format("")
_FREE = '<body name="box" pos="1 0 0"><freejoint name="free"/><geom name="box" type="box" size=".1 .2 .3"/></body>'


def _moved(geom: str, joint: str = "", body: str = "") -> str:
    """A body that turns about z, with a geom and a sphere on a child."""
    return (
        f'<body name="a" {body}><joint name="j" axis="0 0 1" {joint}/><geom name="g" {geom}/>'
        '<body name="b" pos="0 0 .7"><joint name="k" axis="1 0 0"/><geom size=".1"/>'
        '<body name="c" pos="0 0 .7"><joint name="l" axis="1 0 0"/><geom size=".1"/></body></body></body>'
    )


def _mesh(more: str, *, geom: str = 'type="mesh" mesh="m"', before: str = "") -> tuple[str, str, str]:
    return f'{before}<asset><mesh name="m" {_TETRA} {more}/></asset>', _moved(geom), ""


_BOX = 'type="box" size=".3 .2 .1"'
_INNER = _moved(_BOX, body='pos=".1 .2 .3" quat="1 2 3 4"')
_RADIAN = '<compiler angle="radian"/>'

RULES: dict[str, tuple[str, str, str]] = {
    # Geoms: sizes, orientations, defaults.
    "sphere": ("", _moved('size=".3" pos=".1 .2 .3"'), ""),
    "capsule": ("", _moved('type="capsule" size=".1 .3"'), ""),
    "cylinder": ("", _moved('type="cylinder" size=".1 .3"'), ""),
    "ellipsoid": ("", _moved('type="ellipsoid" size=".1 .2 .3"'), ""),
    "box quat": ("", _moved(f'{_BOX} quat="1 2 3 4"'), ""),
    "box euler": ("", _moved(f'{_BOX} euler="10 20 30"'), ""),
    "box euler radian": (_RADIAN, _moved(f'{_BOX} euler=".1 .2 .3"'), ""),
    "eulerseq XYZ": ('<compiler eulerseq="XYZ"/>', _moved(f'{_BOX} euler="10 20 30"'), ""),
    "eulerseq zyx": ('<compiler eulerseq="zyx"/>', _moved(f'{_BOX} euler="10 20 30"'), ""),
    "eulerseq xYz": ('<compiler eulerseq="xYz"/>', _moved(f'{_BOX} euler="10 20 30"'), ""),
    "box axisangle": ("", _moved(f'{_BOX} axisangle="1 2 3 40"'), ""),
    "box xyaxes": ("", _moved(f'{_BOX} xyaxes="1 1 0 -1 1 1"'), ""),
    "box zaxis": ("", _moved(f'{_BOX} zaxis="1 2 3"'), ""),
    "capsule fromto": ("", _moved('type="capsule" size=".1" fromto=".1 .2 .3 .5 .1 -.2"'), ""),
    "box fromto": ("", _moved('type="box" size=".1 .05" fromto=".1 .2 .3 .5 .1 -.2"'), ""),
    "ellipsoid fromto": ("", _moved('type="ellipsoid" size=".1" fromto=".1 .2 .3 .1 .2 .9"'), ""),
    "main default": ('<default><geom euler="0 0 30" type="box" size=".2 .02 .02"/></default>', _moved(""), ""),
    "default class": (
        '<default><default class="z"><geom type="box" size=".2 .05 .05" quat="1 0 0 1"/></default></default>',
        _moved('class="z"'),
        "",
    ),
    "nested default class": (
        '<default><geom size=".1 .2 .3"/><default class="y"><geom type="box"/><default class="z"><geom quat="1 0 0 1"/>'
        "</default></default></default>",
        _moved('class="z"'),
        "",
    ),
    "childclass": (
        '<default><default class="z"><geom type="box" size=".2 .1 .1"/><joint type="slide"/></default></default>',
        _moved("", body='childclass="z"'),
        "",
    ),
    # Meshes.
    "mesh": _mesh(""),
    "mesh scale": _mesh('scale="2 1 -1"'),
    "mesh refpos": _mesh('refpos=".2 0 .1"'),
    "mesh refquat": _mesh('refquat="1 2 3 4"'),
    "mesh default scale": _mesh("", before='<default><mesh scale="2 1 1"/></default>'),
    "mesh class scale": _mesh(
        'class="k"', before='<default><default class="k"><mesh scale="2 1 1"/></default></default>'
    ),
    "mesh with faces": _mesh('face="0 2 1 0 1 3 0 3 2 1 2 4 2 3 4 3 1 4"'),
    "mesh of geom pose": _mesh("", geom='type="mesh" mesh="m" pos=".1 .2 .3" euler="10 20 30"'),
    "box fitted": _mesh("", geom='type="box" mesh="m" pos=".1 0 0"'),
    "sphere fitted": _mesh("", geom='type="sphere" mesh="m"'),
    "capsule fitted": _mesh("", geom='type="capsule" mesh="m" fitscale="1.5"'),
    "cylinder fitted": _mesh("", geom='type="cylinder" mesh="m"'),
    "ellipsoid fitted": _mesh("", geom='type="ellipsoid" mesh="m" quat="1 0 1 0"'),
    "box fitted to aabb": _mesh("", geom='type="box" mesh="m"', before='<compiler fitaabb="true"/>'),
    # Joints.
    "hinge anchor": ("", _moved(_BOX, 'pos=".3 .2 .1"'), ""),
    "hinge axis": ("", _moved(_BOX, "").replace('axis="0 0 1"', 'axis="1 2 3"', 1), ""),
    "hinge against x": ("", _moved(_BOX).replace('axis="0 0 1"', 'axis="-1 0 0"', 1), ""),
    "hinge ref": ("", _moved(_BOX, 'ref="30" range="-20 60" pos=".1 0 0"'), ""),
    "slide ref": ("", _moved(_BOX, 'type="slide" ref=".3" range="-.2 .6" pos=".1 0 0"'), ""),
    "springref": ("", _moved(_BOX, 'springref="30"'), ""),
    "range limits": ("", _moved(_BOX, 'range="-20 60"'), ""),
    "range of no limit": ('<compiler autolimits="false"/>', _moved(_BOX, 'range="-20 60" limited="false"'), ""),
    "range by limited": ('<compiler autolimits="false"/>', _moved(_BOX, 'range="-20 60" limited="true"'), ""),
    "ball": ("", _moved(_BOX, 'type="ball" pos=".3 .2 .1"'), ""),
    "free": ("", _FREE + _moved(_BOX), ""),
    "free that turns in the file": ("", _FREE.replace('pos="1 0 0"', 'pos="1 0 0" euler="10 20 30"'), ""),
    "hinge and slide": ("", _moved(_BOX).replace("<geom", '<joint name="s" type="slide" axis="1 1 0"/><geom', 1), ""),
    "hinge and ball": (
        "",
        _moved(_BOX, 'pos=".1 0 0"').replace("<geom", '<joint name="s" type="ball" pos="0 .2 0"/><geom', 1),
        "",
    ),
    "three hinges off their origin": (
        "",
        _moved(_BOX, 'pos=".1 0 0" ref="20"').replace(
            "<geom", '<joint axis="1 0 0" pos="0 .2 0" ref="-10"/><joint axis="0 1 0" pos="0 0 .3"/><geom', 1
        ),
        "",
    ),
    # Bodies.
    "body poses": ("", f'<body pos="1 2 3" euler="10 20 30">{_INNER}</body>', ""),
    "several roots": ("", _ALL + _ALL.replace('name="', 'name="other_').replace("<body", '<body pos="2 0 0"', 1), ""),
    "frame": ("", f'<frame pos="0 0 1" euler="0 30 0">{_moved(_BOX)}</frame>', ""),
    "frame around a geom": (
        "",
        _moved(_BOX).replace(
            '<body name="b"',
            '<frame pos="0 1 0" euler="9 8 7"><geom type="box" size=".1 .1 .2"/></frame><body name="b"',
            1,
        ),
        "",
    ),
    "replicate": ("", f'<replicate count="3" offset="1 0 0" euler="0 0 30">{_ALL}</replicate>', ""),
    "site, camera and light": ("", _moved(_BOX).replace("<geom", '<site size="1"/><camera/><light/><geom', 1), ""),
    "keyframe": ("", _moved(_BOX), '<keyframe><key qpos="1 1 1"/></keyframe>'),
    "fusestatic": (
        '<compiler fusestatic="true"/>',
        _ARM.format('<body pos="0 0 .3"><geom type="box" size=".1 .1 .1"/></body>'),
        "",
    ),
    "discardvisual": (
        '<compiler discardvisual="true"/>',
        _ARM.format('<geom contype="0" conaffinity="0" size="1"/>'),
        "",
    ),
    "inertiafromgeom": ('<compiler inertiafromgeom="true"/>', _ALL, ""),
    "mocap above joints": ("", f'<body name="m" mocap="true" pos="1 2 3"><geom size=".1"/>{_ALL}</body>', ""),
    # Pairs.
    "neighbours": ("", _ALL, ""),
    "filterparent off": ('<option><flag filterparent="disable"/></option>', _ALL, ""),
    "contact off": ('<option><flag contact="disable"/></option>', _ALL, ""),
    "constraint off": ('<option><flag constraint="disable"/></option>', _ALL, ""),
    "welded body of a link": ("", _ARM.format('<body name="d" pos="0 0 .3"><geom name="gd" size=".1"/></body>'), ""),
    "neighbour of a welded body": (
        "",
        _ARM.format(
            '<body name="d" pos="0 0 .3"><geom name="gd" size=".1"/><body name="e" pos="0 0 .3"><joint axis="0 1 0"/>'
            '<geom name="ge" size=".1"/></body></body>'
        ),
        "",
    ),
    "exclude": ("", _ALL, '<contact><exclude body1="c" body2="a"/></contact>'),
    "exclude of the world": (
        "",
        '<geom name="w" size=".1"/>' + _ALL,
        '<contact><exclude body1="world" body2="c"/></contact>',
    ),
    "pair": ("", _ALL, '<contact><pair geom1="gc" geom2="gb"/></contact>'),
    "pair of an excluded one": (
        "",
        _ALL,
        '<contact><exclude body1="a" body2="c"/><pair geom1="ga" geom2="gc"/></contact>',
    ),
    "pair without masks": (
        '<default><geom contype="0" conaffinity="0"/></default>',
        _ALL,
        '<contact><pair geom1="ga" geom2="gc"/></contact>',
    ),
    "pair on one body": (
        "",
        _ARM.format('<geom name="gd" size=".1"/>'),
        '<contact><pair geom1="gd" geom2="gc"/></contact>',
    ),
    "masks one way": (
        '<default><geom contype="2" conaffinity="4"/></default>',
        _ARM.format('<geom name="gd" size=".1" contype="4" conaffinity="0"/>'),
        "",
    ),
    "masks of two geoms of a body": (
        "",
        _ARM.format('<geom name="gd" size=".1" contype="2" conaffinity="2"/>')
        + '<geom name="w" size=".1" contype="3"/>',
        "",
    ),
    "margin and gap": ('<default><geom margin="1" gap=".5"/></default>', _ALL, ""),
    # The world.
    "plane": ("", '<geom name="floor" type="plane" size="0 0 1" pos="0 0 -1" euler="10 0 0"/>' + _ALL, ""),
    "plane on the base": ("", _ALL.replace("<geom", '<geom name="floor" type="plane" size="1 1 1"/><geom', 1), ""),
    "height field": (
        '<asset><hfield name="h" nrow="3" ncol="4" size="1 2 .2 .1" elevation="0 1 0 2 0 1 1 1 2 1 0 1"/></asset>',
        '<geom name="hills" type="hfield" hfield="h" pos="1 0 -1" euler="0 0 30"/>' + _ALL,
        "",
    ),
    "table": ("", '<body name="table" pos="1 0 0"><geom name="top" type="box" size=".3 .3 .1"/></body>' + _ALL, ""),
    "mocap": ("", '<body name="hand" mocap="true" pos="1 0 0"><geom name="hand" size=".1"/></body>' + _ALL, ""),
    "static base and world": ("", '<geom name="w" type="box" size="1 1 .01"/>' + _ALL, ""),
    # Equalities.
    "equality": ("", _ALL, '<equality><joint joint1="k" joint2="j" polycoef=".1 -2"/></equality>'),
    "equality with ref": (
        "",
        _ALL.replace('name="j"', 'name="j" ref="1"').replace('name="k"', 'name="k" ref="-.5"'),
        '<equality><joint joint1="k" joint2="j" polycoef=".1 -2"/></equality>',
    ),
    "equality off": ("", _ALL, '<equality><joint joint1="k" joint2="j" polycoef="0 1 1" active="false"/></equality>'),
    "weld": ("", _ALL, '<equality><weld body1="c"/></equality>'),
}


def mjcf(rule: str) -> str:
    """The file of a rule."""
    before, world, after = RULES[rule]
    return f'<mujoco model="rule">{before}<worldbody>{world}</worldbody>{after}</mujoco>'
