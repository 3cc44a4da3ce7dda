"""Robots with continuous joints and no group: `plan` and the command line plan for the same angles."""

import json

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.cli.main import main

BAR = '<collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.1 0.1"/></geometry></collision>'
SLIDING = '<axis xyz="1 0 0"/><limit lower="0" upper="0.3" effort="1" velocity="1"/>'
URDF = f"""<robot name="crane"><link name="base"/><link name="bar">{BAR}</link><link name="left"/><link name="right"/>
<joint name="turn" type="continuous"><parent link="base"/><child link="bar"/><axis xyz="0 0 1"/></joint>
<joint name="open" type="prismatic"><parent link="bar"/><child link="left"/>{SLIDING}</joint>
<joint name="partner" type="prismatic"><parent link="bar"/><child link="right"/>{SLIDING}<mimic joint="open"/></joint>
</robot>"""
START, GOAL = [-2.5, 0.1], [2.4, 0.2]  # turn and open


@pytest.fixture
def urdf(tmp_path):
    path = tmp_path / "crane.urdf"
    path.write_text(URDF)
    return path


@pytest.fixture
def scene():
    """A post on the short way, so that the bar has to turn the long way."""
    scene, pose = pc.Scene("post"), np.eye(4)
    pose[0, 3] = -0.8
    scene.add_box("post", [0.1, 0.1, 1.0], pose)
    return scene


@pytest.fixture
def checker(urdf, scene):
    return pc.Checker(pc.Robot.from_urdf(urdf), scene)


def pinocchios(row):
    return [np.cos(row[0]), np.sin(row[0]), row[1], row[1]]


@pytest.mark.parametrize(
    "given",
    [
        lambda row: row,
        lambda row: [*row, row[1]],
        pinocchios,
        lambda row: dict(zip(("turn", "open"), row, strict=True)),
        lambda row: {"turn": row[0], "open": row[1], "partner": row[1]},
    ],
    ids=["own", "every", "pinocchio", "names", "all names"],
)
def test_a_plan_is_in_angles_however_the_ends_are_given(checker, given):
    plan = pc.ompl.plan(checker, given(START), given(GOAL), seed=1)
    assert plan.solved, plan.reason
    assert plan.joint_names == ("turn", "open")
    np.testing.assert_allclose(plan.path[[0, -1]], [START, GOAL], atol=1e-12)
    assert checker.check_motions(plan.path[:-1], plan.path[1:]).all()
    assert plan.length > 4.8  # the long way round
    whole = np.array([pinocchios(row) for row in plan.path])
    assert checker.check_motions(whole[:-1], whole[1:]).all()


def test_the_command_line_finds_the_same(checker, scene, urdf, tmp_path, capsys):
    scene.save(tmp_path / "post.yaml")
    ends = [f"--{name}={','.join(map(str, row))}" for name, row in (("start", START), ("goal", GOAL))]
    options = ["--robot", str(urdf), "--scene", str(tmp_path / "post.yaml"), "--seed", "3", "--no-simplify"]
    assert main(["plan", *options, *ends, "--output", str(tmp_path / "plan.json")]) == 0, capsys.readouterr()
    plan = pc.ompl.plan(checker, START, GOAL, seed=3, simplify=False)
    assert json.loads((tmp_path / "plan.json").read_text())["path"] == plan.path.tolist()


def test_followers_that_are_elsewhere_are_no_start(checker):
    with pytest.raises(pc.PlannercheckError, match=r"start: .* follow others are off by 0\.05; .*: turn, open"):
        pc.ompl.plan(checker, [*START, 0.15], GOAL)


def test_after_a_change_of_the_scene_the_new_one_is_planned_in(checker):
    assert pc.ompl.plan(checker, START, GOAL, seed=1).length > 4.8
    assert pc.ompl.plan(checker.with_scene(None), START, GOAL, seed=1).length < 2.0


def test_a_group_keeps_what_the_checker_has(urdf, scene):
    """The padding, also entries that are set aside, and what is carried."""
    padding = {("bar", "post"): 0.2, ("post", "box"): 0.01}
    scene.add_box("box", [0.1, 0.1, 0.1], np.array([[1, 0, 0, 1.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]]))
    scene.attach("box", "bar")
    checker = pc.Checker(pc.Robot.from_urdf(urdf), scene, padding=padding)
    later = checker.detach("box")
    for each in (checker, later):
        group = each.with_group(["turn"])
        q = np.linspace(-3, 3, 200)
        rows = np.stack([np.cos(q), np.sin(q), 0 * q, 0 * q], axis=1)
        np.testing.assert_array_equal(group.check_states(q[:, None]), each.check_states(rows))
        np.testing.assert_allclose(group.clearances(q[:, None]), each.clearances(rows), rtol=1e-12, atol=1e-12)
        assert [group.pair_names(k) for k in range(len(group.pairs))] == [
            each.pair_names(k) for k in range(len(each.pairs))
        ]


def test_a_set_up_says_which_group_to_choose(checker):
    with pytest.raises(pc.PlannercheckError, match=r"'turn' of crane .* choose a planning group .* is one angle"):
        pc.ompl.setup(checker)
