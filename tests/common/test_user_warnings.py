"""Warnings name the line of the user's code, not one of the package."""

import warnings

import numpy as np
import pytest

import plannercheck as pc

TOUCHING = """<robot name="r"><link name="a"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
<link name="b"/><joint name="j" type="fixed"><parent link="a"/><child link="b"/>{}</joint></robot>"""


def blamed(caught):
    return {each.filename for each in caught}


def test_calls_that_call_others_blame_the_users_line():
    robot, scene = pc.Robot.load("panda"), pc.Scene()
    checker = pc.Checker(robot, scene)
    scene.add_box("floor", [1, 1, 1], None)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        held = checker.attach("can", pc.Sphere(0.3), "panda_link0", np.eye(4))
        pc.Checker(robot, scene)
        checker.with_scene(scene)
        held.detach("can", robot.reference)
    assert sum("touches" in str(each.message) for each in caught) == 3
    assert blamed(caught) == {__file__}


@pytest.mark.parametrize("load", [pc.Robot.load, pc.Robot.from_urdf])
def test_loading_blames_the_users_line(tmp_path, load):
    (tmp_path / "r.urdf").write_text(TOUCHING.format("<oirgin xyz='0 0 1'/>"))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        load(tmp_path / "r.urdf")
    assert any("oirgin" in str(each.message) for each in caught)
    assert blamed(caught) == {__file__}
