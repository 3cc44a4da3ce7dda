"""Where pairs of bodies are left out: the list of all places, its order, and how many pairs each leaves out."""

import itertools
import re
from pathlib import Path

import pytest
from poses import at

import plannercheck as pc
from plannercheck.checking import left_out_pairs as places
from plannercheck.checking.left_out_pairs import left_out_pairs

PACKAGE = Path(__file__).parents[2] / "plannercheck"  # the sources: an installed package has none of the core

ARM = """
<robot name="arm">
  <link name="base"><collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision></link>
  <link name="plate"><collision><origin xyz="0.5 0 0"/><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <link name="upper"><collision><origin xyz="0.3 0 0"/><geometry><box size="0.5 0.1 0.1"/></geometry></collision></link>
  <link name="fore"><collision><origin xyz="0.2 0 0"/><geometry><box size="0.3 0.1 0.1"/></geometry></collision></link>
  <link name="hand"><collision><origin xyz="0.1 0 0"/><geometry><box size="0.05 0.1 0.1"/></geometry></collision></link>
  <joint name="bolt" type="fixed"><parent link="base"/><child link="plate"/></joint>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.3"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/>
    <origin xyz="0.6 0 0"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="wrist" type="revolute"><parent link="fore"/><child link="hand"/>
    <origin xyz="0.4 0 0"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>
"""

DESCRIPTION = """
name: arm
urdf: arm.urdf
disabled_pairs:
  - reason: by design
    pairs: [[upper, hand], [base, plate]]
"""


@pytest.fixture(scope="module")
def checker(tmp_path_factory):
    folder = tmp_path_factory.mktemp("arm")
    (folder / "arm.urdf").write_text(ARM)
    (folder / "arm.yaml").write_text(DESCRIPTION)
    scene = pc.Scene("cell")
    for name, place in {"far": (9, 0, 0), "near": (1, 0.2, 0.3), "mat": (0.9, 0.5, 0.3)}.items():
        scene.add_box(name, [0.1, 0.1, 0.1], at(*place))
    scene.allow("hand", "mat")
    scene.attach("cup", "hand", None, ["fore"], pc.Box([0.02, 0.02, 0.02]))
    return pc.Checker(pc.Robot.load(folder / "arm.yaml"), scene)


def test_the_list_names_the_places_in_the_order_in_which_they_count(checker):
    listed = re.findall(r"^([1-9])\. (\S+):", places.__doc__, re.MULTILINE)
    assert [int(number) for number, _ in listed] == list(range(1, 10))
    assert [where for _, where in listed] == [each.where for each in left_out_pairs(checker)]
    assert all((PACKAGE / where).exists() for _, where in listed)


def test_the_page_has_the_same_places():
    page = (PACKAGE.parent / "docs/explanation/pairs_left_out.md").read_text("utf-8")
    listed = re.findall(r"^([1-9])\. ", places.__doc__, re.MULTILINE)
    assert re.findall(r"^\| ([1-9]) \|", page, re.MULTILINE) == listed


def test_pairs_that_are_left_out_add_up(checker):
    found = left_out_pairs(checker)
    owners = ["base", "plate", "upper", "fore", "hand"]
    disabled = [{"upper", "hand"}, {"base", "plate"}]
    neighbours = [{"base", "upper"}, {"upper", "fore"}, {"fore", "hand"}]
    own = list(itertools.combinations(owners, 2))
    assert found[0].left == len(own) + 5 + 6 * 3 - 2  # the cup with five links; these and the cup with three obstacles
    assert found[0].number == sum(set(pair) in disabled for pair in own)
    assert found[1].number == sum(set(pair) in neighbours for pair in own)
    assert found[2].number == 2  # the cup with the hand and with the link that it may touch
    assert found[3].number == 2 * 3 + 1  # base and plate with each obstacle, hand with the mat
    assert found[3].left == len(checker.pairs)
    assert found[5].left == int((~checker.unreachable).sum()) < len(checker.pairs)
    assert found[4].number > 0
    assert found[-1].left == found[5].left - found[7].number
    assert [each.number is None for each in found] == [False] * 6 + [True, False, True]


def test_without_self_collision_the_table_of_pairs_leaves_self_pairs_out(checker):
    robot = checker.robot.carrying(())
    alone = left_out_pairs(pc.Checker(robot, None, self_collision=False))
    assert alone[3].number == len(robot.self_pairs) > 0
    assert alone[-1].left == 0


def test_a_pair_that_stands_still_and_touches_is_tested_once(checker):
    with pytest.warns(RuntimeWarning, match="touches 'plate' at every configuration"):
        found = left_out_pairs(checker.attach("vice", pc.Box([0.1, 0.1, 0.1]), "base", at(0.5, 0, 0)))
    assert found[7].number == 1
    assert found[7].left == found[6].left - 1
