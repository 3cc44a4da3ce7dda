"""What an SRDF says: pairs as MoveIt 2's AllowedCollisionMatrix of an srdf::Model has them, states and groups."""

import contextlib
import itertools
import re
import warnings

import numpy as np
import pytest

import plannercheck as pc

LINKS = ("a", "b", "c", "d", "e")
BALL = '<collision><geometry><sphere radius="0.5"/></geometry></collision>'


@pytest.fixture
def urdf(tmp_path):
    """A chain of links on joints of their own, so that no pair is left out for its joint."""
    joints = "".join(
        f'<joint name="{one}{other}" type="revolute"><parent link="{one}"/><child link="{other}"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        for one, other in itertools.pairwise(LINKS)
    )
    links = "".join(f'<link name="{link}">{BALL}</link>' for link in LINKS)
    path = tmp_path / "r.urdf"
    path.write_text(f'<robot name="r">{links}{joints}</robot>')
    return path


def loaded(urdf, elements, *words):
    """The robot with an SRDF of these elements; warnings must hold the words, one each."""
    srdf = urdf.with_suffix(".srdf")
    srdf.write_text(f'<robot name="r">{elements}</robot>')
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        robot = pc.Robot.from_urdf(urdf, srdf)
    said = [str(each.message) for each in caught if "disables no pair" not in str(each.message)]
    assert len(said) == len(words), said
    assert all(any(word in each for each in said) for word in words), said
    return robot


def pairs_tested(robot):
    return {frozenset(robot.bodies[k].link for k in pair) for pair in robot.self_pairs.tolist()}


class Matrix:
    """AllowedCollisionMatrix, by its sources: entries by pair, defaults by name, entries first."""

    def __init__(self, elements):
        self.entries, self.defaults = {}, set()
        for tag in ("disable_default_collisions", "enable_collisions", "disable_collisions"):
            for kind, *names in elements:
                if kind == tag == "disable_default_collisions":
                    self.defaults.add(names[0])
                elif kind == tag:
                    self.entries[frozenset(names)] = kind == "disable_collisions"

    def allows(self, one, other):
        return self.entries.get(frozenset((one, other)), one in self.defaults or other in self.defaults)


def written(elements):
    return "".join(
        f'<{kind} link="{names[0]}"/>' if len(names) == 1 else f'<{kind} link1="{names[0]}" link2=" {names[1]} "/>'
        for kind, *names in elements
    )


@pytest.mark.parametrize("seed", range(30))
def test_pairs_are_those_of_moveits_matrix(urdf, seed):
    rng = np.random.default_rng(seed)
    elements = [
        (kind, *rng.choice(LINKS, 1 if kind == "disable_default_collisions" else 2, replace=False).tolist())
        for kind in rng.choice(["disable_default_collisions", "enable_collisions", "disable_collisions"], 6)
    ]
    matrix = Matrix(elements)
    robot = loaded(urdf, written(elements), *["tested neither against obstacles"] * bool(matrix.defaults))
    assert pairs_tested(robot) == {
        frozenset(pair) for pair in itertools.combinations(LINKS, 2) if not matrix.allows(*pair)
    }
    scene = pc.Scene()
    scene.add_sphere("ball", 1.0)
    checker = pc.Checker(robot, scene)
    obstacles = checker.pairs[(checker.pairs >= len(robot.bodies)).any(axis=1)].min(axis=1)
    links = {robot.bodies[k].link for k in obstacles.tolist()} | {"a"}  # which is fixed, and so tested once
    assert links == set(LINKS) - matrix.defaults | {"a"}


def test_a_link_that_is_disabled_by_default_is_not_tested_against_obstacles(urdf):
    scene = pc.Scene()
    scene.add_sphere("ball", 0.1)
    for link in LINKS[1:]:
        elements = [("disable_default_collisions", other) for other in LINKS[1:] if other != link]
        robot = loaded(urdf, written([*elements, ("disable_collisions", "a", link)]), "tested neither")
        assert not pc.Checker(robot, scene).is_valid(np.zeros(4))
        elements.append(("disable_default_collisions", link))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a is fixed and touches the ball
            assert pc.Checker(loaded(urdf, written(elements), "tested neither"), scene).is_valid(np.zeros(4))


@pytest.mark.parametrize("seed", range(20))
def test_what_a_scene_says_of_a_pair_comes_before_the_defaults_of_links(urdf, seed):
    """AllowedCollisionMatrix::getAllowedCollision: an entry, else the defaults, of which the stricter one counts."""
    rng = np.random.default_rng(seed)
    idle = [link for link in LINKS[1:] if rng.random() < 0.5] or ["b"]
    robot = loaded(urdf, written([("disable_default_collisions", link) for link in idle]), "tested neither")
    scene = pc.Scene()
    scene.add_sphere("ball", 1.0)
    scene.attach("tool", "a", parts=pc.Sphere(0.1))
    defaults = dict.fromkeys(idle, True)
    for name in (*LINKS, "ball", "tool"):
        if rng.random() < 0.3:
            defaults[name] = scene.allowed.defaults[name] = bool(rng.random() < 0.5)
    entries = {}
    for pair in itertools.product(LINKS, ("ball", "tool")):
        if rng.random() < 0.4:
            entries[pair] = bool(rng.random() < 0.5)
            scene.allow(*pair, entries[pair])
    truth = {
        (link, item)
        for link, item in itertools.product(LINKS[1:], ("ball", "tool"))
        if not entries.get((link, item), {defaults.get(link), defaults.get(item)} - {None} == {True})
    }
    scene.save(urdf.with_name("scene.yaml"))
    for said in (scene, pc.Scene.load(urdf.with_name("scene.yaml"))):
        checker = pc.Checker(robot, said)
        names = map(checker.pair_names, range(len(checker.pairs)))
        assert {pair for pair in names if pair[1] in ("ball", "tool") and pair[0] in LINKS} == truth


def test_elements_that_name_nothing_are_passed_over_with_one_warning_each(urdf):
    elements = [("disable_collisions", "a", "x"), ("enable_collisions", "y", "b"), ("disable_default_collisions", "z")]
    words = [
        f"<{kind}> of links that the URDF does not know: {name}"
        for (kind, *_), name in zip(elements, "xyz", strict=True)
    ]
    robot = loaded(urdf, written(elements), *words)
    assert len(pairs_tested(robot)) == 10
    nameless = '<disable_collisions link1="a"/><enable_collisions/><disable_default_collisions/>'
    assert len(pairs_tested(loaded(urdf, nameless, "3 elements that name no links"))) == 10


@pytest.mark.parametrize(
    ("elements", "word"),
    [
        ('<disable_collision link1="a" link2="c"/>', "<disable_collision>, misspelt"),
        ('<Enable_collisions link1="a" link2="c"/>', "<Enable_collisions>, misspelt"),
        ('<pairs><disable_collisions link1="a" link2="c"/></pairs>', "<disable_collisions>, misspelt or within"),
        ('<gripper name="of another program"><position/></gripper>', None),
    ],
)
def test_misspelt_and_misplaced_elements_are_warned_of(urdf, elements, word):
    assert len(pairs_tested(loaded(urdf, elements, *([] if word is None else [word])))) == 10


def test_enabled_pairs_on_one_joint_are_said_to_be_left_out(urdf):
    urdf.write_text(urdf.read_text().replace('type="revolute"', 'type="fixed"', 1))
    robot = loaded(urdf, written([("enable_collisions", "a", "b")]), "links on one joint, which never move")
    assert frozenset("ab") not in pairs_tested(robot)


def test_carried_objects_are_not_tested_against_links_that_are_disabled_by_default(urdf):
    scene = pc.Scene()
    scene.add_sphere("tool", 0.1)
    scene.attach("tool", "e")
    checker = pc.Checker(loaded(urdf, written([("disable_default_collisions", "b")]), "tested neither"), scene)
    held = len(checker.robot.bodies) - 1
    against = {checker.robot.bodies[min(pair)].link for pair in checker.pairs.tolist() if held in pair}
    assert against == {"a", "c", "d"}


# ---- states and groups

GROUPS = '<group name="arm"><joint name="ab"/></group><group name="hand"><joint name="de"/></group>'


def state(group, name="home", **values):
    joints = "".join(f'<joint name="{joint}" value="{value}"/>' for joint, value in values.items())
    return f'<group_state name="{name}" group="{group}">{joints}</group_state>'


def stated(urdf, elements, group=None):
    srdf = urdf.with_suffix(".srdf")
    srdf.write_text(f'<robot name="r">{elements}</robot>')
    return pc.Robot.from_urdf(urdf, srdf, group=group, reference="home")


@pytest.mark.parametrize(
    ("group", "ab", "de"),
    [("arm", [0.5], None), ("hand", None, [0.25]), (None, [0.5], [0.25]), (["ab", "de"], [0.5], [0.25])],
)
def test_a_state_is_that_of_the_group(urdf, group, ab, de):
    """MoveIt keeps default states by group (JointModelGroup::addDefaultState)."""
    robot = stated(urdf, GROUPS + state("arm", ab=0.5) + state("hand", de=0.25), group)
    found = dict(zip(robot.joint_names, robot.reference.tolist(), strict=True))
    for joint, value in (("ab", ab), ("de", de)):
        assert value is None or found[joint] == value[0]


@pytest.mark.parametrize(
    ("states", "words"),
    [
        (state("arm", ab="abc"), "value of joint 'ab' in group state 'home' must be a finite number, not 'abc'"),
        (state("arm", ab="0,5"), "must be a finite number, not '0,5'"),
        (state("arm", ab="nan"), "must be a finite number, not 'nan'"),
        (state("arm", ab=""), "must be a finite number, not ''"),
        ('<group_state name="home" group="arm"><joint name="ab"/></group_state>', "not missing"),
        (state("arm", ab=0.5).replace("<joint", '<joint name="ab" value="0.1"/><joint'), "is both [0.1] and [0.5]"),
        (state("arm", ab=0.5) + state("other", ab=0.25), "is both [0.5] and [0.25]: keep one"),
    ],
)
def test_states_that_can_not_be_read_name_file_and_joint(urdf, states, words):
    with pytest.raises(pc.PlannercheckError, match=rf"SRDF .*r\.srdf.*{re.escape(words)}"):
        stated(urdf, states)


def test_joints_of_states_that_the_urdf_lacks_are_warned_of_but_not_virtual_ones(urdf):
    virtual = '<virtual_joint name="v" type="planar" parent_frame="odom" child_link="a"/>'
    assert stated(urdf, virtual + state("arm", ab=0.5, v="1 2 3", root_joint="0")).reference[0] == 0.5
    with pytest.warns(RuntimeWarning, match="'home' gives joints that the URDF does not know: ba, cb; these values"):
        stated(urdf, state("arm", ab=0.5, ba=1, cb=2))


def test_blanks_around_names_are_none_of_them(urdf):
    """As in MoveIt's reader: boost::trim in srdfdom's model.cpp."""
    group = '<group name=" arm"><joint name="ab "/><link name=" c"/><chain base_link=" c" tip_link=" d "/></group>'
    robot = stated(urdf, group + state(" arm ", " home", **{" bc ": " 0.5 "}), "arm")
    assert (robot.joint_names, robot.reference.tolist()) == (("ab", "bc", "cd"), [0.0, 0.5, 0.0])


def test_two_groups_of_one_name_are_refused(urdf):
    twice = '<group name="arm"><joint name="ab"/></group>'
    assert stated(urdf, twice + twice + state("arm", ab=0.5), "arm").joint_names == ("ab",)
    with pytest.raises(pc.PlannercheckError, match="SRDF has 2 groups 'arm', of which MoveIt takes one: keep one"):
        stated(urdf, twice + twice.replace("ab", "bc") + state("arm", ab=0.5), "arm")


@pytest.mark.parametrize(("value", "is_right"), [(0.75, True), (0.7500005, True), (0.76, False)])
def test_values_of_joints_that_follow_the_group_have_to_be_what_follows(urdf, value, is_right):
    follows = '<mimic joint="ab" multiplier="0.5" offset="0.5"/></joint>'
    urdf.write_text(follows.join(urdf.read_text().rsplit("</joint>", 1)))
    elements = GROUPS + state("arm", ab=0.5, de=value)
    assert stated(urdf, elements, ["bc"]).link_poses([0.0])[-1, 0, 0] == pytest.approx(np.cos(0.5 + value))
    with (
        contextlib.nullcontext()
        if is_right
        else pytest.raises(
            pc.PlannercheckError,
            match=r"joint 'de' follows 'ab' of the group, which makes its reference 0\.75, not 0\.76",
        )
    ):
        stated(urdf, elements, "arm")


def test_what_a_group_holds_and_no_joint_moves_is_warned_of(urdf):
    virtual = '<virtual_joint name="v" type="planar" parent_frame="odom" child_link="a"/>'
    loaded(urdf, virtual + '<group name="g"><joint name="v"/><joint name="ab"/></group>')
    with pytest.warns(RuntimeWarning, match="group 'g' has the virtual joint v, which does not move"):
        pc.Robot.from_urdf(urdf, urdf.with_suffix(".srdf"), group="g")
    loaded(urdf, '<group name="g"><Joint name="ab"/><joint name="bc"/></group>', "group 'g' holds <Joint>")
