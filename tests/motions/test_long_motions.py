"""A single motion keeps Python's lock, unless it takes long."""

import threading
from functools import partial

import numpy as np
import pytest

import plannercheck as pc

# Its box sweeps over the plate, 1e-9 m above it.
ARM = """<robot name="arm"><link name="base"/>
<link name="upper"><collision><origin xyz="0.25 0 0"/><geometry><box size="0.5 0.1 0.1"/></geometry></collision></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""
GAP = 1e-9

START, END = np.array([-1.0]), np.array([1.0])


@pytest.fixture(scope="module")
def checker(tmp_path_factory):
    urdf = tmp_path_factory.mktemp("long") / "arm.urdf"
    urdf.write_text(ARM)
    scene, pose = pc.Scene("plate"), np.eye(4)
    pose[2, 3] = 0.05 + GAP + 0.005
    scene.add_box("plate", [0.8, 0.8, 0.01], pose)
    return pc.Checker(pc.Robot.from_urdf(urdf), scene)


def test_other_threads_run_while_one_motion_takes_long(checker):
    """Thousands of grids a call; a machine that is busy may give the other thread nothing now and then.

    Compiled functions alone are between both looks: Python's own code would let the other thread run.
    """
    ran, ended = [0], threading.Event()

    def run():
        while not ended.is_set():
            ran[0] += 1

    look = partial(ran.__getitem__, 0)
    judged = partial(checker.motion_certifier.judge_rows, START, END, GAP / 4)
    thread = threading.Thread(target=run)
    thread.start()
    try:
        found = []
        for _ in range(50):
            before, free, after = list(map(partial.__call__, (look, judged, look)))
            assert free
            found.append(after > before)
            if found[-1]:
                break
    finally:
        ended.set()
        thread.join()
    assert any(found)


def test_a_long_motion_has_the_verdict_of_a_set(checker):
    for tolerance in (GAP / 4, GAP / 2, 2 * GAP, 1e-4):
        expected = checker.check_motions(START[None], END[None], tolerance=tolerance)
        assert [checker.check_motion(START, END, tolerance=tolerance)] == expected.tolist()
