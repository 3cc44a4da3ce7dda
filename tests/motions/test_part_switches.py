"""Trees of sets of parts and all that spares parts a test change no verdict: against each part tested by itself."""

from functools import cache

import numpy as np
import pytest

import plannercheck as pc

RNG = np.random.default_rng(11)


@cache
def panda():
    return pc.Robot.load("panda")


def cloud(count, low=0.002, high=0.03):
    """Balls before the arm, some of which it reaches."""
    points = RNG.uniform((0.25, -0.6, 0.0), (0.8, 0.6, 1.0), size=(count, 3))
    return pc.PointCloud(points, RNG.uniform(low, high, size=count))


def octree():
    cells = np.random.default_rng(2).integers((4, -10, 0), (14, 10, 14), size=(90, 3))
    return pc.Octree.from_cells(np.unique(cells, axis=0), 0.06)


def field():
    heights = RNG.uniform(-0.2, 0.1, size=(9, 9))
    heights[2, 3] = np.nan
    return pc.HeightField(heights, 0.15, -0.3, (-0.6, -0.6))


SETS = {
    "cloud": lambda: cloud(60),
    "one ball": lambda: cloud(1, 0.2, 0.3),
    "coplanar": lambda: pc.PointCloud(cloud(40).points * [1, 1, 0] + [0, 0, 0.4], 0.02),
    "octree": octree,
    "field": field,
}


def scene_of(shape, pose=None):
    scene = pc.Scene("sensed")
    scene.add("camera", shape, pose)
    for link in ("panda_link0", "panda_link1"):
        scene.allow("camera", link)
    return scene


def tilted():
    pose = np.eye(4)
    pose[:3, :3] = [[np.cos(0.2), 0, np.sin(0.2)], [0, 1, 0], [-np.sin(0.2), 0, np.cos(0.2)]]
    pose[:3, 3] = 0.02, 0.01, 0.03
    return pose


def states(count, seed):
    return panda().random_configurations(count, seed=seed)


def motions(count, seed, length):
    rng = np.random.default_rng(seed)
    start = states(count, seed)
    way = rng.normal(size=start.shape)
    end = start + way * (length / np.linalg.norm(way, axis=1, keepdims=True))
    return start, np.clip(end, panda().lower, panda().upper)


@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize("others", [{}, {"bounds": False, "boxes": False, "overlaps": False}])
@pytest.mark.parametrize("padding", [0.0, 0.02])
def test_verdicts_of_states(name, others, padding):
    scene = scene_of(SETS[name](), tilted())
    on, off = (
        pc.Checker(panda(), scene, padding=padding, tuning=pc.Tuning(part_trees=each, **others))
        for each in (True, False)
    )
    q = states(400, 3)
    valid = on.check_states(q)
    assert (off.check_states(q) == valid).all()
    assert [off.is_valid(row) for row in q[:60]] == valid[:60].tolist()
    beside = pc.Checker(panda(), None, padding=padding).check_states(q)
    assert (beside & ~valid).any()  # the set decides
    assert valid.any()


@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize("length", [0.1, 0.7])
@pytest.mark.parametrize("bounds", [True, False])
def test_verdicts_of_motions(name, length, bounds):
    scene = scene_of(SETS[name](), tilted())
    on, off = (
        pc.Checker(panda(), scene, self_collision=False, tuning=pc.Tuning(part_trees=each, bounds=bounds))
        for each in (True, False)
    )
    start, end = motions(120, 5, length)
    free, plainly = on.check_motions(start, end), off.check_motions(start, end)
    for k in np.flatnonzero(free != plainly):  # either may refuse what comes within the tolerance
        along = on.motion_certifier.states(start[k], end[k], np.linspace(0, 1, 400))
        assert on.clearances(along).min() < 2e-4
    assert (free != plainly).mean() < 0.02
    assert 0 < plainly.mean() < 1
    for q0, q1 in zip(start[plainly], end[plainly], strict=True):
        assert on.check_states(on.motion_certifier.states(q0, q1, np.linspace(0, 1, 40))).all()


def test_verdicts_of_two_sets():
    """A carried set before another one: parts of both, each with each."""
    scene = scene_of(cloud(40))
    held = pc.PointCloud(RNG.normal(size=(12, 3)) * 0.05 + [0, 0, 0.12], 0.01)
    scene.attach("held", "panda_hand", parts=held)
    for finger in ("panda_hand", "panda_leftfinger", "panda_rightfinger", "panda_link7", "panda_link8"):
        scene.allow("held", finger)
    on, off = (pc.Checker(panda(), scene, tuning=pc.Tuning(part_trees=each)) for each in (True, False))
    q = states(400, 9)
    valid = on.check_states(q)
    assert (off.check_states(q) == valid).all()
    assert 0 < valid.mean() < 1
    start, end = motions(60, 2, 0.2)
    assert (on.check_motions(start, end) == off.check_motions(start, end)).all()


def test_verdicts_of_solids_before_a_cloud():
    robot = pc.Robot.load("ur10", geometry={"upper_arm_link": "solid"})
    scene = pc.Scene("sensed")
    points = np.random.default_rng(0).uniform((-1, -1, -0.2), (1, 1, 1.2), size=(25, 3))
    scene.add("camera", pc.PointCloud(points, 0.04))
    on, off = (
        pc.Checker(robot, scene, tuning=pc.Tuning(part_trees=each), self_collision=False) for each in (True, False)
    )
    q = robot.random_configurations(300, seed=1)
    valid = on.check_states(q)
    assert (off.check_states(q) == valid).all()
    assert 0 < valid.mean() < 1


def test_the_switch_does_something():
    """Off, no part is left out: links are asked for their support far more often."""
    counts = []
    for each in (True, False):
        checker = pc.Checker(
            panda(), scene_of(octree()), self_collision=False, tuning=pc.Tuning(bounds=False, part_trees=each)
        )
        assert not checker.check_states(states(300, 6)).all()
        queries = checker.statistics()["queries"]
        counts.append(queries["queries_a"] + queries["queries_b"])
    assert counts[1] > 2 * counts[0]


@pytest.mark.parametrize("height", [0.05, 0.2])
def test_the_filter_before_half_spaces_has_its_switch(height):
    """Balls above planes are part of `bounds`."""
    scene = pc.Scene("floor")
    scene.add("floor", pc.HalfSpace((0.1, 0.0, 1.0), height))
    for link in ("panda_link0", "panda_link1"):
        scene.allow("floor", link)
    on, off = (
        pc.Checker(panda(), scene, tuning=pc.Tuning(bounds=each), self_collision=False) for each in (True, False)
    )
    q = states(500, 4)
    valid = on.check_states(q)
    assert (off.check_states(q) == valid).all()
    assert 0 < valid.mean() < 1


# A cup: a square ring of corners each at the foot, the rim outside and inside, and the ground inside.
CUP_RINGS = ((0.1, 0.0), (0.1, 0.2), (0.08, 0.2), (0.08, 0.02))
CUP_LINKS = """<link name="{child}"/><joint name="to {child}" type="prismatic"><parent link="{parent}"/>
<child link="{child}"/><axis xyz="{axis}"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>"""


def cup(folder):
    """A robot that is a cup, a solid, and slides in all directions."""
    corners = [(x * h, y * h, z) for h, z in CUP_RINGS for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    faces = [(0, 2, 1), (0, 3, 2), (12, 13, 14), (12, 14, 15)]
    for ring in (0, 4, 8):
        for k in range(4):
            a, b = ring + k, ring + (k + 1) % 4
            faces += [(a, b, b + 4), (a, b + 4, a + 4)]
    lines = ["v {} {} {}".format(*corner) for corner in corners]
    lines += ["f {} {} {}".format(*(k + 1 for k in face)) for face in faces]
    (folder / "cup.obj").write_text("\n".join(lines) + "\n")
    links = [("base", "x", "1 0 0"), ("x", "y", "0 1 0"), ("y", "cup", "0 0 1")]
    made = "".join(CUP_LINKS.format(parent=a, child=b, axis=axis) for a, b, axis in links)
    body = '<link name="cup"><collision><geometry><mesh filename="cup.obj"/></geometry></collision></link>'
    made = made.replace('<link name="cup"/>', body)
    (folder / "cup.urdf").write_text(f'<robot name="cup"><link name="base"/>{made}</robot>')
    return pc.Robot.from_urdf(folder / "cup.urdf", geometry="solid")


def test_parts_in_a_hollow_are_settled_as_on_ever_shorter_intervals(tmp_path):
    """A cup goes a little with balls in its hollow, from contact to a few tolerances."""
    rng = np.random.default_rng(2)
    scene = pc.Scene("balls")
    scene.add("cloud", pc.PointCloud(rng.uniform(-0.02, 0.02, (5, 3)) + np.array([0, 0, 0.1]), 0.005))
    robot = cup(tmp_path)
    on, off = (pc.Checker(robot, scene, tuning=pc.Tuning(hollows=each)) for each in (True, False))
    start = rng.uniform(-0.03, 0.03, (60, 3))
    start[:, 0] = rng.choice([-1, 1], 60) * rng.uniform(0.048, 0.06, 60)
    end = start + rng.uniform(-0.003, 0.003, (60, 3))
    for tolerance in (5e-4, 1e-3, 4e-3):
        free = on.check_motions(start, end, tolerance=tolerance)
        assert 0 < free.mean() < 1
        np.testing.assert_array_equal(off.check_motions(start, end, tolerance=tolerance), free)
    grids = [checker.motion_certifier.statistics()["grids"] for checker in (on, off)]
    assert grids[0] < 0.8 * grids[1]
    # Far from contact, parts in the hollow need few grids for long motions.
    before = on.motion_certifier.statistics()["grids"]
    assert on.check_motions(0.4 * start, -0.4 * start).all()
    assert on.motion_certifier.statistics()["grids"] - before < 10 * len(start)
